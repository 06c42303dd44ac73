"""The joint fit of template corners and crease (beyond the paper): the crate's results as explanations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.explanation import Explanation
from foldrs.result import FittedTemplate
from foldrs.template import Template


def fit_jointly(
    seen: _core.Seen, templates: Sequence[Template], px_per_unit: float | None, parameters: Mapping[str, Any]
) -> list[Explanation]:
    """Fit every template jointly with its crease, from all claims about its axis; the best first."""
    flexible = [flexible_template(t, parameters) for t in templates]
    outlines = [t.outline for t in templates]
    fits, unfolded = _core.fit_jointly(seen, outlines, flexible, px_per_unit)
    return [
        Explanation(
            template=templates[fit.template],
            original_axis=fit.original_axis,
            fitted=FittedTemplate(
                fit.outline, carried_landmarks(templates[fit.template], fit.outline), fit.axis
            ),
            to_image=fit.to_seen,
            crease=fit.crease,
            cost=fit.surprise,
            original_cost=fit.surprise,
            unfolded_cost=unfolded,
        )
        for fit in fits
    ]


def flexible_template(template: Template, parameters: Mapping[str, Any]) -> _core.FlexibleTemplate:
    """The template prepared for the crate, with the mirror pairs among its landmarks."""
    marks = template.landmarks
    one = np.array([marks[a] for a, _ in template.symmetry]).reshape(-1, 2)
    other = np.array([marks[b] for _, b in template.symmetry]).reshape(-1, 2)
    return _core.FlexibleTemplate(template.outline, one, other, parameters)


def carried_landmarks(template: Template, outline: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """The template's landmarks on an outline whose corners are the template's, moved."""
    _, _, arc = _core.nearest_on_outline(template.outline, template.landmark_array)
    ring = np.vstack([template.outline, template.outline[:1]])
    corner_arc = np.r_[0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T))]
    edge = np.clip(np.searchsorted(corner_arc, arc, side="right") - 1, 0, len(outline) - 1)
    share = ((arc - corner_arc[edge]) / (corner_arc[edge + 1] - corner_arc[edge]))[:, None]
    moved = np.vstack([outline, outline[:1]])
    points = moved[edge] * (1 - share) + moved[edge + 1] * share
    return dict(zip(template.landmarks, points, strict=True))
