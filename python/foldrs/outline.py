"""Stage 0: from a photograph, a mask or points to the outline of the garment (section 2.1).

Outlines are (n, 2) float64 in image px: (x, y), y down, an integer is the centre of a pixel. They are closed
implicitly.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ._mending import simple_outline
from .doubts import doubt
from .errors import (
    GarmentCutOffError,
    GarmentTooSmallError,
    InvalidOutlineError,
    NoGarmentError,
    OutlineError,
)
from .image import Mask, RgbImage, as_mask, as_rgb, is_pillow, read_image, read_mask
from .parameters import OutlineParameters
from .segmentation import segment
from .segmentation.masks import disc, refuse_like_sizes

__all__ = ["Outline", "OutlineInImage", "as_outline", "find_outline", "outline_of_mask", "segment"]

Outline = npt.NDArray[np.float64]

_SMOOTHING_ROUNDS = 2  # of (1 2 1)/4 along the outline: takes the steps of the pixel grid off, keeps corners


@dataclass(frozen=True)
class OutlineInImage:
    """The outline of a garment, and where it was found.

    Attributes
    ----------
    points : (n, 2) float64
        The outline, image px.
    rgb : (h, w, 3) uint8 or None
        The photograph, if there is one.
    mask : (h, w) bool or None
        The garment's pixels, unless points were given.
    """

    points: Outline
    rgb: RgbImage | None = None
    mask: Mask | None = None


def find_outline(
    source: str | os.PathLike[str] | npt.ArrayLike,
    *,
    mask: str | os.PathLike[str] | npt.ArrayLike | None = None,
    parameters: OutlineParameters | None = None,
) -> OutlineInImage:
    """Find the outline of the garment in whatever is given.

    Parameters
    ----------
    source : path or array_like
        A file is a photograph. An array of shape (h, w) and type bool is a mask, one of numbers and shape
        (n, 2) or (n, 1, 2) is an outline, everything else, any image of Pillow's too, a photograph.
    mask : path or array_like, optional
        The garment's pixels in the photograph, of its size; no segmentation then.
    parameters : OutlineParameters, optional

    Returns
    -------
    OutlineInImage

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        No such file, or no image in it or in the array.
    NoGarmentError, SeveralGarmentsError, GarmentTooSmallError, GarmentCutOffError
        No usable outline in the picture or mask.
    InvalidOutlineError
        The points are no outline. Small loops, where it crosses or touches itself, are cut off.
    OutlineError
        The mask's size is not the photograph's, or a mask came with points or a second mask.

    Warns
    -----
    GarmentCutOffWarning
        The border of the picture cuts a small part of the garment.

    Examples
    --------
    >>> mask = np.zeros((60, 80), bool)
    >>> mask[10:50, 20:60] = True
    >>> find_outline(mask).points.round().min(axis=0).tolist()
    [20.0, 10.0]
    """
    p = OutlineParameters() if parameters is None else parameters
    if isinstance(source, str | os.PathLike):
        return _outline_in_photograph(read_image(source, p.max_pixels), mask, p)
    if is_pillow(source):
        return _outline_in_photograph(as_rgb(source, p.max_pixels), mask, p)
    array = _as_array(source)
    is_mask = array.dtype == np.bool_ and array.ndim == 2
    is_outline = not is_mask and _has_outline_shape(array)
    if mask is not None and (is_mask or is_outline):
        given = "a mask" if is_mask else "an outline"
        raise OutlineError(f"A mask goes with a photograph, but the source is {given}: leave one out.")
    if is_mask:
        return OutlineInImage(outline_of_mask(array, p), mask=as_mask(array))
    if not is_mask and not is_outline:
        _refuse_points_of_other_shape(array)
    if is_outline:
        return OutlineInImage(simple_outline(as_outline(array)))
    return _outline_in_photograph(as_rgb(array, p.max_pixels), mask, p)


def as_photograph(
    source: str | os.PathLike[str] | npt.ArrayLike, max_pixels: int | None = None
) -> RgbImage | None:
    """Read the photograph that `source` is, as :func:`find_outline` takes it.

    Parameters
    ----------
    source : path or array_like
        As :func:`find_outline` takes it.
    max_pixels : int, optional
        Most pixels it may have; any number without it.

    Returns
    -------
    (h, w, 3) uint8 or None
        RGB; None if `source` is a mask or points.

    Raises
    ------
    ImageTooLargeError
        It has more pixels than allowed; a file is not decoded then.
    ImageNotFoundError, NotAnImageError, InvalidOutlineError
        As :func:`find_outline`.
    """
    if isinstance(source, str | os.PathLike):
        return read_image(source, max_pixels)
    if is_pillow(source):
        return as_rgb(source, max_pixels)
    array = _as_array(source)
    is_mask = array.dtype == np.bool_ and array.ndim == 2
    return None if is_mask or _has_outline_shape(array) else as_rgb(array, max_pixels)


def as_outline(points: npt.ArrayLike) -> Outline:
    """Bring points into an (n, 2) float64 outline.

    Parameters
    ----------
    points : (n, 2) or (n, 1, 2) array_like
        Whole numbers or floats in any memory layout; the second shape is that of OpenCV's contours. A
        repeated first point at the end is dropped.

    Returns
    -------
    (n, 2) float64
        C-contiguous; never a view of `points`.

    Raises
    ------
    InvalidOutlineError
        Not of that shape, not finite, or fewer than three points.
    """
    try:
        array = np.asarray(points)
        if not np.iscomplexobj(array):
            array = array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidOutlineError(f"The points are no numbers ({error}): pass (n, 2) points.") from None
    if np.iscomplexobj(array) or not _has_outline_shape(array):
        raise InvalidOutlineError(
            f"An outline is an array of real numbers of shape (n, 2), this is {array.dtype} {array.shape}."
        )
    outline = np.array(array.reshape(-1, 2), order="C")
    if not np.isfinite(outline).all():
        raise InvalidOutlineError("The outline holds NaN or infinity: leave these points out.")
    if len(outline) > 1 and np.array_equal(outline[0], outline[-1]):
        outline = outline[:-1].copy()
    if len(outline) < 3:
        raise InvalidOutlineError(f"The outline has {len(outline)} points: pass at least three.")
    return outline


def outline_of_mask(mask: npt.ArrayLike, parameters: OutlineParameters | None = None) -> Outline:
    """Outer outline of the one object in a mask.

    It runs through the centres of the outermost cloth pixels, as OpenCV's contours do, so filling it with
    ``cv2.fillPoly`` gives the mask back but for the steps of the pixel grid, which are smoothed out.

    Parameters
    ----------
    mask : (h, w) array_like
        See :func:`foldrs.image.as_mask`. Specks beside the object are ignored, and so are its holes.
    parameters : OutlineParameters, optional

    Returns
    -------
    (n, 2) float64
        About one point a pixel.

    Raises
    ------
    NotAnImageError
        No mask.
    NoGarmentError, SeveralGarmentsError, GarmentTooSmallError, GarmentCutOffError
        Nothing in the mask, several objects of like size, too few pixels, or much of it on the border.

    Warns
    -----
    GarmentCutOffWarning
        A little of the outline is on the border.
    """
    p = OutlineParameters() if parameters is None else parameters
    cloth = as_mask(mask)
    if not cloth.any():
        raise NoGarmentError("The mask is empty: mark the garment's pixels as True.")
    if cloth.mean() > p.most_share:
        raise NoGarmentError("The mask covers the whole picture: mark only the garment's pixels as True.")
    # Threads one pixel wide would make the outline run back over itself.
    solid = cv2.morphologyEx(cloth.astype(np.uint8), cv2.MORPH_OPEN, disc(1))
    contours, _ = cv2.findContours(solid, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    # A contour runs through pixel centres: half of its pixels' area lies outside (Pick's theorem).
    areas = [round(cv2.contourArea(contour) + len(contour) / 2 + 1) for contour in contours]
    refuse_like_sizes(areas, p)
    pixels = max(areas, default=0)
    if pixels < p.least_pixels:
        raise GarmentTooSmallError(
            f"The garment covers {pixels} pixels, at least {p.least_pixels} are needed to tell its shape: "
            "go nearer or use a larger picture."
        )
    steps = contours[areas.index(pixels)][:, 0, :]
    _check_border(steps, cloth.shape, p)
    outline = steps.astype(np.float64)
    for _ in range(_SMOOTHING_ROUNDS):
        outline = (np.roll(outline, 1, axis=0) + 2 * outline + np.roll(outline, -1, axis=0)) / 4
    return outline


def _outline_in_photograph(
    rgb: RgbImage, mask: str | os.PathLike[str] | npt.ArrayLike | None, parameters: OutlineParameters
) -> OutlineInImage:
    """Take the outline from the given mask, or else from a segmentation."""
    if mask is None:
        _refuse_mask_as_photograph(rgb)
        cloth = segment(rgb, parameters)
    else:
        is_file = isinstance(mask, str | os.PathLike)
        cloth = read_mask(mask, parameters.max_pixels) if is_file else as_mask(mask)  # type: ignore[arg-type]
        if cloth.shape != rgb.shape[:2]:
            raise OutlineError(
                f"The mask is {cloth.shape[1]} x {cloth.shape[0]} pixels, the photograph "
                f"{rgb.shape[1]} x {rgb.shape[0]}: pass a mask of the photograph's size."
            )
    return OutlineInImage(outline_of_mask(cloth, parameters), rgb=rgb, mask=cloth)


def _refuse_mask_as_photograph(rgb: RgbImage) -> None:
    """Refuse a mask of 0 and 1, which is black to the eye, and to the segmentation."""
    if rgb.max() == 1:
        raise NoGarmentError(
            "The picture is black, it holds only 0 and 1 (of 255): to pass a mask as the source make it an "
            "array of booleans, or of 0 and 255."
        )


def _check_border(steps: npt.NDArray[Any], shape: tuple[int, ...], parameters: OutlineParameters) -> None:
    """Refuse, or warn of, an outline (x, y) part of which runs along the border of the picture."""
    last = (shape[1] - 1, shape[0] - 1)
    share = float(((steps == 0) | (steps == last)).any(axis=1).mean())
    if share > parameters.cut_off_share:
        raise GarmentCutOffError(
            f"The border of the picture cuts the garment off ({share:.0%} of its outline lie there): "
            "take a photograph that shows all of it."
        )
    if share > 0:
        doubt(
            f"The garment touches the picture's border ({share:.1%} of its outline): it may be cut there.",
            stacklevel=3,
        )


def _has_outline_shape(array: npt.NDArray[Any]) -> bool:
    """Whether the array has the shape of points, (n, 2) or (n, 1, 2)."""
    return (array.ndim == 2 and array.shape[1] == 2) or (array.ndim == 3 and array.shape[1:] == (1, 2))


def _refuse_points_of_other_shape(array: npt.NDArray[Any]) -> None:
    """Refuse what is no picture by its shape: points given as columns, with a third coordinate, or none."""
    if array.shape == (0,) or (array.ndim == 2 and (array.shape[0] == 2 or array.shape[1] in (1, 3))):
        raise InvalidOutlineError(
            f"The source is neither a picture nor an outline: an outline has the shape (n, 2), this array "
            f"{array.shape}."
        )


def _as_array(source: npt.ArrayLike) -> npt.NDArray[Any]:
    """`source` as an array; ragged nested lists become an error of our own."""
    try:
        return np.asarray(source)
    except ValueError as error:
        raise InvalidOutlineError(f"The source is no array ({error}): pass image, mask or points.") from None
