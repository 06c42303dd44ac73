"""Stage 5, the fitting stage (section 2.2): templates changed until they fit the seen outline.

Every iteration matches the templates as they are, registers each one's cheapest fold to the seen outline, unfolds it
virtually and makes the next template of it. The cheapest match of all iterations wins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.explanation import Explanation, apply, directed_crease
from foldrs.parameters import FittingParameters
from foldrs.registration import RegisteredFold, local_similarities, register_fold, register_template, visible_weights
from foldrs.result import FittedTemplate
from foldrs.template import Template
from foldrs.template_update import SampledSides, carried, new_corners, straight_lines

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TemplateUpdate:
    """How a template was changed in one iteration, with all that lies between; frames as in `RegisteredFold`."""

    before: Points
    """(n, 2) the outline that was matched, template units."""
    axis: Points
    """(2, 2) the axis found on it, template units."""
    cost: float
    """Its matching cost."""
    fold: RegisteredFold
    """RVFC, RFAxis and VUC."""
    registered: Points
    """(k, 2) px: RUC, the registered points of the template."""
    lines: Mapping[int, Points]
    """Point and direction (px) of the line of every side that has one."""
    corners: Points
    """(n, 2) px: the corners of the updated template."""
    after: Points
    """(n, 2) the updated outline, template units: the next one to be matched."""


def update_template(
    outline: Points, axis: Points, laid: _core.Explanation, seen: Points, px_per_unit: float | None, parameters: FittingParameters
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
    length = float(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum())
    sides = SampledSides.of(outline, length / parameters.points)
    registered = register_template(outline, sides.at, fold, parameters)
    supported = visible_weights(outline, sides.at, fold, parameters).max(axis=1) > parameters.visible
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
    return TemplateUpdate(outline, axis, laid.cost, fold, registered, lines, corners, after)


def in_template_units(corners: Points, outline: Points, px_per_unit: float | None) -> Points:
    """Corners in px as a template: turned upright, in template units (as large as `outline` if no scale is known)."""
    back = local_similarities(np.ones((1, len(corners))), corners, outline)
    px = abs(back.turn[0]) * px_per_unit if px_per_unit is not None else 1.0
    upright = back.apply(corners, slice(None))
    middle = upright.mean(axis=0)
    return middle + (upright - middle) / px
