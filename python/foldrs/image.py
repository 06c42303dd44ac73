"""Reading of photographs and masks, from files or arrays, into one form each.

A photograph is (h, w, 3) uint8 RGB, a mask (h, w) bool with True for cloth; both are C-contiguous.
"""

from __future__ import annotations

import errno
import os
import re
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from . import _image_headers as headers
from ._image_headers import can_be_decoded, check_size
from .errors import ImageNotFoundError, NotAnImageError
from .parameters import OutlineParameters

RgbImage: TypeAlias = npt.NDArray[np.uint8]
Mask: TypeAlias = npt.NDArray[np.bool_]
AnyArray: TypeAlias = npt.NDArray[Any]
Source: TypeAlias = str | os.PathLike[str] | npt.ArrayLike | None
"""What a photograph may be given as; None where there is none."""

_ROWS = 256
"""Rows of a picture converted at a time."""

_PILLOW_ARRAYS = ("L", "RGB", "RGBA", "I", "I;16", "I;16L", "I;16B", "I;16N", "F")
"""Modes of Pillow's images whose arrays are grey, RGB or RGBA as they are."""

_URL = re.compile(r"(https?|ftp|file|s3|gs):[/\\]|data:", re.IGNORECASE)


def read_image(path: str | os.PathLike[str], max_pixels: int | None = None) -> RgbImage:
    """Read a photograph: JPEG, PNG, WebP or TIFF, 8 or 16 bit, grey, RGB or RGBA.

    The orientation noted by the camera (EXIF) is honoured; transparent parts are laid on white.

    Parameters
    ----------
    path : path
        The file.
    max_pixels : int, optional
        Most pixels it may have; any number without it.

    Returns
    -------
    (h, w, 3) uint8
        RGB.

    Raises
    ------
    ImageNotFoundError
        There is no such file, there can be none of that name, or it is a folder.
    ImageTooLargeError
        Its header tells of more pixels than allowed; it is not decoded then.
    NotAnImageError
        The file cannot be read, for instance for want of permission, or is no image OpenCV can decode.
    """
    return as_rgb(_decode(path, max_pixels), max_pixels)


def read_any(source: Source, max_pixels: int | None = None) -> RgbImage | None:
    """Bring a photograph, given as a path or an array, into (h, w, 3) uint8 RGB; None if none is given.

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        As :func:`read_image` and :func:`as_rgb`.
    """
    if source is None:
        return None
    if isinstance(source, (str, os.PathLike)):
        return read_image(source, max_pixels)
    return as_rgb(source, max_pixels)


def read_if_any(source: Source) -> RgbImage | None:
    """As :func:`read_any`, but None if it is no image: to show what failed, which may be the reason.

    Neither is one with more pixels than :func:`foldrs.fit` takes unless it is told to.
    """
    try:
        return read_any(source, OutlineParameters.max_pixels)
    except (NotAnImageError, OSError):
        return None


def read_mask(path: str | os.PathLike[str], max_pixels: int | None = None) -> Mask:
    """Read a mask of the cloth from an image file; see :func:`as_mask` for what counts as cloth.

    Raises
    ------
    ImageNotFoundError, ImageTooLargeError, NotAnImageError
        As :func:`read_image`.
    """
    return as_mask(_decode(path, max_pixels))


def as_rgb(array: npt.ArrayLike, max_pixels: int | None = None) -> RgbImage:
    """Bring an image array of any usual kind into (h, w, 3) uint8 RGB.

    Parameters
    ----------
    array : (h, w), (h, w, 1), (h, w, 3) or (h, w, 4) array_like, or Pillow image
        Grey, RGB or RGBA, in any memory layout; a Pillow image of any mode is taken as its file would be.
        Booleans are black and white. Whole numbers span 0..255, or 0..65535 if any is above 255; floats
        span 0..1, or 0..255 if any is above 1. Transparent parts are laid on white.
    max_pixels : int, optional
        Most pixels it may have; any number without it.

    Returns
    -------
    (h, w, 3) uint8
        RGB, C-contiguous; never a view of `array`.

    Raises
    ------
    ImageTooLargeError
        More pixels than allowed.
    NotAnImageError
        Wrong shape or type, no pixels, or values that are not finite or outside these ranges.
    """
    values = _checked(array)
    check_size(values.shape[1], values.shape[0], max_pixels, "The image array")
    channels = 1 if values.ndim == 2 else values.shape[2]
    largest = float(values.max())
    rgb = np.empty((*values.shape[:2], 3), dtype=np.uint8)
    # Some rows at a time: floats of a whole photograph take many times its memory.
    for top in range(0, len(values), _ROWS):
        rows = values[top : top + _ROWS].reshape(-1, values.shape[1], channels)
        if rows.dtype != np.uint8:
            rows = np.rint(_to_unit(rows, largest) * 255).astype(np.uint8)
        colour = rows[:, :, :3]  # of one channel, the same for all three
        if channels == 4 and (alpha := rows[:, :, 3:]).min() < 255:
            opacity = alpha.astype(np.float32) / 255
            colour = np.rint(colour * opacity + 255 * (1 - opacity)).astype(np.uint8)
        rgb[top : top + _ROWS] = colour
    return rgb


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
    values = _pillow_array(array) if is_pillow(array) else np.asarray(array)
    if values.dtype.kind not in "buif":
        raise NotAnImageError(
            f"An image holds real numbers, this array holds {values.dtype}: pass whole numbers or floats."
        )
    if values.ndim not in (2, 3) or (values.ndim == 3 and values.shape[2] not in (1, 3, 4)):
        raise NotAnImageError(
            f"An image has the shape (h, w), (h, w, 1), (h, w, 3) or (h, w, 4), this array {values.shape}: "
            "put the channels last and pass one image at a time; an outline has the shape (n, 2)."
        )
    if values.size == 0:
        raise NotAnImageError(f"The image array is empty, its shape is {values.shape}: pass one with pixels.")
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise NotAnImageError("The image array holds NaN or infinity: replace these values.")
    if values.dtype != np.bool_ and values.min() < 0:
        raise NotAnImageError(f"The image array holds negative values ({values.min()}): scale to 0..255.")
    return values


