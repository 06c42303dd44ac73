"""Reading of photographs and masks, from files or arrays, into one form each.

A photograph is (h, w, 3) uint8 RGB, a mask (h, w) bool with True for cloth; both are C-contiguous.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from .errors import ImageNotFoundError, NotAnImageError

RgbImage: TypeAlias = npt.NDArray[np.uint8]
Mask: TypeAlias = npt.NDArray[np.bool_]
AnyArray: TypeAlias = npt.NDArray[Any]
Source: TypeAlias = str | os.PathLike[str] | npt.ArrayLike | None
"""What a photograph may be given as; None where there is none."""

_JPEG_MAGIC = b"\xff\xd8"


def read_image(path: str | Path) -> RgbImage:
    """Read a photograph: JPEG, PNG, WebP or TIFF, 8 or 16 bit, grey, RGB or RGBA.

    The orientation noted by the camera (EXIF) is honoured; transparent parts are laid on white.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    (h, w, 3) uint8
        RGB.

    Raises
    ------
    ImageNotFoundError
        There is no such file, or it is a folder.
    NotAnImageError
        The file is no image OpenCV can decode.
    """
    return as_rgb(_decode(Path(path)))


def read_any(source: Source) -> RgbImage | None:
    """Bring a photograph, given as a path or an array, into (h, w, 3) uint8 RGB; None if none is given.

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        As :func:`read_image` and :func:`as_rgb`.
    """
    if source is None:
        return None
    return read_image(Path(source)) if isinstance(source, (str, os.PathLike)) else as_rgb(source)


def read_if_any(source: Source) -> RgbImage | None:
    """As :func:`read_any`, but None if it is no image: to show what failed, which may be the reason."""
    try:
        return read_any(source)
    except (NotAnImageError, OSError):
        return None


def read_mask(path: str | Path) -> Mask:
    """Read a mask of the cloth from an image file; see :func:`as_mask` for what counts as cloth.

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        As :func:`read_image`.
    """
    return as_mask(_decode(Path(path)))


def as_rgb(array: npt.ArrayLike) -> RgbImage:
    """Bring an image array of any usual kind into (h, w, 3) uint8 RGB.

    Parameters
    ----------
    array : (h, w), (h, w, 1), (h, w, 3) or (h, w, 4) array_like
        Grey, RGB or RGBA, in any memory layout. Booleans are black and white. Whole numbers span 0..255,
        or 0..65535 if any is above 255; floats span 0..1, or 0..255 if any is above 1. Transparent
        parts are laid on white.

    Returns
    -------
    (h, w, 3) uint8
        RGB, C-contiguous; never a view of `array`.

    Raises
    ------
    NotAnImageError
        Wrong shape or type, no pixels, or values that are not finite or outside these ranges.
    """
    values = _checked(array)
    eight_bit = values if values.dtype == np.uint8 else np.rint(_to_unit(values) * 255).astype(np.uint8)
    if eight_bit.ndim == 2:
        eight_bit = eight_bit[:, :, None]
    if eight_bit.shape[2] == 1:
        return np.repeat(eight_bit, 3, axis=2)
    colour = eight_bit[:, :, :3]
    if eight_bit.shape[2] == 4 and (alpha := eight_bit[:, :, 3:]).min() < 255:
        opacity = alpha.astype(np.float32) / 255
        colour = np.rint(colour * opacity + 255 * (1 - opacity)).astype(np.uint8)
    return np.array(colour, dtype=np.uint8, order="C")


def as_mask(array: npt.ArrayLike) -> Mask:
    """Bring a mask array into (h, w) bool, True for cloth.

    Parameters
    ----------
    array : (h, w), (h, w, 1), (h, w, 3) or (h, w, 4) array_like
        Booleans, or numbers of which those above half of the largest are cloth: 0/1 and 0/255 both
        work, and so does a mask with smoothed or compressed edges. Of RGBA the alpha channel is the
        mask if the colour is the same everywhere, otherwise the colour is.

    Returns
    -------
    (h, w) bool
        C-contiguous; never a view of `array`.

    Raises
    ------
    NotAnImageError
        As :func:`as_rgb`.
    """
    values = _checked(array)
    if values.ndim == 3:
        colour = values[:, :, :3]
        if values.shape[2] == 4 and (colour == colour[:1, :1]).all():
            colour = values[:, :, 3:]
        values = colour.max(axis=2)
    if values.dtype != np.bool_:
        values = values > values.max() / 2
    return np.array(values, dtype=np.bool_, order="C")


def _checked(array: npt.ArrayLike) -> AnyArray:
    """`array` as an array of an image's shape, with finite numbers that are not negative."""
    values = np.asarray(array)
    if values.dtype.kind not in "buif":
        raise NotAnImageError(
            f"An image holds real numbers, this array holds {values.dtype}: pass whole numbers or floats."
        )
    if values.ndim not in (2, 3) or (values.ndim == 3 and values.shape[2] not in (1, 3, 4)):
        raise NotAnImageError(
            f"An image has the shape (h, w), (h, w, 1), (h, w, 3) or (h, w, 4), this array {values.shape}: "
            "put the channels last and pass one image at a time."
        )
    if values.size == 0:
        raise NotAnImageError(f"The image array is empty, its shape is {values.shape}: pass one with pixels.")
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise NotAnImageError("The image array holds NaN or infinity: replace these values.")
    if values.dtype != np.bool_ and values.min() < 0:
        raise NotAnImageError(f"The image array holds negative values ({values.min()}): scale to 0..255.")
    return values


