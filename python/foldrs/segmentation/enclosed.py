"""Objects that a table encloses, wherever in the picture it is.

On every way from the border to what lies on a table the colour has to change, while the table and all that
the border cuts are reached with little change (Wei, Wen, Zhu and Sun 2012, "Geodesic saliency using
background priors"). Objects are what stays together at some height of that barrier.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from ..image import Mask
from ..parameters import OutlineParameters
from .masks import disc, filled, parts, touches_border
from .table import FloatImage

__all__ = ["enclosed_objects"]

_BLUR = 1.0  # px, before colours are differentiated: half a rim
_LEAST_COST = 1e-3  # of a step where the colour does not change: among such ways the shorter
_LEVELS = 18  # heights of the barrier looked at: objects that differ by a fifth in height are told apart


def enclosed_objects(lab: FloatImage, parameters: OutlineParameters) -> Iterator[Mask]:
    """Yield everything that stays together at some height of the barrier from the border, from low to high.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB, coarse px.
    parameters : OutlineParameters
    """
    p, c = parameters, parameters.candidates
    barrier = _barrier(lab, p)
    for level in np.geomspace(c.lowest_barrier, max(c.lowest_barrier, 0.9 * float(barrier.max())), _LEVELS):
        above = cv2.morphologyEx((barrier > level).astype(np.uint8), cv2.MORPH_OPEN, disc(c.opening))
        for part in parts(above > 0, c.least_object):
            if not touches_border(part[1:-1, 1:-1]) and np.count_nonzero(part) <= p.most_share * part.size:
                yield filled(part)


def _barrier(lab: FloatImage, parameters: OutlineParameters) -> FloatImage:
    """Least change of colour on any way from the border to every pixel; what is usual costs nothing."""
    from skimage.graph import MCP_Geometric  # slow to import, and seldom needed

    blurred = cv2.GaussianBlur(lab, (0, 0), _BLUR)
    across, down = (cv2.Scharr(blurred, cv2.CV_32F, *order) / 32 for order in ((1, 0), (0, 1)))
    gradient = np.sqrt((across * across + down * down).sum(axis=2))
    usual = parameters.candidates.usual_gradient * float(np.median(gradient))
    cost = np.maximum(gradient - usual, 0.0) + _LEAST_COST
    border = np.ones(cost.shape, np.bool_)
    border[1:-1, 1:-1] = False
    barrier, _ = MCP_Geometric(cost).find_costs(np.argwhere(border))
    return np.asarray(barrier, np.float32)
