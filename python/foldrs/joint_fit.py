"""The joint fit of template corners and creases (beyond the paper): the crate's results as explanations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Literal, TypeAlias

import numpy as np

from foldrs import _core
from foldrs.explanation import Explanation, Points
from foldrs.landmark import carried
from foldrs.parameters import Parameters
from foldrs.picture import Picture
from foldrs.registration import perimeter
from foldrs.result import FittedTemplate, Fold
from foldrs.template import Template

Folds: TypeAlias = int | Literal["auto"]
"""How many folds to undo; ``"auto"``: as many as explain more than their freedom costs."""


def fit_jointly(
    seen: _core.Seen,
    templates: Sequence[Template],
    px_per_unit: float | None,
    picture: Picture | None,
    folds: Folds,
    parameters: Parameters,
) -> list[Explanation]:
    """Fit every template jointly with its creases, from all claims about its axis; the best first."""
    flexible = [flexible_template(t, asdict(parameters.matching)) for t in templates]
    outlines = [t.outline for t in templates]
    fits = _core.fit_jointly(
        seen,
        outlines,
        flexible,
        parameters.alternatives.most_folds if folds == "auto" else folds,
        folds == "auto",
        px_per_unit,
        None if picture is None else _for_core(picture),
    )
    number = fits.enough if folds == "auto" else folds
    sure = parameters.picture.sure
    return [
        explanation(templates[fit.template], fit, fits.surprise(0), sure) for fit in fits.explanations(number)
    ]


def _for_core(picture: Picture) -> tuple[Any, ...]:
    """Give the picture the form the crate takes."""
    edges, looks = picture.edges, picture.looks
    return edges.tensor, edges.scale, edges.steps, (looks.look, looks.scale, looks.origin)


def explanation(template: Template, fit: _core.JointExplanation, unfolded: float, sure: float) -> Explanation:
    """Tell a joint fit as an explanation; `unfolded` is what explaining it without folds costs."""
    # Which layer is on top has been looked for only where there are two.
    on_top = layer_on_top(fit.flap_on_top, sure) if len(fit.axes) == 1 else None
    return Explanation(
        template=template,
        original_axis=axis_on(template.outline, fit),
        fitted=FittedTemplate(
            fit.outline,
            carried(template.landmarks, template.outline, fit.outline),
            fit.axes[0] if fit.axes else None,
        ),
        to_image=fit.to_seen,
        folds=tuple(Fold(crease, axis, on_top) for crease, axis in zip(fit.creases, fit.axes, strict=True)),
        cost=fit.surprise,
        original_cost=fit.surprise,
        unfolded_cost=unfolded,
        joint=fit,
    )


def flexible_template(template: Template, parameters: Mapping[str, Any]) -> _core.FlexibleTemplate:
    """Prepare a template for the crate, with the mirror pairs among its landmarks."""
    one, other = template.mirror_pairs
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
    length = perimeter(outline)
    known, vertices = arcs[: len(marks)], arcs[len(marks) :]
    return [float(s) for s in np.interp(vertices, known, list(template.spread.values()), period=length)]


def axis_on(outline: Points, fit: _core.JointExplanation) -> Points | None:
    """Carry the first fitted axis to the template as given: its ends at the same shares of the same edges."""
    if not fit.axes:
        return None
    first, last = fit.axes[0]
    ends = carried({"first": first, "last": last}, fit.outline, outline)
    return np.array([ends["first"], ends["last"]])


def layer_on_top(nats: float, sure: float) -> bool | None:
    """Whether the flap lies on top, by how much more likely that is; None where it cannot be told."""
    return None if abs(nats) < sure else nats > 0
