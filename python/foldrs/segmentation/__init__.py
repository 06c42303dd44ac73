"""From a photograph to the mask of the garment in it (first half of section 2.1).

The paper thresholds colour edges and fills them. Edges of a strong print, a grained table or a shadow are as
strong as those of the cloth, so colours are compared with those of the table instead, in four steps from
coarse to fine: what deviates from the table (`table`), a graph cut over colours and edges (`cut`), and
twice the outline moved onto the rim (`rim`), in the coarse and then in the fine picture.

Where the first step finds no garment on a table, for the picture shows more than the table, all that may be
one is listed (`candidates`) and the likeliest taken (`choice`).
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from ..errors import GarmentTooSmallError, NoGarmentError, SeveralGarmentsError
from ..image import Mask, RgbImage, as_rgb
from ..parameters import OutlineParameters
from .candidates import candidates
from .choice import Candidate, chosen, looked_at
from .cut import cut
from .masks import largest_part, part_over, resized, single_object, tidied, without_tails
from .rim import snap_to_rim
from .table import FloatImage, table_around, tell_cloth

__all__ = ["refined", "segment"]

_NOTHING = "Nothing stands out from the table: use a table of another colour or more light, or pass a mask."
_LEAST_SIDE = 24  # px of the coarse picture: below, a frame and a garment do not both fit


def segment(rgb: RgbImage, parameters: OutlineParameters | None = None) -> Mask:
    """Find the garment in a photograph.

    Parameters
    ----------
    rgb : (h, w, 3) uint8
        One garment on a table that shows all around it.
    parameters : OutlineParameters, optional

    Returns
    -------
    (h, w) bool
        The garment: one part, without holes.

    Raises
    ------
    NoGarmentError
        Nothing stands out from the table, or no table is seen.
    SeveralGarmentsError
        Two or more objects of like size stand out.
    GarmentTooSmallError
        The picture is too small or narrow to hold a garment's shape.
    """
    p = OutlineParameters() if parameters is None else parameters
    rgb = as_rgb(rgb)
    fine = _scaled(rgb, p.fine_side)
    coarse = _scaled(fine, p.coarse_side)
    if min(coarse.shape[:2]) < _LEAST_SIDE or min(rgb.shape[:2]) < _LEAST_SIDE:
        raise GarmentTooSmallError(
            f"The picture is {rgb.shape[1]} x {rgb.shape[0]} pixels, too small or too narrow for a garment's "
            "shape to be told: pass a larger one."
        )
    if (fine == fine[0, 0]).all():
        raise NoGarmentError("The picture is all one colour: no garment is seen in it.")
    coarse_lab = _lab(coarse)
    smooth = np.asarray(cv2.GaussianBlur(coarse_lab, (0, 0), p.smoothing), np.float32)
    return refined(rgb, _roughly(smooth, p), p)


def _roughly(lab: FloatImage, parameters: OutlineParameters) -> Mask:
    """Tell the cloth, to within a few px, from a table that fills the picture, or else from one within it."""
    p = parameters
    doubt: NoGarmentError | SeveralGarmentsError | None = None
    standing_out = None
    try:
        mask = _on_table_all_over(lab, p)
    except (NoGarmentError, SeveralGarmentsError) as error:
        doubt = error
    else:
        standing_out = looked_at(lab, mask, p)
        if standing_out is not None and _is_garment(standing_out, p):
            return mask
    seen = (looked_at(lab, candidate, p) for candidate in candidates(lab, p))
    best = chosen([one for one in (standing_out, *seen) if one is not None], p)
    if best is None:
        raise doubt or NoGarmentError(_NOTHING)
    if best is standing_out:
        return best.mask
    improved = tidied(cut(table_around(lab, best.mask, p), best.mask, p), p.opening)
    return without_tails(part_over(improved, best.mask), p)


def _is_garment(one: Candidate, parameters: OutlineParameters) -> bool:
    """Whether what stands out from the border of the picture is whole, on an even table, and none itself."""
    c = parameters.candidates
    return one.stands_out(c) and one.is_whole(c) and not one.may_be_table(c)


def _on_table_all_over(lab: FloatImage, parameters: OutlineParameters) -> Mask:
    """Tell the cloth from a table that shows along most of the picture's border."""
    p = parameters
    standing_out, seen = tell_cloth(lab, p)
    if not standing_out.any() or np.median(seen.deviation[standing_out]) < p.least_surprise:
        raise NoGarmentError(_NOTHING)
    guess = without_tails(single_object(standing_out, p, p.merge_gap), p)
    _check_extent(guess, p)
    return without_tails(single_object(tidied(cut(seen, guess, p), p.opening), p, p.merge_gap), p)


def refined(rgb: RgbImage, mask: Mask, parameters: OutlineParameters | None = None) -> Mask:
    """Move the rim of a mask of any size to where cloth meets table, as far as the colours show it.

    Parameters
    ----------
    rgb : (h, w, 3) uint8
        The photograph.
    mask : bool array
        The garment within a few px of the coarse picture, as large as the photograph or smaller.
    parameters : OutlineParameters, optional

    Returns
    -------
    (h, w) bool
        The garment: one part, without holes.

    Raises
    ------
    NoGarmentError
        It is a speck, or covers the picture.
    """
    p = OutlineParameters() if parameters is None else parameters
    fine = _scaled(rgb, p.fine_side)
    coarse = _scaled(fine, p.coarse_side)
    mask = snap_to_rim(_lab(coarse), resized(mask, coarse.shape[:2]), p)
    mask = snap_to_rim(_lab(fine), resized(mask, fine.shape[:2]), _finer(p))
    _check_extent(mask, p)
    whole = resized(mask, rgb.shape[:2])
    return largest_part(whole) if rgb.shape[0] < mask.shape[0] else whole  # shrinking may split it


def _finer(parameters: OutlineParameters) -> OutlineParameters:
    """Parameters for the fine picture: the outline is placed already, so it moves less and sees further."""
    return replace(
        parameters,
        rim_reach=parameters.rim_reach * 0.75,
        rim_gap=parameters.rim_gap * 2 / 3,
        rim_ring=parameters.rim_ring * 4 / 3,
        rim_window=parameters.rim_window * 1.4,
    )


def _check_extent(mask: Mask, parameters: OutlineParameters) -> None:
    """Refuse specks on an empty table and cloth without a table around it."""
    share = float(mask.mean())
    if share < parameters.least_share:
        raise NoGarmentError(
            f"Nothing but specks stands out from the table ({share:.1%} of the picture): "
            "put a garment on it, go nearer, or pass a mask."
        )
    if share > parameters.most_share:
        raise NoGarmentError("Cloth fills the picture and no table is seen: take it from further away.")


def _scaled(rgb: RgbImage, longer_side: int) -> RgbImage:
    """`rgb` enlarged or shrunk to that longer side (px)."""
    height, width = rgb.shape[:2]
    factor = longer_side / max(height, width)
    if factor == 1:
        return rgb
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(rgb, size, interpolation=method), np.uint8)


def _lab(rgb: RgbImage) -> FloatImage:
    """CIELAB: lightness 0..100, so that a difference of 1 is just visible."""
    return np.asarray(cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB), np.float32)
