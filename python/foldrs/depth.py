"""Depth images: how high everything lies above the table, and the garment told by that.

A depth image lies pixel on pixel with the photograph and holds the distance along the camera's axis. Of a
plane seen by a pinhole the reciprocal of that distance is linear over the (undistorted) picture, whatever the
focal length, so the table is found without knowing the camera.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from foldrs._image_headers import can_be_decoded, check_size
from foldrs.camera._matrices import inverse
from foldrs.camera.pinhole import Camera
from foldrs.camera.plane import TablePlane
from foldrs.errors import DepthError, SeveralGarmentsError
from foldrs.image import Mask, imdecode
from foldrs.parameters import DepthParameters, OutlineParameters
from foldrs.segmentation.masks import largest_part, resized, single_object, tidied

FloatImage = npt.NDArray[np.float32]

_MILLIMETRE = 0.001
_ROUNDS = 2  # of fitting the plane to what does not stand out from it
_NORMAL = 1.4826  # spread of a normal distribution, median deviations


@dataclass(frozen=True, eq=False)
class Heights:
    """How high everything lies above the table."""

    above: FloatImage
    """(h, w): height, in spreads of the table's own after `DepthParameters.blur`; 0 where unknown. As
    large as the photograph or smaller."""
    inverse_depth: npt.NDArray[np.float64]
    """(3,): 1 / depth of the table is their product with (x, y, 1), 1/m; x and y are ideal px."""

    def plane(self, camera: Camera) -> TablePlane:
        """Tell the table's plane, for a camera whose intrinsic parameters are known.

        The frame's origin is where the camera's axis meets the table; x runs to the right of the picture and
        z out of the table.
        """
        normal = camera.matrix.T @ self.inverse_depth  # n . P = 1 for points P of the table, metres
        distance = 1.0 / float(np.linalg.norm(normal))
        z = -normal * distance
        x = np.cross([0.0, 1.0, 0.0], -z)
        x /= np.linalg.norm(x)
        y = np.cross(z, x)
        origin = np.array([0.0, 0.0, 1.0 / normal[2]])
        columns = np.column_stack([x / 100.0, y / 100.0, origin])
        return TablePlane(inverse(camera.matrix @ columns), camera)


def read_depth(
    source: str | os.PathLike[str] | npt.ArrayLike, max_pixels: int | None = OutlineParameters.max_pixels
) -> FloatImage:
    """Read a depth image.

    Parameters
    ----------
    source : path or (h, w) array_like
        A PNG or TIFF file, ``.npy``, or an array. Whole numbers are millimetres, floats metres.
    max_pixels : int, optional
        Most pixels that a file may have, as photographs by default; None: any number.

    Returns
    -------
    (h, w) float32
        Metres; NaN where nothing was measured (0, negative or not finite).

    Raises
    ------
    DepthError
        There is no such file, it cannot be read, or there is no depth image in it.
    ImageTooLargeError
        The header of a file tells of more pixels than allowed; the rest is not read then.
    """
    if isinstance(source, str | os.PathLike):
        values = _file_content(Path(source), max_pixels)
        named = f"{source}: "
    else:
        values, named = np.asarray(source), ""
    if values.ndim == 3 and values.shape[2] == 1:
        values = values[:, :, 0]
    if values.ndim != 2 or values.size == 0 or values.dtype.kind not in "uif" or values.dtype == np.uint8:
        raise DepthError(
            f"{named}A depth image has the shape (h, w) and holds 16-bit whole numbers (mm) or floats (m), "
            f"this has {values.shape} and holds {values.dtype}."
        )
    metres = values.astype(np.float32) * np.float32(1.0 if values.dtype.kind == "f" else _MILLIMETRE)
    metres = np.where(np.isfinite(metres) & (metres > 0), metres, np.float32(np.nan))
    if np.isnan(metres).all():
        raise DepthError(f"{named}The depth image holds no measurement: all of it is 0 or not finite.")
    return np.asarray(metres, dtype=np.float32)


def heights_above_table(depth: FloatImage, camera: Camera | None, parameters: DepthParameters) -> Heights:
    """Find the table's plane in a depth image, and how high everything lies above it.

    Parameters
    ----------
    depth : (h, w) float32
        Metres, NaN where unknown, see :func:`read_depth`.
    camera : Camera, optional
        Whose lens distorts the picture.
    parameters : DepthParameters

    Raises
    ------
    DepthError
        No plane covers enough of the picture.
    """
    step = max(1, round(max(depth.shape) / parameters.side))
    small = depth[step // 2 :: step, step // 2 :: step]
    y, x = np.mgrid[0 : small.shape[0], 0 : small.shape[1]].reshape(2, -1) * float(step) + step // 2
    pixels = np.column_stack([x, y])
    ideal = np.column_stack([pixels if camera is None else camera.undistorted(pixels), np.ones(len(pixels))])
    flat = small.ravel().astype(np.float64)
    known = np.isfinite(flat)

    coefficients = _table(ideal[known], flat[known], parameters)
    table = known.copy()
    for _ in range(_ROUNDS):
        above = _smooth_heights(1.0 - flat * (ideal @ coefficients), known, small.shape, parameters.blur)
        inner = np.abs(above - np.median(above[known])) < parameters.tolerance
        spread = _NORMAL * float(np.median(np.abs(above[inner & known]))) + 1e-7
        table = known & (np.abs(above) < parameters.clear * spread)
        coefficients = _least_squares(ideal[table], flat[table])
    above = _smooth_heights(1.0 - flat * (ideal @ coefficients), known, small.shape, parameters.blur)
    spread = _NORMAL * float(np.median(np.abs(above[table]))) + 1e-7
    return Heights((above / spread).reshape(small.shape).astype(np.float32), coefficients)


def cloth_by_height(
    heights: Heights, shape: tuple[int, int], parameters: DepthParameters, outline: OutlineParameters
) -> Mask | None:
    """Tell the garment by its height; None if it does not stand out clearly.

    Parameters
    ----------
    heights : Heights
    shape : (h, w)
        Of the photograph.
    parameters : DepthParameters
    outline : OutlineParameters
        How gaps and threads are treated.
    """
    above = heights.above
    mask = tidied(above > parameters.clear, outline.opening)
    if mask.mean() < outline.least_share or mask.mean() > outline.most_share:
        return None
    try:
        mask = single_object(mask, outline, outline.merge_gap)
    except SeveralGarmentsError:  # or one that is so thin that it falls apart: the colours may tell
        return None
    if float(np.median(above[mask])) < parameters.sure:
        return None
    # Blurred, the rim lies where half of the cloth's height is reached.
    single = float(np.percentile(above[mask], 25))
    near = cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    placed = tidied(near & (above > max(parameters.clear, single / 2)), outline.opening)
    return resized(largest_part(placed), shape)


def resized_heights(above: FloatImage, shape: tuple[int, int]) -> FloatImage:
    """Bring heights to the photograph's size (h, w)."""
    if above.shape == shape:
        return above
    return np.asarray(cv2.resize(above, shape[::-1], interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def _file_content(path: Path, max_pixels: int | None) -> npt.NDArray[Any]:
    try:
        if not path.is_file():
            raise DepthError(f"{path}: there is no such depth image.")
        if path.suffix.lower() == ".npy":
            return _numpy_content(path, max_pixels)
        content = path.read_bytes()
    except OSError as error:
        raise DepthError(
            f"{path}: cannot be read ({error.strerror or error}): check the name and that you may read it."
        ) from error
    readable = can_be_decoded(content, max_pixels, str(path))
    decoded = imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED) if readable else None
    if decoded is None:
        raise DepthError(f"{path}: is no image: give a PNG or TIFF of 16 bits or floats, or a .npy file.")
    return np.asarray(decoded)


def _numpy_content(path: Path, max_pixels: int | None) -> npt.NDArray[Any]:
    try:
        # Nothing but the header is read yet.
        mapped = np.asanyarray(np.load(path, mmap_mode="r", allow_pickle=False))
    except (ValueError, EOFError) as error:
        raise DepthError(f"{path}: is no NumPy array ({error}).") from None
    if mapped.ndim > 1:
        check_size(mapped.shape[1], mapped.shape[0], max_pixels, str(path))
    return np.array(mapped)


class _InverseDepth:
    """The table as RANSAC takes it: rows are (x, y, 1, depth)."""

    def __init__(self) -> None:
        self.coefficients = np.zeros(3)

    @classmethod
    def from_estimate(cls, data: npt.NDArray[np.float64]) -> _InverseDepth:
        """Fit a plane to points."""
        model = cls()
        model.estimate(data)
        return model

    def estimate(self, data: npt.NDArray[np.float64]) -> bool:
        """Fit a plane to points, as older versions of scikit-image ask for it."""
        self.coefficients = _least_squares(data[:, :3], data[:, 3])
        return True

    def residuals(self, data: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Distances from it, as shares of the depth."""
        return np.asarray(np.abs(1.0 - data[:, 3] * (data[:, :3] @ self.coefficients)))


def _table(
    ideal: npt.NDArray[np.float64], depth: npt.NDArray[np.float64], parameters: DepthParameters
) -> npt.NDArray[np.float64]:
    """Find the plane most pixels lie on, by RANSAC."""
    from skimage import measure  # slow to import

    ransac: Callable[..., Any] = measure.ransac
    sample = np.column_stack([ideal, depth])[:: max(1, len(depth) // parameters.samples)]
    if len(sample) < 3:
        raise DepthError("The depth image holds hardly a measurement: make a new one.")
    model, inliers = ransac(
        sample,
        _InverseDepth,
        min_samples=3,
        residual_threshold=parameters.tolerance,
        max_trials=parameters.trials,
        rng=np.random.default_rng(parameters.seed),
    )
    if inliers is None or np.mean(inliers) < parameters.least_table:
        raise DepthError("The depth image shows no table: no plane covers enough of it.")
    coefficients: npt.NDArray[np.float64] = model.coefficients
    return coefficients


def _least_squares(ideal: npt.NDArray[np.float64], depth: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Coefficients of 1 / depth; distances count as shares of the depth."""
    return np.asarray(np.linalg.lstsq(ideal * depth[:, None], np.ones(len(depth)), rcond=None)[0])


def _smooth_heights(
    heights: npt.NDArray[np.float64], known: npt.NDArray[np.bool_], shape: tuple[int, ...], blur: float
) -> npt.NDArray[np.float64]:
    """Blur heights; unknown ones count for nothing, and are 0 where nothing is known near by."""
    weight = known.reshape(shape).astype(np.float64)
    values = np.where(known, np.nan_to_num(heights), 0.0).reshape(shape)
    total = cv2.GaussianBlur(values, (0, 0), blur)
    count = cv2.GaussianBlur(weight, (0, 0), blur)
    return np.asarray(np.where(count > 0.1, total / np.maximum(count, 0.1), 0.0)).ravel()
