"""From the picture to the upright garment in centimetres."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from foldrs.drafting.parameters import DraftParameters
from foldrs.drafting.symmetry import MirrorAxis
from foldrs.errors import ParameterError

Points = NDArray[np.float64]


def upright(points: Points, mirror: MirrorAxis) -> Points:
    """Turn points so that the mirror axis becomes the line x = 0, its upper end up."""
    start, end = mirror.axis
    down = (end - start) / np.linalg.norm(end - start)
    across = np.array([down[1], -down[0]])
    return np.stack([(points - start) @ across, (points - start) @ down], axis=1)


def as_given(points: Points, deviation: float) -> MirrorAxis:
    """Return the vertical through the middle: a garment without mirror axis stays as it lies."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return MirrorAxis(np.array([middle, [middle[0], middle[1] + 1.0]]), deviation)


def map_to_upright(
    points: Points, mirror: MirrorAxis, px_per_cm: float | None, size_cm: float | None, p: DraftParameters
) -> Points:
    """Return the (2, 3) map to the upright garment, cm: its mirror axis at x = 0, its top at y = 0."""
    for what, value in (("px_per_cm", px_per_cm), ("size_cm", size_cm)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise ParameterError(f"{what} must be a positive number, not {value}")
    if px_per_cm is not None and size_cm is not None:
        raise ParameterError("px_per_cm and size_cm both tell the garment's size: give one of them")
    turned = upright(points, mirror)
    longer = float(np.ptp(turned, axis=0).max())
    unit = 1.0 / px_per_cm if px_per_cm is not None else (size_cm or p.size_cm) / longer
    origin, x, y = upright(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), mirror)
    offset = origin - [0.0, float(turned[:, 1].min())]
    return np.asarray(unit * np.column_stack([x - origin, y - origin, offset]), dtype=np.float64)
