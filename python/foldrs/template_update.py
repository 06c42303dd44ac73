"""One pass of the fitting stage: a template becomes the next one (sections 2.2.1 to 2.2.3, Fig. 2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.parameters import FittingParameters
from foldrs.registration import (
    RegisteredFold,
    local_similarities,
    perimeter,
    register_fold,
    register_template,
    shares_apart,
)
from foldrs.straight_sides import SampledSides, new_corners, straight_lines

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TemplateUpdate:
    """How one pass changed a template, with all that lies between. Frames as in `RegisteredFold`."""

    fold: RegisteredFold
    """RVFC, RFAxis and VUC."""
    registered: Points
    """(k, 2) px: RUC, the registered points of the template."""
    lines: Mapping[int, Points]
    """Point and direction (px) of the straight line of every side that has one; side i starts at corner i."""
    corners: Points
    """(n, 2) px: corners of the updated template, where it lies."""
    outline: Points
    """(n, 2) template units: the updated template, upright; the next one to be matched."""


def update_template(
    outline: Points,
    axis: Points,
    laid: _core.Explanation,
    seen: Points,
    px_per_unit: float | None,
    parameters: FittingParameters,
) -> TemplateUpdate | None:
    """One pass of the fitting stage: the template that fits the seen outline better.

    Parameters
    ----------
    outline : (n, 2) array
        The template, template units.
    axis : (2, 2) array
        Its fold axis.
    laid : _core.Explanation
        The folded template laid over the seen outline.
    seen : (m, 2) array
        The seen points, px.
    px_per_unit : float or None
        The scale, if known.
    parameters : FittingParameters
        Parameters of the stage.

    Returns
    -------
    TemplateUpdate or None
        None if too little corresponds, or the updated outline would not be a simple polygon.
    """
    fold = register_fold(laid, seen, axis, parameters)
    if fold is None:
        return None
    sides = SampledSides.of(outline, perimeter(outline) / parameters.points)
    registered = register_template(outline, sides.at, fold, parameters)
    supported = shares_apart(outline, sides.at, fold.arc).min(axis=1) <= parameters.reach
    corners = register_template(outline, sides.corners, fold, parameters)

    unit = float(np.sqrt(abs(_core.signed_area(corners))))
    lines = straight_lines(registered, sides.side, supported, unit, parameters)
    corners = new_corners(corners, lines, unit, parameters)
    after = in_template_units(corners, outline, px_per_unit)
    try:
        _core.check_outline(after)
    except ValueError:
        return None
    if _core.signed_area(after) * _core.signed_area(outline) <= 0:
        return None
    return TemplateUpdate(fold, registered, lines, corners, after)


def in_template_units(corners: Points, outline: Points, px_per_unit: float | None) -> Points:
    """Corners in px as a template: upright, in template units; as large as `outline` if no scale is known."""
    back = local_similarities(np.ones((1, len(corners))), corners, outline)
    stretch = abs(back.turn[0]) * px_per_unit if px_per_unit is not None else 1.0
    upright = back.apply(corners)
    middle = upright.mean(axis=0)
    scaled: Points = middle + (upright - middle) / stretch
    return scaled
