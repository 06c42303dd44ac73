"""Which points of two halves, or of two garments, are the same, by the package's own shape matching."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.drafting.corners import size_of
from foldrs.drafting.halves import Halves, Places
from foldrs.drafting.parameters import DraftParameters

Points = NDArray[np.float64]

_NODES = 101  # of the table of partners
_LEAST_SLOPE = 0.2  # no stretch of one half shrinks to less in the other, least of all to a point
_SMOOTH = 0.02  # Gaussian over the halves: matched points are 2 % apart


def matched(cut: Halves, parameters: DraftParameters) -> Halves:
    """Return the outline with places that mirror each other where its shape does.

    The outline is aligned with its mirror image by inner-distance shape contexts, which see a sleeve posed
    otherwise as the same sleeve, and by how far the points are apart.
    """
    n = parameters.match_points
    points = cut.at(2.0 * np.arange(n) / n)
    one, other = _aligned(points, points[-np.arange(n) % n] * [-1.0, 1.0], parameters)
    # Both on the way down: a point of the left half and its partner; both on the way up: interchanged.
    down, up = (one < 1) & (other < 1), (one > 1) & (other > 1)
    left = np.concatenate([one[down], 2 - other[up]])
    right = np.concatenate([other[down], 2 - one[up]])
    return replace(cut, partners=_table((left + right) / 2, right - left))


def partners_of(one: Halves, other: Halves, parameters: DraftParameters) -> tuple[Places, Places]:
    """Return places of two upright outlines that match, where each lies upon the other scaled to its area."""
    n = parameters.match_points
    even = 2.0 * np.arange(n) / n
    shapes = []
    for cut in (one, other):
        points = cut.at(even)
        shapes.append((points - points.mean(axis=0)) / size_of(cut.ring))
    return _aligned(shapes[0], shapes[1], parameters)


def _aligned(points: Points, others: Points, parameters: DraftParameters) -> tuple[Places, Places]:
    """Align two outlines of equally spaced places; return the places matched."""
    reach = parameters.match_reach * size_of(points)
    apart = np.linalg.norm(points[:, None] - others[None], axis=-1) / reach
    cost = _core.matching_costs(points, np.ascontiguousarray(others)) + apart**2
    pairs = 2.0 * _core.align(cost)[1] / len(points)
    return pairs[:, 0], pairs[:, 1]


def _table(middle: NDArray[np.float64], ahead: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (2, k) ascending shares of the left and the right half that mirror each other.

    Parameters
    ----------
    middle, ahead : (m,) arrays
        Mean share of two matched points, and how far the right one is ahead; smoothed over the halves.
    """
    nodes = np.linspace(0.0, 1.0, _NODES)
    weight = np.exp(-0.5 * ((nodes[:, None] - middle[None]) / _SMOOTH) ** 2)
    lead = weight @ ahead / np.maximum(weight.sum(axis=1), 1e-9)
    lead *= np.minimum(1.0, np.minimum(nodes, 1 - nodes) / _SMOOTH)  # the ends of the axis are their own
    left, right = nodes - lead / 2, nodes + lead / 2
    table = np.clip(np.maximum.accumulate(np.stack([left, right]), axis=1), 0.0, 1.0)
    return np.asarray((1 - _LEAST_SLOPE) * table + _LEAST_SLOPE * nodes, dtype=np.float64)
