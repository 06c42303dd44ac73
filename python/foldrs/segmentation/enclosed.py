"""A garment on a table that does not fill the picture, among floor, wall and whatever else is seen.

The border of the picture then shows more than the table, so that its colours say little. What lies on a table
is enclosed by it instead: on every way to it from the border the colour has to change, while the table and
all that the border cuts are reached with little change (Wei, Wen, Zhu and Sun 2012, "Geodesic saliency using
background priors"). Objects are what stays together at some height of that barrier. A table seen whole is
such an object itself: a large quadrilateral that bears something.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np

from ..errors import SeveralGarmentsError
from ..image import Mask
from ..parameters import OutlineParameters
from .masks import disc, filled, hull, is_part, overlap
from .table import FloatImage, Surprise, surprise

__all__ = ["Enclosed", "enclosed_object", "table_around"]

_BLUR = 1.0  # px, before colours are differentiated: half a rim
_LEAST_COST = 1e-3  # of a step where the colour does not change: among such ways the shorter
_LEVELS = 18  # heights of the barrier looked at: objects that differ by a fifth in height are told apart
_SAME = 0.85  # overlap (IoU) of what is one object at several heights
_WITHIN = 0.95  # share of an object inside another that bears it
_MOST = 0.35  # share of an object that a print upon it hardly covers ...
_CLEARER = 1.3  # ... with so much more contrast


class Enclosed(NamedTuple):
    """Something the border of the picture does not reach.

    Attributes
    ----------
    mask : (h, w) bool
        Its pixels, without holes.
    area : int
        Their number.
    contrast : float
        Change of colour across its rim (CIELAB units a px) that four fifths of the rim exceed.
    """

    mask: Mask
    area: int
    contrast: float

    def bears(self, other: Enclosed) -> bool:
        """Whether another object lies within this one and leaves some of it free."""
        return is_part(other.mask, self.mask, _WITHIN)


def enclosed_object(
    lab: FloatImage, parameters: OutlineParameters
) -> tuple[Enclosed, Enclosed | None] | None:
    """Find the object that lies on a table somewhere in the picture, and that table if it is seen whole.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB, coarse px.
    parameters : OutlineParameters

    Returns
    -------
    object, table
        The table is None unless it is seen whole.
    None
        If nothing is enclosed by a rim that is clear enough.

    Raises
    ------
    SeveralGarmentsError
        Another object of like size lies on the same table.
    """
    p = parameters
    found = _distinct(list(_objects(lab, p)))
    clear = [one for one in found if one.contrast >= p.enclosed_contrast]
    tables = [one for one in clear if _is_table(one, clear, p)]
    table = max(tables, key=lambda one: one.area, default=None)
    objects = [one for one in clear if not any(one is other for other in tables)]
    if table is not None:
        objects = [one for one in objects if table.bears(one)]
    outermost = [one for one in objects if not any(_is_print(one, other) for other in objects)]
    if not outermost:
        return None
    best = max(outermost, key=_prominence)
    for other in outermost:
        if _is_rival(other, best, lab, p):
            raise SeveralGarmentsError(
                "There are several objects of like size on the table: "
                "leave one garment in the picture, or pass a mask of the one that is meant."
            )
    return best, table


def table_around(lab: FloatImage, mask: Mask, parameters: OutlineParameters) -> Surprise:
    """Compare a picture with the table seen close around an object.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB, coarse px.
    mask : (h, w) bool
        The object.
    parameters : OutlineParameters
    """
    near = cv2.dilate(mask.astype(np.uint8), disc(parameters.enclosed_ring)) > 0
    return surprise(lab, near & ~_widened(mask, parameters.rim_gap), parameters)


def _objects(lab: FloatImage, parameters: OutlineParameters) -> Iterator[Enclosed]:
    """Everything that stays together at some height of the barrier from the border, from low to high."""
    p = parameters
    gradient = _gradient(lab)
    barrier = _barrier(gradient, p)
    rim = cv2.dilate(gradient, disc(2))
    height, width = barrier.shape
    for level in np.geomspace(p.lowest_barrier, max(p.lowest_barrier, 0.9 * float(barrier.max())), _LEVELS):
        above = cv2.morphologyEx((barrier > level).astype(np.uint8), cv2.MORPH_OPEN, disc(p.enclosed_opening))
        _, labels, statistics, _ = cv2.connectedComponentsWithStats(above, connectivity=4)
        for label, (x, y, w, h, area) in enumerate(statistics[1:], start=1):
            on_border = min(x, y) <= 1 or x + w >= width - 1 or y + h >= height - 1
            if on_border or not p.least_enclosed <= area / barrier.size <= p.most_share:
                continue
            mask = filled(np.equal(labels, label))
            edge = mask & (cv2.erode(mask.astype(np.uint8), disc(1)) == 0)
            yield Enclosed(mask, int(np.count_nonzero(mask)), float(np.percentile(rim[edge], 20)))


def _gradient(lab: FloatImage) -> FloatImage:
    """Change of colour at every pixel, CIELAB units a px."""
    blurred = cv2.GaussianBlur(lab, (0, 0), _BLUR)
    across, down = (cv2.Scharr(blurred, cv2.CV_32F, *order) / 32 for order in ((1, 0), (0, 1)))
    squared = (across * across + down * down).sum(axis=2)
    return np.asarray(np.sqrt(squared), np.float32)


def _barrier(gradient: FloatImage, parameters: OutlineParameters) -> FloatImage:
    """Least change of colour on any way from the border to every pixel; what is usual costs nothing."""
    from skimage.graph import MCP_Geometric  # slow to import, and seldom needed

    usual = parameters.usual_gradient * float(np.median(gradient))
    cost = np.maximum(gradient - usual, 0.0) + _LEAST_COST
    border = np.ones(cost.shape, np.bool_)
    border[1:-1, 1:-1] = False
    barrier, _ = MCP_Geometric(cost).find_costs(np.argwhere(border))
    return np.asarray(barrier, np.float32)


def _distinct(objects: Sequence[Enclosed]) -> list[Enclosed]:
    """Keep of what is one object at several heights the one with the clearest rim."""
    kept: list[Enclosed] = []
    for one in sorted(objects, key=lambda one: -one.contrast):
        if not any(overlap(one.mask, other.mask) > _SAME for other in kept):
            kept.append(one)
    return kept


def _is_table(one: Enclosed, objects: Sequence[Enclosed], parameters: OutlineParameters) -> bool:
    """Whether an object is a large quadrilateral that bears another one, not too small upon it."""
    p = parameters
    if one.mask.mean() < p.whole_table_share or _likeness_to_quadrilateral(one.mask) < p.quadrilateral:
        return False
    return any(one.bears(o) and o.area >= p.least_borne * one.area for o in objects)


def _is_print(one: Enclosed, other: Enclosed) -> bool:
    """Whether an object is a print on another, not the garment of what is a garment and some of the table."""
    most_of_it = one.area > _MOST * other.area and one.contrast > _CLEARER * other.contrast
    return other.bears(one) and not most_of_it


def _is_rival(other: Enclosed, best: Enclosed, lab: FloatImage, parameters: OutlineParameters) -> bool:
    """Whether another object is of like size and lies on a table of the same colour."""
    p = parameters
    beside = np.count_nonzero(other.mask & best.mask) < (1 - _WITHIN) * other.area
    if not beside or other.area < p.like_size_share * best.area:
        return False
    around = (
        lab[_widened(one.mask, p.table_margin) & ~_widened(one.mask, p.rim_gap)] for one in (best, other)
    )
    one_colour, other_colour = (np.median(colours, axis=0) for colours in around)
    return float(np.linalg.norm(one_colour - other_colour)) < p.same_table


def _prominence(one: Enclosed) -> float:
    """How much an object looks like what the picture was taken of: large, in the middle, with a clear rim."""
    height, width = one.mask.shape
    rows, columns = np.nonzero(one.mask)
    x, y = 2 * columns.mean() / width - 1, 2 * rows.mean() / height - 1
    return float(np.sqrt(one.contrast * one.area) * np.exp(-(x * x + y * y) / 2))


def _likeness_to_quadrilateral(mask: Mask) -> float:
    """Overlap of a mask and the quadrilateral its hull simplifies to; 0 if that has other corners."""
    corners = hull(mask)
    length = cv2.arcLength(corners, closed=True)
    for tolerance in np.linspace(0.01, 0.15, 15):
        corners = np.asarray(cv2.approxPolyDP(corners, tolerance * length, closed=True), np.int32)
        if len(corners) <= 4:
            break
    if len(corners) != 4:
        return 0.0
    drawn = np.zeros(mask.shape, np.uint8)
    cv2.fillConvexPoly(drawn, corners, 1)
    return overlap(mask, drawn > 0)


def _widened(mask: Mask, by: float) -> Mask:
    return cv2.dilate(mask.astype(np.uint8), disc(by)) > 0
