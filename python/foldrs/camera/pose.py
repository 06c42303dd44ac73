"""Rigid motions between frames in space."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from foldrs.camera._matrices import checked
from foldrs.errors import CalibrationError

Points = npt.NDArray[np.float64]

_RIGID = 1e-3
"""How far a rotation may be from orthonormal: files hold few digits."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Where one frame lies in another: carries points of the first into the second.

    Parameters
    ----------
    matrix : (4, 4) array_like
        [[R, t], [0, 1]]: a rotation, and a translation in metres.

    Raises
    ------
    CalibrationError
        The matrix is no rigid motion.
    """

    matrix: Points

    def __post_init__(self) -> None:
        matrix = checked(self.matrix, (4, 4), "pose")
        turn = matrix[:3, :3]
        rigid = np.abs(turn @ turn.T - np.eye(3)).max() < _RIGID and np.linalg.det(turn) > 0
        if not rigid or not np.allclose(matrix[3], [0, 0, 0, 1]):
            raise CalibrationError(
                "The pose is no rigid motion: give [[R, t], [0, 0, 0, 1]], R a rotation (not a mirror image, "
                "no scale), t in metres.",
                "pose",
            )
        object.__setattr__(self, "matrix", matrix)

    @classmethod
    def of_vectors(cls, rvec: npt.ArrayLike, tvec: npt.ArrayLike) -> Pose:
        """Make a pose of OpenCV's rotation vector (radians) and translation (metres).

        Raises
        ------
        CalibrationError
            They are not three finite numbers each.
        """
        turn = checked(np.ravel(rvec), (3,), "rvec")
        matrix = np.eye(4)
        matrix[:3, :3] = cv2.Rodrigues(np.array(turn))[0]
        matrix[:3, 3] = checked(np.ravel(tvec), (3,), "tvec")
        return cls(matrix)

    def of_table(self, points: Points) -> Points:
        """Carry (n, 2) points of the table, cm, into the other frame: (n, 3), metres."""
        x, y = self.matrix[:3, 0], self.matrix[:3, 1]
        flat = np.asarray(points, dtype=np.float64) / 100.0
        return np.asarray(flat[:, :1] * x + flat[:, 1:] * y + self.matrix[:3, 3], dtype=np.float64)
