"""Checked matrices."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from foldrs.errors import CalibrationError

Matrix = npt.NDArray[np.float64]


def inverse(matrix: npt.ArrayLike) -> Matrix:
    """Return the inverse of a matrix that is known to have one."""
    return np.asarray(np.linalg.inv(np.asarray(matrix, dtype=np.float64)), dtype=np.float64)


def carried(homography: Matrix, points: Matrix) -> Matrix:
    """Carry (n, 2) points by a (3, 3) homography: (n, 3) homogeneous coordinates, the last one the depth.

    Whoever divides by the depth says what becomes of points at the horizon, where it is 0, or beyond.
    """
    return np.asarray(np.column_stack([points, np.ones(len(points))]) @ homography.T, dtype=np.float64)


def checked(values: npt.ArrayLike, shape: tuple[int, ...], field: str) -> Matrix:
    """Return finite numbers of a shape as a new array that cannot be written to.

    Raises
    ------
    CalibrationError
        They are no numbers, not finite, or of another shape.
    """
    size = " x ".join(str(n) for n in shape)
    try:
        matrix = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise CalibrationError(f"{field} holds no numbers: give {size} of them.", field) from None
    if matrix.shape != shape:
        raise CalibrationError(f"{field} has the shape {matrix.shape}: give {size} numbers.", field)
    if not np.isfinite(matrix).all():
        raise CalibrationError(f"{field} holds NaN or infinity: give {size} finite numbers.", field)
    matrix.flags.writeable = False
    return matrix
