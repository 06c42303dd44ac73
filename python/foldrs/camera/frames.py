"""What a robot needs of a result, in a frame other than the image: on the table, or in the robot's base."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from foldrs.result import FitResult, GraspMove, UnfoldingAction, action_to_dict, plain_probability

Points = npt.NDArray[np.float64]

_DIGITS = {"cm": 4, "m": 6}
"""Decimals written: a micrometre either way."""


@dataclass(frozen=True, eq=False)
class PairInFrame:
    """Two accessible landmarks to grasp the garment by."""

    landmarks: tuple[str, str]
    points: Points
    """(2, d), in the order of the names."""
    probability: float | None
    """Probability that both are within reach; None with method "paper"."""


@dataclass(frozen=True, eq=False)
class ResultInFrame:
    """Where the garment, its creases and its grasp points lie; points have d coordinates."""

    units: str
    """``"cm"`` on the table (d = 2), ``"m"`` in the robot's base (d = 3)."""
    outline: Points
    """(n, d): the outline seen."""
    creases: tuple[Points, ...]
    """(2, d) each: the fold axes, first made first."""
    unfolded_outline: Points
    """(n, d): the garment unfolded again where it lies."""
    landmarks: Mapping[str, Points]
    """(d,) each."""
    grasp_pairs: tuple[PairInFrame, ...]
    """Accessible pairs, best first."""
    unfolding_plan: tuple[UnfoldingAction, ...]
    """How to undo all folds, the last made first; `clearance` stays in template units."""

    @property
    def unfolding(self) -> UnfoldingAction | None:
        """How to undo the last fold; None if there is none."""
        return self.unfolding_plan[0] if self.unfolding_plan else None

    @classmethod
    def of(cls, result: FitResult, units: str, carry: Callable[[Points], Points]) -> ResultInFrame:
        """Carry the image points of a result, by a map of (n, 2) points to (n, d)."""
        marks = np.array([mark.image for mark in result.landmarks.values()]).reshape(-1, 2)
        return cls(
            units=units,
            outline=carry(result.outline_image),
            creases=tuple(carry(fold.axis_image) for fold in result.folds),
            unfolded_outline=carry(result.unfolded_outline_image),
            landmarks=dict(zip(result.landmarks, carry(marks), strict=True)),
            grasp_pairs=tuple(
                PairInFrame(pair.landmarks, carry(pair.image), pair.probability)
                for pair in result.grasp_pairs
            ),
            unfolding_plan=tuple(carried_unfolding(action, carry) for action in result.unfolding_plan),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, lists and dictionaries: the JSON form."""
        digits = _DIGITS[self.units]

        def plain(points: Points) -> Any:
            return np.round(points, digits).tolist()

        return {
            "units": self.units,
            "outline": plain(self.outline),
            "fold": {"axis": plain(self.creases[-1])} if self.creases else None,
            "folds": [{"axis": plain(crease)} for crease in self.creases],
            "unfolded_outline": plain(self.unfolded_outline),
            "landmarks": {name: plain(point) for name, point in self.landmarks.items()},
            "grasp_pairs": [
                {
                    "landmarks": list(pair.landmarks),
                    "points": plain(pair.points),
                    "probability": plain_probability(pair.probability),
                }
                for pair in self.grasp_pairs
            ],
            "unfolding": None if self.unfolding is None else action_to_dict(self.unfolding, digits),
            "unfolding_plan": [action_to_dict(action, digits) for action in self.unfolding_plan],
        }


def carried_unfolding(action: UnfoldingAction, carry: Callable[[Points], Points]) -> UnfoldingAction:
    """Carry the points of an unfolding action into another frame."""

    def moved(move: GraspMove) -> GraspMove:
        pick, place = carry(np.array([move.pick, move.place]))
        return GraspMove(move.landmark, pick, place, move.clearance)

    both, one = action.two_arms, action.one_arm
    return UnfoldingAction(
        two_arms=None if both is None else (moved(both[0]), moved(both[1])),
        one_arm=None if one is None else moved(one),
    )
