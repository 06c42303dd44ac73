"""The table: a plane, and the way between the photograph and centimetres on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from foldrs.camera._matrices import carried, checked, inverse
from foldrs.camera.pinhole import Camera
from foldrs.camera.pose import Pose
from foldrs.errors import CalibrationError

Points = npt.NDArray[np.float64]

_SINGULAR = 1e-12
"""Reciprocal condition, rows and columns brought to one size, below which a homography has no inverse."""


@dataclass(frozen=True, eq=False)
class TablePlane:
    """The plane of the table as a camera sees it.

    Parameters
    ----------
    homography : (3, 3) array_like
        From image px (ideal ones, if there is a camera) to cm on the table; its scale does not matter.
    camera : Camera, optional
        Whose lens distorts the picture; without it the picture is taken to be free of distortion.

    Raises
    ------
    CalibrationError
        The homography is none, or has no inverse.

    Examples
    --------
    Seen from straight above at 4 px/cm, the origin at the first pixel:

    >>> plane = TablePlane([[0.25, 0, 0], [0, 0.25, 0], [0, 0, 1]])
    >>> plane.to_table([[400.0, 200.0]])
    array([[100.,  50.]])
    """

    homography: Points
    camera: Camera | None = None

    def __post_init__(self) -> None:
        matrix = checked(self.homography, (3, 3), "homography")
        balanced = _balanced(matrix)
        if balanced is None or np.linalg.cond(balanced) > 1 / _SINGULAR:
            raise CalibrationError(
                "The homography has no inverse: give the 3 x 3 matrix from image px to table cm.",
                "homography",
            )
        object.__setattr__(self, "homography", matrix)

    @classmethod
    def of_pose(cls, camera: Camera, table_in_camera: Pose) -> TablePlane:
        """Make the plane z = 0 of a frame whose pose before a camera is known.

        Parameters
        ----------
        camera : Camera
        table_in_camera : Pose
            Carries points of the table's frame into the camera's, as OpenCV's ``solvePnP`` gives it.

        Raises
        ------
        CalibrationError
            The table's origin lies behind the camera, or the camera lies in the plane of the table.
        """
        pose = table_in_camera.matrix
        if pose[2, 3] <= 0:
            raise CalibrationError(
                "The table's origin lies behind the camera: give the pose of the table in the camera's "
                "frame, not that of the camera.",
                "tvec",
            )
        columns = np.column_stack([pose[:3, 0] / 100.0, pose[:3, 1] / 100.0, pose[:3, 3]])
        to_image = camera.matrix @ columns
        if abs(np.linalg.det(columns)) < _SINGULAR:
            raise CalibrationError("The camera lies in the plane of the table: check its pose.", "rvec")
        return cls(inverse(to_image), camera)

    def to_table(self, points: npt.ArrayLike) -> Points:
        """Carry (n, 2) px of the photograph to the table, cm.

        Raises
        ------
        CalibrationError
            Points lie on both sides of the horizon, so not all of them on the table.
        """
        image = np.asarray(points, dtype=np.float64)
        ideal = image if self.camera is None else self.camera.undistorted(image)
        return _carried(self.homography, ideal)

    def to_image(self, points: npt.ArrayLike) -> Points:
        """Carry (n, 2) points of the table, cm, to px of the photograph.

        Raises
        ------
        CalibrationError
            Points lie before and behind the camera.
        """
        ideal = _carried(inverse(self.homography), np.asarray(points, dtype=np.float64))
        return ideal if self.camera is None else self.camera.distorted(ideal)

    def table_axes(self, point: npt.ArrayLike) -> Points:
        """How the image changes with the table at a point of it: (2, 2) px a cm, a column an axis."""
        x, y = np.asarray(point, dtype=np.float64)
        step = 0.05  # cm: short against what perspective changes, long against rounding
        beside = np.array([[x + step, y], [x, y + step], [x - step, y], [x, y - step]])
        there = self.to_image(beside)
        return np.asarray((there[:2] - there[2:]).T / (2 * step), dtype=np.float64)


def _carried(homography: Points, points: Points) -> Points:
    """Apply a homography to points that must not lie on both sides of its horizon."""
    flat = points.reshape(-1, 2)
    there = carried(homography, flat)
    depth = there[:, 2]
    if len(flat) and not ((depth > 0).all() or (depth < 0).all()):
        raise CalibrationError(
            "Part of the outline lies at or beyond the table's horizon: the homography or pose does not go "
            "with this photograph.",
            "homography",
        )
    return np.asarray(there[:, :2] / depth[:, None], dtype=np.float64)


def _balanced(matrix: Points) -> Points | None:
    """Bring rows and columns to size one, in turns, so that units do not matter; None if one is empty."""
    balanced = np.array(matrix)
    for _ in range(3):
        for axis in (0, 1):
            size = np.abs(balanced).max(axis=axis, keepdims=True)
            if not (size > 0).all():
                return None
            balanced = balanced / size
    return balanced
