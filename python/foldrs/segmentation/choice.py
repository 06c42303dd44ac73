"""Which of all that may be the garment it is.

A garment lies on one table: close around it is one even colour, smoothly shaded, and all along its rim what
is within differs from that. What lies half on a board and half beside it, a table among clutter, a shadow
and what the border cuts are unlike that in one way or another. Among things that are like it, the photograph
was taken of one in the middle that is neither a speck nor most of the picture. What bears another thing is
either the table, if that is seen whole, or the garment that a print is on.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import SeveralGarmentsError
from ..image import Mask
from ..parameters import CandidateParameters, OutlineParameters
from .masks import disc, likeness_to_quadrilateral, window
from .table import FloatImage, surprise

__all__ = ["Candidate", "chosen", "looked_at"]

_UNCLEAR = 0.1  # a clearness of less is no worse
_LEAST_RING = 50  # px of table around an object from which its colour can be learnt
_BESIDE = 0.05  # share of an object up to which it may stick out of another that it lies within


@dataclass(frozen=True, eq=False)
class Candidate:
    """Something that may be the garment, and how it lies on what is around it."""

    mask: Mask
    """Its pixels, (h, w) bool, one part without holes."""
    clearness: float
    """Deviation from the table around that nine tenths of the strip within its rim exceed, in spreads."""
    evenness: float
    """Share of the ring around it that looks like one smooth table."""
    cut_off: float
    """Share of its rim on the picture's border."""
    off_centre: float
    """Square of the distance of its middle from the picture's, in half sides."""
    share: float
    """Its area, share of the picture."""
    table: npt.NDArray[np.float32]
    """Median colour of the ring around it, CIELAB."""

    @functools.cached_property
    def squareness(self) -> float:
        """Overlap with the quadrilateral that it simplifies to, as a table does."""
        return likeness_to_quadrilateral(self.mask)

    def likeness(self, parameters: CandidateParameters) -> float:
        """How much it looks like a thing that lies on a table."""
        c = parameters
        clear = c.clear_weight * float(np.log(max(self.clearness, _UNCLEAR)))
        return clear + c.even_weight * self.evenness

    def rating(self, parameters: CandidateParameters) -> float:
        """How much it looks like what the picture was taken of."""
        c = parameters
        unusual = float(np.log(self.share / c.usual_share))
        elsewhere = c.cut_off_weight * self.cut_off + c.centre_weight * self.off_centre
        return self.likeness(c) - elsewhere - c.size_weight * unusual * unusual

    def stands_out(self, parameters: CandidateParameters) -> bool:
        """Whether it differs all along from an even table around it."""
        c = parameters
        return self.clearness >= c.least_clearness and self.evenness >= c.least_evenness

    def is_whole(self, parameters: CandidateParameters) -> bool:
        """Whether the border of the picture hardly touches it."""
        return self.cut_off <= parameters.least_cut_off

    def may_be_table(self, parameters: CandidateParameters) -> bool:
        """Whether it is large and square enough for a table seen whole."""
        c = parameters
        return self.share >= c.whole_table_share and self.squareness >= c.no_table


def looked_at(lab: FloatImage, mask: Mask, parameters: OutlineParameters) -> Candidate | None:
    """Measure how an object lies on what is around it; None if too little is seen around it.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB, coarse px.
    mask : (h, w) bool
        The object, not empty.
    parameters : OutlineParameters
    """
    p, c = parameters, parameters.candidates
    part = window(mask, c.ring_reach + 2)
    colours, inside = lab[part], mask[part]
    border = np.ones_like(mask)
    border[1:-1, 1:-1] = False
    border = border[part]
    # The border of the picture is no rim.
    padded = cv2.copyMakeBorder(inside.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    depth = cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1]
    away = cv2.distanceTransform((~inside).astype(np.uint8), cv2.DIST_L2, 3)
    ring = (away > p.rim_gap) & (away <= c.ring_reach) & ~border
    strip = (depth > c.strip[0]) & (depth <= c.strip[1])
    if np.count_nonzero(ring) < _LEAST_RING or not strip.any():
        return None
    deviation = surprise(colours, ring, p).deviation
    cut_off = inside & border
    rim = cut_off | (inside & (cv2.erode(inside.astype(np.uint8), disc(1)) == 0))
    rows, columns = np.nonzero(mask)
    height, width = mask.shape
    x, y = 2 * columns.mean() / width - 1, 2 * rows.mean() / height - 1
    return Candidate(
        mask,
        clearness=float(np.percentile(deviation[strip], 10)),
        evenness=float((deviation[ring] < c.even_deviation).mean()),
        cut_off=np.count_nonzero(cut_off) / np.count_nonzero(rim),
        off_centre=float(x * x + y * y),
        share=rows.size / mask.size,
        table=np.median(colours[ring], axis=0).astype(np.float32),
    )


