"""The camera: a pinhole with the distortion of its lens."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
import numpy.typing as npt

from foldrs.camera._matrices import carried, checked, inverse
from foldrs.errors import CalibrationError

Points = npt.NDArray[np.float64]

_COEFFICIENTS = (0, 4, 5, 8, 12, 14)
"""Numbers of coefficients that OpenCV's models of distortion have."""

_STRAIGHTENING = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)
"""When the iteration that takes distortion off may stop: far below a pixel."""


@dataclass(frozen=True, eq=False)
class Camera:
    """Intrinsic parameters of a camera, as OpenCV's ``calibrateCamera`` and ROS's ``camera_info`` give them.

    An *ideal* pixel is one of the same camera without the distortion of its lens.

    Parameters
    ----------
    matrix : (3, 3) array_like
        Focal lengths and principal point: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], px.
    distortion : (n,) array_like
        k1, k2, p1, p2[, k3[, k4, k5, k6[, s1, s2, s3, s4[, tx, ty]]]], in this order.
    size : (width, height), optional
        Of the pictures it was calibrated with, px; others are refused.

    Raises
    ------
    CalibrationError
        These are no intrinsic parameters; names the field.
    """

    matrix: Points
    distortion: Points = field(default_factory=lambda: np.zeros(0))
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        matrix = checked(self.matrix, (3, 3), "camera_matrix")
        if min(matrix[0, 0], matrix[1, 1]) <= 0 or not np.allclose(
            matrix[[1, 2, 2, 2], [0, 0, 1, 2]], [0, 0, 0, 1]
        ):
            raise CalibrationError(
                "camera_matrix is no matrix of intrinsic parameters: give "
                "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with positive focal lengths, in px.",
                "camera_matrix",
            )
        count = np.size(self.distortion)
        if count not in _COEFFICIENTS:
            raise CalibrationError(
                f"distortion_coefficients holds {count} numbers: give 4, 5, 8, 12 or 14, or none.",
                "distortion_coefficients",
            )
        distortion = checked(np.ravel(self.distortion), (count,), "distortion_coefficients")
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "distortion", distortion)

    def undistorted(self, points: Points) -> Points:
        """Take the lens's distortion off: (n, 2) px of the photograph to ideal ones."""
        if not self.distortion.any() or len(points) == 0:
            return np.array(points, dtype=np.float64)
        image = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 1, 2)
        ideal = cv2.undistortImagePoints(image, self.matrix, self.distortion, None, _STRAIGHTENING)
        return np.asarray(ideal, dtype=np.float64).reshape(-1, 2)

    def distorted(self, points: Points) -> Points:
        """Put the lens's distortion on: (n, 2) ideal px to those of the photograph."""
        if not self.distortion.any() or len(points) == 0:
            return np.array(points, dtype=np.float64)
        rays = carried(inverse(self.matrix), points)
        still = np.zeros(3)
        image, _ = cv2.projectPoints(rays, still, still, self.matrix, self.distortion)
        return np.asarray(image, dtype=np.float64).reshape(-1, 2)

    def check_size(self, width: int, height: int) -> None:
        """Raise CalibrationError unless pictures of this size are those it was calibrated with."""
        if self.size not in (None, (width, height)):
            raise CalibrationError(
                f"The camera was calibrated with pictures of {self.size[0]} x {self.size[1]} px, the "
                f"photograph has {width} x {height}: use one of that size, or a calibration of this one.",
                "image_width",
            )
