"""Reading of homographies, cameras and poses.

Every file may be JSON, YAML, plain numbers (rows of a matrix) or ``.npy``. Matrices within JSON and YAML are
nested lists, or ``rows``, ``cols`` and ``data`` as ROS and OpenCV's ``FileStorage`` write them. Names of
fields are read whatever their case and underscores.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from foldrs.camera._fields import first_of, metres, numbers_of, read_fields
from foldrs.camera.pinhole import Camera
from foldrs.camera.plane import TablePlane
from foldrs.camera.pose import Pose
from foldrs.errors import CalibrationError

FilePath = str | os.PathLike[str]

_HOMOGRAPHY = ("homography", "h", "matrix")
_CAMERA = ("cameramatrix", "k", "intrinsics", "intrinsicmatrix")
_DISTORTION = ("distortioncoefficients", "distcoeffs", "distortion", "d")
_DISTORTION_FIELD = "distortion_coefficients"
_POSE = ("tablepose", "tableincamera", "tableinbase", "pose", "transform", "extrinsics", "matrix")
_TURN = ("rvec", "rotationvector")
_OFFSET = ("tvec", "translationvector")
_PINHOLE_MODELS = ("plumb_bob", "rational_polynomial", "radtan")


def load_homography(path: FilePath) -> TablePlane:
    """Read the homography from image px to cm on the table.

    Parameters
    ----------
    path : path
        A file that is the 3 x 3 matrix, or has it as field ``homography``.

    Raises
    ------
    CalibrationError
        The file holds no homography; the sentence names file and field.
    """
    path = Path(path)
    fields = read_fields(path)
    value = first_of(fields, _HOMOGRAPHY) if isinstance(fields, Mapping) else fields
    if value is None:
        raise CalibrationError(f"{path}: has no field homography: give the 3 x 3 matrix.", "homography")
    matrix = numbers_of(value, "homography", path)
    try:
        return TablePlane(matrix.reshape(3, 3) if matrix.size == 9 else matrix)
    except CalibrationError as error:
        raise _of_file(error, path) from None


def load_camera(path: FilePath) -> tuple[Camera, Pose | None]:
    """Read a camera, and the pose of the table before it if the file has one.

    Parameters
    ----------
    path : path
        ROS's ``camera_info`` YAML, or OpenCV's calibration as YAML or JSON: ``camera_matrix``,
        ``distortion_coefficients``, ``image_width`` and ``image_height``; for the table's pose in the
        camera's frame ``rvec`` and ``tvec``, or the 4 x 4 matrix ``table_pose``, in metres unless ``units``
        says ``cm`` or ``mm``.

    Returns
    -------
    camera : Camera
    table_in_camera : Pose or None

    Raises
    ------
    CalibrationError
        The file holds no camera, or one with a lens model that is not supported; names file and field.
    """
    path = Path(path)
    fields = read_fields(path)
    matrix = first_of(fields, _CAMERA) if isinstance(fields, Mapping) else None
    if not isinstance(fields, Mapping) or matrix is None:
        raise CalibrationError(
            f"{path}: has no field camera_matrix: give a camera_info YAML of ROS or OpenCV's calibration.",
            "camera_matrix",
        )
    model = fields.get("distortionmodel", "plumb_bob")
    if model not in _PINHOLE_MODELS:
        raise CalibrationError(
            f"{path}: distortion_model is {model!r}, supported are {', '.join(_PINHOLE_MODELS)}: undistort "
            "the photographs first and leave it out.",
            "distortion_model",
        )
    intrinsic = numbers_of(matrix, "camera_matrix", path)
    distortion = first_of(fields, _DISTORTION)
    try:
        camera = Camera(
            intrinsic.reshape(3, 3) if intrinsic.size == 9 else intrinsic,
            np.zeros(0) if distortion is None else numbers_of(distortion, _DISTORTION_FIELD, path).ravel(),
            _size(fields, path),
        )
    except CalibrationError as error:
        raise _of_file(error, path) from None
    return camera, _pose(fields, path)


def load_pose(path: FilePath) -> Pose:
    """Read where one frame lies in another: the table in the camera's frame, or in the robot's base.

    Parameters
    ----------
    path : path
        A file that is the 4 x 4 matrix, or has it as field ``pose``, ``table_pose`` or ``transform``, or has
        ``rvec`` and ``tvec``; metres, or what its field ``units`` says (``m``, ``cm``, ``mm``).

    Raises
    ------
    CalibrationError
        The file holds no rigid motion; names file and field.
    """
    path = Path(path)
    fields = read_fields(path)
    pose = _pose(fields if isinstance(fields, Mapping) else {"matrix": fields}, path)
    if pose is None:
        raise CalibrationError(
            f"{path}: holds no pose: give a 4 x 4 matrix, or the fields rvec and tvec.", "pose"
        )
    return pose


def _pose(fields: Mapping[str, Any], path: Path) -> Pose | None:
    """Find the pose among the fields of a file, in metres; None if there is none."""
    turn, offset, matrix = (first_of(fields, names) for names in (_TURN, _OFFSET, _POSE))
    if matrix is None and turn is None and offset is None:
        return None
    scale = metres(fields, path)
    try:
        if matrix is not None:
            whole = numbers_of(matrix, "pose", path)
            whole = np.array(whole.reshape(4, 4) if whole.size == 16 else whole)
            if whole.shape == (4, 4):
                whole[:3, 3] *= scale
            return Pose(whole)
        if turn is None or offset is None:
            missing = "rvec" if turn is None else "tvec"
            raise CalibrationError(f"{missing} is missing: a pose needs both rvec and tvec.", missing)
        return Pose.of_vectors(numbers_of(turn, "rvec", path), numbers_of(offset, "tvec", path) * scale)
    except CalibrationError as error:
        raise _of_file(error, path) from None


def _size(fields: Mapping[str, Any], path: Path) -> tuple[int, int] | None:
    """Size of the pictures the camera was calibrated with, if the file says."""
    values = [first_of(fields, (f"image{side}", side)) for side in ("width", "height")]
    if None in values:
        return None
    try:
        width, height = (int(value) for value in values)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise CalibrationError(
            f"{path}: image_width and image_height are {values}: give two whole numbers of px.", "image_width"
        ) from None
    return width, height


def _of_file(error: CalibrationError, path: Path) -> CalibrationError:
    """Make the same error, its sentence beginning with the file's name."""
    text = str(error)
    return CalibrationError(text if text.startswith(f"{path}:") else f"{path}: {text}", error.field)
