"""Distinct explanations and how probable each is.

Two explanations are the same if they predict the same in the image: the same last crease, and the same
garment when unfolded (or its mirror image over the crease: which part was turned over cannot be told). So
the mirror twins of a symmetric template count once, whatever its symmetry.

Every kind is as probable as every other before the outline is seen, and each of its templates a like share of
that: a kind does not win for having more templates. What several templates of a kind explain alike adds up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from foldrs import _core
from foldrs.explanation import Explanation
from foldrs.parameters import AlternativeParameters
from foldrs.result import Alternative
from foldrs.template import Template


def distinct(
    explanations: Sequence[Explanation],
    templates: Sequence[Template],
    temperature: float,
    parameters: AlternativeParameters,
) -> list[Explanation]:
    """Keep the cheapest of every group of like explanations, the most probable first.

    Those whose creases do not fold the garment where it lies are left out.

    Parameters
    ----------
    explanations : sequence of Explanation
        Cheapest first.
    templates : sequence of Template
        All that competed, whether they explain anything or not.
    temperature : float
        Difference of cost at which an explanation is 1/e times as probable.
    parameters : AlternativeParameters

    Returns
    -------
    list of Explanation
        Each with the share of its kind that stands behind it as `weight`.
    """
    of_kind = Counter(kind for _, kind in {(id(t), t.garment_type) for t in templates})
    several = max(of_kind.values()) > 1
    groups: list[list[Explanation]] = []
    for one in explanations:
        like = next((group for group in groups if alike(one, group[0], parameters)), None)
        if like is not None:
            like.append(one)
        elif len(groups) < parameters.most and one.holds:
            groups.append([one])
        if len(groups) == parameters.most and not several:
            break  # dearer ones of the same template add nothing
    kept = [_weighted(group, of_kind, temperature) for group in groups]
    return sorted(kept, key=lambda one: one.cost - temperature * float(np.log(one.weight)))


def _weighted(group: Sequence[Explanation], of_kind: Counter[str], temperature: float) -> Explanation:
    """Return the cheapest of like explanations, weighted by what every template's best one adds to it."""
    first = group[0]
    best: dict[int, float] = {}
    for one in group:
        best.setdefault(id(one.template), one.cost)
    total = sum(float(np.exp(-(cost - first.cost) / temperature)) for cost in best.values())
    return replace(first, weight=total / of_kind[first.template.garment_type])


def alike(one: Explanation, other: Explanation, parameters: AlternativeParameters) -> bool:
    """Whether two explanations of a kind predict the same."""
    if one.template.garment_type != other.template.garment_type or len(one.folds) != len(other.folds):
        return False
    a, b = one.outline_image, other.outline_image
    twins = [b]
    if one.folds:
        last, other_last = one.folds[-1].axis_image, other.folds[-1].axis_image
        area = abs(_core.signed_area(a))
        if _core.axis_difference(last, other_last) > parameters.same_crease * area:
            return False
        twins.append(_core.reflect(b, other_last))
    return max(_core.outline_iou(a, twin) for twin in twins) >= parameters.same_overlap


def with_probabilities(explanations: Sequence[Explanation], temperature: float) -> tuple[Alternative, ...]:
    """Give explanations probabilities that fall exponentially with cost, times their weight; the sum is 1."""
    cost = np.array([e.cost for e in explanations])
    weight = np.array([e.weight for e in explanations]) * np.exp(-(cost - cost.min()) / temperature)
    return tuple(
        Alternative(e.template.garment_type, float(p), e.folds, e.fitted, e.outline_image)
        for e, p in zip(explanations, weight / weight.sum(), strict=True)
    )
