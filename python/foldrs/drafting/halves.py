"""A flat garment upright, and places along the two halves of its outline.

A *place* is a number from 0, the top of the mirror axis, down the left half to 1, its bottom, and up the
right half to 2, the top again. The place that mirrors t is 2 - t. Within a half places grow with arc length,
unless the halves are matched point by point (:mod:`foldrs.drafting.matching`): so a sleeve posed otherwise
than its partner changes where its points lie, not their places.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.registration import perimeter

Points = NDArray[np.float64]
Places = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Halves:
    """An upright outline that starts at the top of its mirror axis (x = 0) and goes down the left side."""

    ring: Points
    """(n, 2) the outline, y down."""
    left_length: float
    """Length of the left half; the right half is the rest of the outline."""
    partners: Points = field(default_factory=lambda: np.array([[0.0, 1.0], [0.0, 1.0]]))
    """(2, k) ascending shares of the lengths of left and right half, from the top, that mirror each other."""

    @property
    def right_length(self) -> float:
        """Length of the right half."""
        return perimeter(self.ring) - self.left_length

    def at(self, places: Places) -> Points:
        """Points of the outline at places."""
        left, right = self.left_length, self.right_length
        down = np.interp(2 - places, *self.partners)  # share of the right half
        arcs = np.where(places <= 1, places * left, left + (1 - down) * right)
        return _core.points_at(self.ring, np.mod(arcs, left + right))

    def places_of(self, points: Points) -> tuple[Places, NDArray[np.float64]]:
        """Return the places of the outline nearest to points, and their distances."""
        _, distances, arcs = _core.nearest_on_outline(self.ring, points)
        left = self.left_length
        down = np.interp(1 - (arcs - left) / self.right_length, *self.partners[::-1])
        return np.where(arcs <= left, arcs / left, 2 - down), distances

    def mean(self, samples: int) -> Halves:
        """Return the symmetric outline in the middle between this one and its mirror image."""
        shares = np.linspace(0.0, 1.0, samples + 1)
        half = (self.at(shares) + self.at(mirrored(shares)) * [-1.0, 1.0]) / 2
        half[[0, -1], 0] = 0.0
        length = float(np.linalg.norm(np.diff(half, axis=0), axis=1).sum())
        return Halves(np.vstack([half, half[-2:0:-1] * [-1.0, 1.0]]), length)


def mirrored(places: Places) -> Places:
    """Return the places that mirror others."""
    return np.asarray(np.mod(2.0 - places, 2.0), dtype=np.float64)


def halves(ring: Points) -> Halves:
    """Cut an upright outline in two where the line x = 0 crosses it.

    Of several crossings, those of a limb that reaches over the axis, the two are taken that leave halves of
    most equal length.

    Parameters
    ----------
    ring : (n, 2) array
        Outline around the line x = 0, in either direction.
    """
    before, after = ring, np.roll(ring, -1, axis=0)
    crossed = np.flatnonzero((before[:, 0] < 0) != (after[:, 0] < 0))
    share = before[crossed, 0] / (before[crossed, 0] - after[crossed, 0])
    cuts = before[crossed] + share[:, None] * (after[crossed] - before[crossed])
    edges = np.linalg.norm(after - before, axis=1)
    arcs = (np.cumsum(edges) - edges)[crossed] + share * edges[crossed]
    half = edges.sum() / 2
    pairs = [(i, j) for i in range(len(arcs)) for j in range(i + 1, len(arcs))]
    i, j = min(pairs, key=lambda pair: abs(arcs[pair[1]] - arcs[pair[0]] - half))
    one = np.vstack([cuts[i], ring[crossed[i] + 1 : crossed[j] + 1], cuts[j]])
    other = np.vstack([cuts[j], ring[crossed[j] + 1 :], ring[: crossed[i] + 1], cuts[i]])
    if one[0, 1] > one[-1, 1]:
        one, other = other, one  # both start where the other ends: now `one` starts at the top
    if one[:, 0].mean() > other[:, 0].mean():
        one, other = other[::-1], one[::-1]  # now it is the left half
    left = one[_distinct(one)]
    whole = np.vstack([left, other[_distinct(other)][1:-1]])
    length = float(np.linalg.norm(np.diff(left, axis=0), axis=1).sum())
    return Halves(np.ascontiguousarray(whole), length)


def _distinct(points: Points) -> NDArray[np.bool_]:
    """Mark points that differ from the one before."""
    moved = np.abs(np.diff(points, axis=0)).sum(axis=1) > 0
    return np.concatenate([np.array([True]), moved])
