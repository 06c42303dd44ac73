"""Whether probabilities mean what they say: of what is called 70 % likely, about 70 % should be right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foldrs.evaluation.measures import SceneMeasures

EDGES = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0)
"""Bounds of the bins of probability: finer at both ends, where most explanations are."""


@dataclass(frozen=True)
class Reliability:
    """Explanations, or grasp pairs, of like probability."""

    said: float
    """Mean of their probabilities."""
    happened: float
    """Share of them that are right."""
    cases: int


def reliability(rows: Sequence[SceneMeasures], *, first_only: bool = False) -> list[Reliability]:
    """Compare probabilities with what happened, bin by bin; bins without cases are left out.

    Parameters
    ----------
    rows : sequence of SceneMeasures
        Scenes folded once.
    first_only : bool
        Look at the chosen explanations only, not at all alternatives.
    """
    return _binned([chance for row in rows for chance in (row.chances[:1] if first_only else row.chances)])


def reliability_of_pairs(rows: Sequence[SceneMeasures]) -> list[Reliability]:
    """Compare the probabilities of the first grasp pairs with what happened, as :func:`reliability` does."""
    return _binned(
        [
            (row.pair_said, row.pair_right)
            for row in rows
            if row.pair_said is not None and row.pair_right is not None
        ]
    )


def _binned(chances: Sequence[tuple[float, bool]]) -> list[Reliability]:
    if not chances:
        return []
    said, right = np.array(chances, dtype=np.float64).T
    place = np.clip(np.searchsorted(EDGES, said, side="right") - 1, 0, len(EDGES) - 2)
    return [
        Reliability(float(said[place == k].mean()), float(right[place == k].mean()), int((place == k).sum()))
        for k in np.unique(place)
    ]
