"""Stages 1 to 4, the matching stage (section 2.1): the crate's results as explanations."""

from __future__ import annotations

from collections.abc import Sequence

from foldrs import _core
from foldrs.explanation import Explanation, Points, apply, directed_crease
from foldrs.result import FittedTemplate
from foldrs.template import Template


def match(
    seen: _core.Seen, templates: Sequence[Template], px_per_unit: float | None, most: int
) -> list[Explanation]:
    """The cheapest `most` folds of all templates as explanations, cheapest first; the templates stay as they are."""
    candidates, unfolded = seen.matches([t.outline for t in templates], px_per_unit)
    explanations = []
    for candidate in candidates[:most]:
        template = templates[candidate.template]
        laid = seen.explain(template.outline, candidate)
        if laid is None or not folds(laid.to_seen, template, laid.crease):
            continue
        explanations.append(
            Explanation(
                template=template,
                original_axis=candidate.axis,
                fitted=FittedTemplate(template.outline, template.landmarks, candidate.axis),
                to_image=laid.to_seen,
                crease=directed_crease(laid.crease, candidate.axis, laid.to_seen),
                cost=candidate.cost,
                original_cost=candidate.cost,
                unfolded_cost=unfolded[candidate.template],
            )
        )
    return explanations


def folds(to_image: Points, template: Template, crease: Points) -> bool:
    """Whether the crease folds the template where it is laid; a poor map may carry it off."""
    try:
        _core.fold_layers(apply(to_image, template.outline), crease)
    except ValueError:
        return False
    return True
