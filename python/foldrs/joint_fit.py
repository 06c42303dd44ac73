"""The joint fit of template corners and crease (beyond the paper): the crate's results as explanations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from foldrs import _core
from foldrs.explanation import Explanation, Points
from foldrs.landmark import carried
from foldrs.parameters import Parameters
from foldrs.picture import ColourEdges
from foldrs.result import FittedTemplate
from foldrs.template import Template


def fit_jointly(
    seen: _core.Seen,
    templates: Sequence[Template],
    px_per_unit: float | None,
    edges: ColourEdges | None,
    parameters: Parameters,
) -> list[Explanation]:
    """Fit every template jointly with its crease, from all claims about its axis; the best first."""
    flexible = [flexible_template(t, asdict(parameters.matching)) for t in templates]
    outlines = [t.outline for t in templates]
    fits, unfolded = _core.fit_jointly(
        seen,
        outlines,
        flexible,
        px_per_unit,
        None if edges is None else edges.tensor,
        1.0 if edges is None else edges.scale,
    )
    return [
        Explanation(
            template=templates[fit.template],
            original_axis=axis_on(templates[fit.template].outline, fit),
            fitted=FittedTemplate(
                fit.outline,
                carried(templates[fit.template].landmarks, templates[fit.template].outline, fit.outline),
                fit.axis,
            ),
            to_image=fit.to_seen,
            crease=fit.crease,
            cost=fit.surprise,
            original_cost=fit.surprise,
            unfolded_cost=unfolded,
            flap_on_top=layer_on_top(fit.flap_on_top, parameters.picture.sure),
        )
        for fit in fits
    ]


def flexible_template(template: Template, parameters: Mapping[str, Any]) -> _core.FlexibleTemplate:
    """Prepare a template for the crate, with the mirror pairs among its landmarks."""
    marks = template.landmarks
    one = np.array([marks[a] for a, _ in template.symmetry]).reshape(-1, 2)
    other = np.array([marks[b] for _, b in template.symmetry]).reshape(-1, 2)
    return _core.FlexibleTemplate(template.outline, one, other, parameters, vertex_spreads(template))


def vertex_spreads(template: Template) -> list[float] | None:
    """Spread of every vertex of a template's outline, between landmarks by its way along the outline.

    None if the template tells no spread.
    """
    if not template.spread:
        return None
    marks = np.array([template.landmarks[name] for name in template.spread])
    outline = template.outline
    _, _, arcs = _core.nearest_on_outline(outline, np.vstack([marks, outline]))
    length = float(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum())
    known, vertices = arcs[: len(marks)], arcs[len(marks) :]
    return [float(s) for s in np.interp(vertices, known, list(template.spread.values()), period=length)]


def axis_on(outline: Points, fit: _core.JointExplanation) -> Points:
    """Carry the fitted axis to the template as given: its ends at the same shares of the same edges."""
    ends = carried({"first": fit.axis[0], "last": fit.axis[1]}, fit.outline, outline)
    return np.array([ends["first"], ends["last"]])


def layer_on_top(nats: float, sure: float) -> bool | None:
    """Whether the flap lies on top, by how much more likely that is; None where it cannot be told."""
    return None if abs(nats) < sure else nats > 0
