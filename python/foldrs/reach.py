"""How probably a gripper reaches a landmark (beyond the paper, which takes the fitted model at its word).

Where a hidden layer ends is known to a few centimetres at best, of a garment in halves not even which of two
layers sticks out, and another explanation may be the true one. So every explanation told counts by its
probability, and of each garments are drawn from what is as likely; a landmark's probability is the share of
those garments on which a gripper would reach it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.explanation import Explanation, Points
from foldrs.parameters import GraspParameters

Weighed: TypeAlias = tuple[Explanation, float]
"""An explanation and its probability."""


@dataclass(frozen=True, eq=False)
class Reach:
    """Which landmarks are within reach, garment by garment."""

    names: tuple[str, ...]
    """The k landmarks."""
    weights: NDArray[np.float64]
    """(d,) probability of every garment drawn; the sum is 1, or less where draws do not fold."""
    within: NDArray[np.bool_]
    """(d, k) whether a gripper would reach the landmark of that garment where it is told to lie."""

    def of(self, *landmarks: str) -> float:
        """Probability that all of these landmarks are within reach at once."""
        columns = [self.names.index(name) for name in landmarks]
        return min(1.0, float(self.weights[self.within[:, columns].all(axis=1)].sum()))


def reach_over(
    explanations: Sequence[Weighed],
    told: Mapping[str, Points],
    px_per_unit: float,
    parameters: GraspParameters,
) -> Reach | None:
    """Tell which landmarks are within reach over all explanations and what is as likely as each.

    Within reach: on the outline, no double layer near (section 3.2), and the landmark not farther from where
    it is told to lie than a grasp's margin.

    Parameters
    ----------
    explanations : sequence of (Explanation, float)
        With their probabilities. Those of other kinds, without these landmarks, reach none of them.
    told : mapping of str to (2,) array
        Where the landmarks are told to lie, image px.
    px_per_unit : float
        Scale of the picture: px a template unit.
    parameters : GraspParameters

    Returns
    -------
    Reach or None
        None if there is nothing to be drawn from: no landmark, or explanations of the published method.
    """
    if not told:
        return None
    names, places = tuple(told), np.array(list(told.values()))
    total = sum(probability for _, probability in explanations)
    weights: list[NDArray[np.float64]] = []
    within: list[NDArray[np.bool_]] = []
    for explanation, probability in explanations:
        joint = explanation.joint
        if joint is None:
            return None
        # Draws come in pairs about the fit; of an improbable explanation fewer do.
        most = 2 * math.ceil(joint.draws * probability / total / 2)
        reached = _reached(explanation, joint, max(1, most), names, places, px_per_unit, parameters)
        if reached.shape[0]:
            weights.append(np.full(reached.shape[0], probability / total / reached.shape[0]))
            within.append(reached)
    return Reach(names, np.concatenate(weights), np.concatenate(within)) if weights else None


def _reached(
    explanation: Explanation,
    joint: _core.JointExplanation,
    most: int,
    names: tuple[str, ...],
    places: Points,
    px_per_unit: float,
    parameters: GraspParameters,
) -> NDArray[np.bool_]:
    """(d, k) whether the landmarks are within reach, of up to so many garments drawn from one explanation."""
    marks, template, p = explanation.fitted.landmarks, explanation.template, parameters
    if set(names) != set(marks):
        return np.zeros((1, len(names)), dtype=np.bool_)
    points = np.array([marks[name] for name in names])
    lying, off_outline, to_double_layer = joint.reach_drawn(points, most)
    reachable = (to_double_layer > p.clearance * px_per_unit) & (off_outline <= p.on_outline * px_per_unit)

    # Left and right cannot be told apart: the garment's mirror twin is the same explanation.
    twins = {a: b for pair in template.symmetry for a, b in (pair, pair[::-1])}
    order = [names.index(twins.get(name, name)) for name in names]
    away = np.linalg.norm(lying - places, axis=2)
    away_twin = np.linalg.norm(lying[:, order] - places, axis=2)
    turned = (away_twin.mean(axis=1) < away.mean(axis=1))[:, None]
    near = np.where(turned, away_twin, away) <= p.margin * px_per_unit
    return np.asarray(near & np.where(turned, reachable[:, order], reachable), np.bool_)