def _to_unit(values: AnyArray, largest: float) -> npt.NDArray[np.float32]:
    """Scale checked values, of an image whose largest is given, to floats in 0..1."""
    if values.dtype == np.bool_:
        return values.astype(np.float32)
    ranges = (1.0, 255.0) if values.dtype.kind == "f" else (255.0, 65535.0)
    for full in ranges:
        if largest <= full:
            return np.divide(values, full, dtype=np.float32)
    raise NotAnImageError(
        f"The image array's largest value is {largest:g}, {values.dtype} images may hold at most "
        f"{ranges[-1]:g}: scale it down."
    )


def is_pillow(source: object) -> bool:
    """Whether something is an image of Pillow's, which need not be installed."""
    return any((kind.__module__, kind.__name__) == ("PIL.Image", "Image") for kind in type(source).__mro__)


def _pillow_array(image: Any) -> AnyArray:
    """Turn an image of Pillow's into what reading its file gives: upright, grey, RGB or RGBA."""
    from PIL import ImageOps

    try:
        upright = ImageOps.exif_transpose(image)
        if upright.mode in ("LA", "PA") or (upright.mode in ("P", "RGB") and "transparency" in upright.info):
            upright = upright.convert("RGBA")
        elif upright.mode == "1":
            upright = upright.convert("L")
        elif upright.mode not in _PILLOW_ARRAYS:
            upright = upright.convert("RGB")
    except (OSError, SyntaxError, ValueError) as error:  # a file cut short, colours Pillow cannot convert
        raise NotAnImageError(
            f"Pillow cannot read this {image.mode} image ({error}): pass another."
        ) from error
    return np.asarray(upright)


def _decode(path: str | os.PathLike[str], max_pixels: int | None) -> AnyArray:
    """Read the file's pixels at their own depth: RGB, with alpha where there is any."""
    _check_name(os.fspath(path))
    path = Path(path)
    # Decoding from memory works for every file name, OpenCV's own file access does not on all systems.
    content = _content(path)
    data = np.frombuffer(content, dtype=np.uint8)
    readable = can_be_decoded(content, max_pixels, str(path))
    if headers.is_floating_point_tiff(content):
        raise NotAnImageError(
            f"{path} is a floating-point TIFF, which is not read: save it with whole numbers of 8 or 16 bits."
        )
    # Alpha comes with "unchanged" only, which leaves the orientation out: then the picture is turned here.
    turned_here = headers.is_png(content) or headers.is_webp(content)
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH | (cv2.IMREAD_IGNORE_ORIENTATION if turned_here else 0)
    bgr = imdecode(data, flags) if readable else None
    if bgr is None:
        raise NotAnImageError(f"{path} cannot be read as an image: pass a JPEG, PNG, WebP or TIFF file.")
    colour = bgr[:, :, ::-1]
    if headers.is_jpeg(content):
        return colour
    unchanged = imdecode(data, cv2.IMREAD_UNCHANGED)
    if unchanged is not None and unchanged.shape == (*colour.shape[:2], 4):
        colour = np.dstack([colour, unchanged[:, :, 3]])
    return _turned(colour, headers.orientation(content)) if turned_here else colour


def _check_name(text: str) -> None:
    """Raise ImageNotFoundError for what names no file at all; the text is told as it was given."""
    if not text:
        raise ImageNotFoundError("The path is empty: pass the name of an image file.")
    if _URL.match(text):
        raise ImageNotFoundError(f"{text} is a URL, which is not read: download the image and pass its file.")


def _content(path: Path) -> bytes:
    """Read a file; what the system has against it becomes an error of our own."""
    try:
        is_folder = path.is_dir()
        content = b"" if is_folder else path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        raise ImageNotFoundError(f"There is no file {path}: check the name.") from None
    except ValueError as error:
        raise ImageNotFoundError(f"No file can be named {str(path)!r} ({error}): check the name.") from None
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise ImageNotFoundError(f"No file can be named {path} (too long): check the name.") from None
        raise NotAnImageError(
            f"{path} cannot be read ({error.strerror}): check that you may read it and its disk works."
        ) from error
    if is_folder:
        raise ImageNotFoundError(f"{path} is a folder: pass an image file.")
    return content


def _turned(stored: AnyArray, orientation: int) -> AnyArray:
    """Turn a picture as it is stored the way it is meant to be seen, by its EXIF orientation."""
    upright = stored.swapaxes(0, 1) if orientation in (5, 6, 7, 8) else stored
    if orientation in (2, 3, 6, 7):
        upright = upright[:, ::-1]
    return upright[::-1] if orientation in (3, 4, 7, 8) else upright


def imdecode(data: npt.NDArray[np.uint8], flags: int) -> AnyArray | None:
    """Decode an image file held in memory, as ``cv2.imdecode`` does; None where OpenCV cannot."""
    if data.size == 0:
        return None
    try:
        return cv2.imdecode(data, flags)
    except cv2.error:  # raised for instance beyond OpenCV's limit of pixels
        return None