def _to_unit(values: AnyArray) -> npt.NDArray[np.float32]:
    """Scale checked values to floats in 0..1."""
    if values.dtype == np.bool_:
        return values.astype(np.float32)
    largest = float(values.max())
    ranges = (1.0, 255.0) if values.dtype.kind == "f" else (255.0, 65535.0)
    for full in ranges:
        if largest <= full:
            return np.divide(values, full, dtype=np.float32)
    raise NotAnImageError(
        f"The image array's largest value is {largest:g}, {values.dtype} images may hold at most "
        f"{ranges[-1]:g}: scale it down."
    )


def _decode(path: Path) -> AnyArray:
    """Read the file's pixels at their own depth: RGB, with alpha where there is any."""
    if not path.exists():
        raise ImageNotFoundError(f"There is no file {path}: check the name.")
    if path.is_dir():
        raise ImageNotFoundError(f"{path} is a folder: pass an image file.")
    # Decoding from memory works for every file name, OpenCV's own file access does not on all systems.
    data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    bgr = _imdecode(data, cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH)
    if bgr is None:
        raise NotAnImageError(f"{path} cannot be read as an image: pass a JPEG, PNG, WebP or TIFF file.")
    colour = bgr[:, :, ::-1]
    if data[:2].tobytes() == _JPEG_MAGIC:
        return colour
    # OpenCV gives alpha only with "unchanged", which leaves the EXIF orientation out: where the two
    # readings differ the picture was turned, and its alpha, which would have to turn too, is let go.
    unchanged = _imdecode(data, cv2.IMREAD_UNCHANGED)
    has_alpha = unchanged is not None and unchanged.ndim == 3 and unchanged.shape[2] == 4
    if unchanged is not None and has_alpha and np.array_equal(unchanged[:, :, :3], bgr):
        return np.dstack([colour, unchanged[:, :, 3]])
    return colour


def _imdecode(data: npt.NDArray[np.uint8], flags: int) -> AnyArray | None:
    """Decode an image file held in memory; None where it is none."""
    if data.size == 0:
        return None
    try:
        return cv2.imdecode(data, flags)
    except cv2.error:  # raised for instance beyond OpenCV's limit of pixels
        return None
