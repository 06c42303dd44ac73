"""Distinct explanations and how probable each is.

Two explanations are the same if they predict the same in the image: the same last crease, and the same
garment when unfolded (or its mirror image over the crease: which part was turned over cannot be told). So
the mirror twins of a symmetric template count once, whatever its symmetry.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from foldrs import _core
from foldrs.explanation import Explanation
from foldrs.parameters import AlternativeParameters
from foldrs.result import Alternative


def distinct(explanations: Sequence[Explanation], parameters: AlternativeParameters) -> list[Explanation]:
    """Keep the cheapest of every group of like explanations, in the order given (cheapest first).

    Those whose creases do not fold the garment where it lies are left out.
    """
    kept: list[Explanation] = []
    for one in explanations:
        if len(kept) == parameters.most:
            break
        if not any(alike(one, other, parameters) for other in kept) and one.holds:
            kept.append(one)
    return kept


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
    """Give explanations probabilities that fall exponentially with cost and sum to 1."""
    cost = np.array([e.cost for e in explanations])
    weight = np.exp(-(cost - cost.min()) / temperature)
    return tuple(
        Alternative(e.template.garment_type, float(p), e.folds, e.fitted, e.outline_image)
        for e, p in zip(explanations, weight / weight.sum(), strict=True)
    )
