"""Landmarks moved so that they follow each other along their outline.

On a traced outline a landmark may lie within: a corner that is turned in, an armpit that a sleeve covers. The
place nearest to it is then often on the other side of its neighbour, and whatever is told by a share of
the way between two landmarks lies anywhere.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LinearRing

from foldrs import _core

Points = NDArray[np.float64]

_PLACES = 400
"""Places of the outline that are tried for every landmark, of 250 cm of outline one every 0.6 cm."""


def follow_outline(outline: Points, landmarks: Points) -> Points:
    """Move landmarks onto an outline if they do not follow each other along it.

    Parameters
    ----------
    outline : ndarray of shape (n, 2)
        Closed, either winding.
    landmarks : ndarray of shape (l, 2)
        In the order they should have along it, in either direction; same unit.

    Returns
    -------
    ndarray of shape (l, 2)
        The landmarks as they are if their nearest places follow each other; else, of the places that do, the
        ones with the least sum of squared distances.

    Examples
    --------
    A corner that is turned in so far that the place nearest to it is on the other side:

    >>> towel = np.array([[0.0, 0], [40, 0], [40, 20], [20, 40], [0, 40]])
    >>> corners = np.array([[0.0, 0], [40, 0], [5, 20], [0, 40]])
    >>> follow_outline(towel, corners).round().tolist()
    [[0.0, 0.0], [40.0, 0.0], [0.0, 30.0], [0.0, 30.0]]
    """
    ring = LinearRing(outline)
    nearest = shapely.line_locate_point(ring, shapely.points(landmarks))
    if _follow(nearest, ring.length):
        return landmarks
    places = np.asarray(_core.resample(np.ascontiguousarray(outline), _PLACES), dtype=np.float64)
    squared = ((landmarks[:, None] - places) ** 2).sum(axis=-1)
    forward, backward = _cheapest_order(squared), _cheapest_order(squared[:, ::-1])
    if forward[0] <= backward[0]:
        return places[forward[1]]
    return places[::-1][backward[1]]


def _follow(arc: NDArray[np.float64], length: float) -> bool:
    """Whether places along a ring follow each other in one turn, either way round."""
    steps = np.roll(arc, -1) - arc
    return any(bool(np.isclose((way * steps % length).sum(), length)) for way in (1, -1))


def _cheapest_order(cost: NDArray[np.float64]) -> tuple[float, NDArray[np.intp]]:
    """Give every row a column, each beyond the one before and all within one turn, at the least total cost.

    By dynamic programming, from every place of the first row at once.
    """
    rows, columns = cost.shape
    offsets = np.arange(columns)
    turned = (offsets[:, None] + offsets) % columns  # [first, offset]
    total = np.where(offsets == 0, cost[0][:, None], np.inf)
    tables = [total]
    for row in cost[1:]:
        before = np.minimum.accumulate(total, axis=1)
        before = np.hstack([np.full((columns, 1), np.inf), before[:, :-1]])
        total = row[turned] + before
        tables.append(total)
    first = int(total.min(axis=1).argmin())
    best, found, end = float(total[first].min()), np.empty(rows, dtype=np.intp), columns
    for row in range(rows - 1, -1, -1):
        end = int(tables[row][first, :end].argmin())
        found[row] = turned[first, end]
    return best, found
