"""Landmarks carried along when an outline's corners move (section 3.1)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from foldrs import _core

Points = NDArray[np.float64]


def carried(landmarks: Mapping[str, Points], outline: Points, moved: Points) -> dict[str, Points]:
    """Landmarks of an outline on the same outline with its corners moved, each at its share of its edge.

    Parameters
    ----------
    landmarks : mapping of str to (2,) array
        Points of `outline`.
    outline, moved : (n, 2) arrays
        Corners before and after; the frames may differ.

    Returns
    -------
    dict of str to (2,) array
        The landmarks on `moved`, in their order.
    """
    if not landmarks:
        return {}
    edges = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    ends = np.cumsum(edges)
    _, _, arc = _core.nearest_on_outline(outline, np.array(list(landmarks.values())))
    edge = np.minimum(np.searchsorted(ends, arc, side="right"), len(outline) - 1)
    share = np.clip(1.0 - (ends[edge] - arc) / edges[edge], 0.0, 1.0)[:, None]
    points = moved[edge] * (1.0 - share) + moved[(edge + 1) % len(moved)] * share
    return dict(zip(landmarks, points, strict=True))
