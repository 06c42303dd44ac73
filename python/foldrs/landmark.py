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
    points = _core.carried(np.array(list(landmarks.values())), outline, moved)
    return dict(zip(landmarks, points, strict=True))
