"""Outlines given as points that cross or touch themselves: small loops are cut off, others refused.

Tracing leaves such loops: threads one pixel wide run back over themselves, noise swaps neighbouring points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.errors import InvalidOutlineError

_LARGEST_LOSS = 0.02
"""Largest share of the area that may be cut off with the loops: more is no flaw of tracing."""

_LARGEST_COORDINATE = 1e15
"""Farther out floating point numbers no longer tell neighbouring pixels apart."""


def simple_outline(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an outline that does not cross itself.

    Parameters
    ----------
    outline : (n, 2)
        Three points at least, finite.

    Returns
    -------
    (m, 2)
        The outline itself if it is simple, else its largest part.

    Raises
    ------
    InvalidOutlineError
        It encloses no area, crosses itself so much that its shape cannot be told, or lies too far out.
    """
    if (farthest := float(np.abs(outline).max())) > _LARGEST_COORDINATE:
        raise InvalidOutlineError(f"The outline has a coordinate of size {farthest:.3g}: pass pixels.")
    try:
        _core.check_outline(outline)
    except InvalidOutlineError as error:
        mended = _without_loops(outline)
        if mended is None:
            raise InvalidOutlineError(
                f"The points are no outline: {error}. Pass them in their order along the outline."
            ) from None
        return mended
    return outline


def _without_loops(outline: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Cut off all but the largest part; None if it is not nearly all there is."""
    from shapely import Polygon, area, get_parts, make_valid

    # What was mended may be a collection of polygons, lines, and collections of polygons.
    with np.errstate(all="ignore"):  # of coordinates whose products are too large or small for numbers
        parts = get_parts(get_parts(make_valid(Polygon(outline))))
        areas = area(parts)
    if not areas.sum() > 0:
        return None
    largest = Polygon(parts[areas.argmax()].exterior)
    # A loop within the largest part is a hole of it: filled in, the area grows.
    if abs(largest.area - areas.sum()) > _LARGEST_LOSS * areas.sum():
        return None
    mended = np.array(largest.exterior.coords)[:-1, :2]
    try:
        _core.check_outline(mended)
    except InvalidOutlineError:
        return None
    return mended
