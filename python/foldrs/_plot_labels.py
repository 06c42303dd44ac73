"""Places for the names of points, so that neither names nor points cover each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

_DIRECTIONS = 16
_DISTANCES = (9.0, 18.0, 32.0, 50.0, 75.0)  # px from a point to its name, the nearest first
_MARKER = 14.0  # px: side of the square that a point's marker takes
# Prices of a place, in px of covered area or what equals it.
_COVERS_NAME = 8.0
_COVERS_MARKER = 3.0
_COVERS_OBSTACLE = 30.0  # an obstacle is a point: it has no area
_OUTSIDE = 20.0
_INWARD = 150.0
_FAR = 6.0  # a px of distance


def place_labels(anchors: Points, sizes: Points, obstacles: Points, low: Points, high: Points) -> Points:
    """Find a place for a name beside every point, one after the other, each where it disturbs least.

    Parameters
    ----------
    anchors : (n, 2) px
        The points to name.
    sizes : (n, 2) px
        Widths and heights of the names.
    obstacles : (m, 2) px
        Further points best left uncovered, for instance along lines that matter.
    low, high : (2,) px
        Corners of the panel the names should stay within.

    Returns
    -------
    (n, 2) px
        Centres of the names.
    """
    if not len(anchors):
        return np.empty((0, 2))
    middle = anchors.mean(axis=0)
    angle = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    direction = np.repeat(directions, len(_DISTANCES), axis=0)
    distance = np.tile(np.array(_DISTANCES), _DIRECTIONS)

    places = np.empty_like(anchors)
    for i in _most_crowded_first(anchors):
        half = sizes[i] / 2
        centre = anchors[i] + direction * (distance[:, None] + half)
        outward = (anchors[i] - middle) / max(float(np.hypot(*(anchors[i] - middle))), 1e-9)
        price = _FAR * distance + _INWARD * (1 - direction @ outward)
        price += _OUTSIDE * (4 * half.prod() - _shared_area(centre, half, (low + high) / 2, (high - low) / 2))
        for other in np.delete(anchors, i, axis=0):
            price += _COVERS_MARKER * _shared_area(centre, half, other, np.full(2, _MARKER / 2))
        for j in _most_crowded_first(anchors):
            if j == i:
                break
            price += _COVERS_NAME * _shared_area(centre, half, places[j], sizes[j] / 2)
        covered = (np.abs(obstacles[None] - centre[:, None]) <= half).all(axis=2).sum(axis=1)
        places[i] = centre[int(np.argmin(price + _COVERS_OBSTACLE * covered))]
    return places


def _most_crowded_first(anchors: Points) -> list[int]:
    """Order of the points by the room around them: where there is little, the first choice should be free."""
    apart = np.hypot(*(anchors[:, None] - anchors[None]).transpose(2, 0, 1))
    return [int(i) for i in np.argsort(np.sort(apart, axis=1)[:, :3].sum(axis=1), kind="stable")]


def _shared_area(centre: Points, half: Points, other: Points, other_half: Points) -> Points:
    """Area that boxes around (k, 2) centres share with one other box."""
    low = np.maximum(centre - half, other - other_half)
    high = np.minimum(centre + half, other + other_half)
    area: Points = np.clip(high - low, 0, None).prod(axis=1)
    return area