def chosen(candidates: Sequence[Candidate], parameters: OutlineParameters) -> Candidate | None:
    """Choose the candidate that most looks like the garment; None if not even that stands out.

    Raises
    ------
    SeveralGarmentsError
        Another one of like size lies beside it on the same table.
    """
    p, c = parameters, parameters.candidates
    on_table = [one for one in candidates if not any(_is_table(one, other, c) for other in candidates)]
    best = max(on_table, key=lambda one: one.rating(c), default=None)
    bearer = best
    while bearer is not None:
        best = bearer
        bearers = [one for one in on_table if _is_print(best, one, c)]
        bearer = max(bearers, key=lambda one: one.rating(c), default=None)
    if best is None or best.clearness < c.least_clearness:
        return None
    if any(_is_rival(other, best, p) for other in on_table):
        raise SeveralGarmentsError(
            "There are several objects of like size on the table: "
            "leave one garment in the picture, or pass a mask of the one that is meant."
        )
    return best


def _is_table(one: Candidate, other: Candidate, parameters: CandidateParameters) -> bool:
    """Whether a candidate is a table seen whole that bears the other one: a motif on a towel is smaller."""
    c = parameters
    if one.share < c.whole_table_share or not c.least_borne <= other.share / one.share <= c.most_borne:
        return False
    return (
        other.is_whole(c)
        and other.stands_out(c)
        and _lies_on(other, one)
        and _looks_like_table(one, other, c)
    )


def _is_print(one: Candidate, other: Candidate, parameters: CandidateParameters) -> bool:
    """Whether a candidate is but a print on the other one, which is no table, whole or cut off."""
    c = parameters
    if one.share >= c.most_print * other.share or not other.stands_out(c) or not _lies_on(one, other):
        return False
    if one.likeness(c) - other.likeness(c) > c.bearer:
        return False
    small = other.share < c.whole_table_share
    if other.is_whole(c):
        return small or one.share < c.least_borne * other.share or not _looks_like_table(other, one, c)
    # Of a table the border cuts off more, and what is left of one need not be large.
    return small and other.squareness < c.no_table and other.cut_off <= c.most_cut_off


def _looks_like_table(one: Candidate, other: Candidate, parameters: CandidateParameters) -> bool:
    """Whether what bears another thing is rather its table than a garment that it is a print on.

    A table is a quadrilateral, and mostly seen among other things: it stands out less than what lies on it.
    """
    c = parameters
    square = c.table_weight * (one.squareness - c.table_likeness)
    return one.likeness(c) - other.likeness(c) < square


def _is_rival(other: Candidate, best: Candidate, parameters: OutlineParameters) -> bool:
    """Whether another candidate beside the best might be meant as well."""
    p, c = parameters, parameters.candidates
    if not p.like_size_share <= other.share / best.share <= 1 / p.like_size_share:
        return False
    if np.count_nonzero(other.mask & best.mask) >= _BESIDE * np.count_nonzero(other.mask):
        return False
    same_table = float(np.linalg.norm(other.table - best.table)) < c.same_table
    as_likely = other.stands_out(c) and best.likeness(c) - other.likeness(c) < c.rival
    return same_table and other.is_whole(c) and as_likely


def _lies_on(one: Candidate, other: Candidate) -> bool:
    """Whether a candidate lies within another."""
    return bool(np.count_nonzero(one.mask & ~other.mask) < _BESIDE * np.count_nonzero(one.mask))
