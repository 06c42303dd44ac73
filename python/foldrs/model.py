"""Stage 6, the polygon model of the folded garment and its grasp points (section 3).

The model is the fitted template's polygon in the image with the creases (eq. 3 and 4). Folding it says which
landmarks were turned over, where the layers overlap, and which landmarks a gripper can reach. It holds for
any number of folds; without any the garment lies in one layer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.explanation import Explanation
from foldrs.landmark import carried
from foldrs.parameters import GraspParameters
from foldrs.reach import Reach, Weighed, reach_over
from foldrs.registration import perimeter
from foldrs.result import GraspMove, GraspPair, LandmarkInImage, UnfoldingAction

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FoldedModel:
    """The augmented polygon model [F_axis | L0] (eq. 4), in image px."""

    explanation: Explanation
    px_per_unit: float
    """Scale of the picture: px a template unit."""
    parameters: GraspParameters
    seen_outline: Points | None
    """(n, 2) px: the outline seen in the image; None if it has not been seen."""
    among: Sequence[Weighed] = ()
    """All explanations told, this one too, with their probabilities; none if the model is to be believed."""

    @cached_property
    def unfolded_outline(self) -> Points:
        """(n, 2) px: the garment unfolded again, its kept part where it lies."""
        return self.explanation.outline_image

    @cached_property
    def layers(self) -> _core.FoldedStack:
        """The layers of the folded model."""
        return self.explanation.layers

    @cached_property
    def landmarks(self) -> Mapping[str, LandmarkInImage]:
        """Every landmark where it lies now, and whether it is accessible (section 3.2).

        Accessible: on the folded outline, and no double layer within a radius; among several explanations, if
        that is probable enough over all of them.
        """
        places = self._places
        if self.reach is None:
            within = self._clear_by(self.parameters.clearance) & self._visible
            return {n: LandmarkInImage(p, bool(w)) for (n, p), w in zip(places.items(), within, strict=True)}
        chances = {name: self.reach.of(name) for name in places}
        likely = self.parameters.likely
        return {n: LandmarkInImage(p, chances[n] >= likely, chances[n]) for n, p in places.items()}

    @cached_property
    def reach(self) -> Reach | None:
        """Which landmarks are within reach over all explanations; None if the model is to be believed."""
        return reach_over(self.among, self._places, self.px_per_unit, self.parameters)

    @cached_property
    def _places(self) -> Mapping[str, Points]:
        """Where every landmark lies now, px: moved onto the seen outline if it is visible."""
        now = self._folded
        if self.seen_outline is not None:
            now = np.where(self._visible[:, None], self._onto(self.seen_outline, now), now)
        return dict(zip(self.explanation.fitted.landmarks, now, strict=True))

    @cached_property
    def _visible(self) -> NDArray[np.bool_]:
        """(k,) whether every landmark lies on the folded outline."""
        _, off_outline, _ = _core.nearest_on_outline(self.layers.outline, self._folded)
        return np.asarray(off_outline <= self.parameters.on_outline * self.px_per_unit)

    @cached_property
    def _folded(self) -> Points:
        """(k, 2) px: where folding the model puts every landmark, in the template's order."""
        fitted = self.explanation.fitted
        marks = carried(fitted.landmarks, fitted.outline, self.unfolded_outline)
        unfolded = np.array(list(marks.values()))
        _, _, arc = _core.nearest_on_outline(self.unfolded_outline, unfolded)
        return self.layers.place(unfolded, arc)

    def _clear_by(self, radius: float) -> NDArray[np.bool_]:
        """(k,) whether no double layer lies within a radius, template units, of every landmark."""
        away = self.layers.distance_to_double_layer(self._folded)
        return np.asarray(away > radius * self.px_per_unit)

    def _onto(self, seen: Points, points: Points) -> Points:
        """Points of the model's outline moved onto the seen one: to a like corner near by, else straight."""
        unit = float(np.sqrt(abs(_core.signed_area(seen))))
        corners = _core.simplify(seen, self.parameters.corner_tolerance * unit)
        apart = np.linalg.norm(points[:, None] - corners[None], axis=2)
        # A hem's corner is not the armpit next to it, nor the end of the crease.
        arm = self.parameters.corner_arm * self.px_per_unit
        turns, those = turns_at(self.layers.outline, points, arm), turns_at(seen, corners, arm)
        unlike = np.abs(turns[:, None] - those[None]) > np.radians(self.parameters.corner_likeness)
        apart[unlike] = np.inf
        nearest, distance, _ = _core.nearest_on_outline(seen, points)
        limit = self.parameters.snap * self.px_per_unit
        onto = np.where((distance <= limit)[:, None], nearest, points)
        at_corner = apart.min(axis=1) <= self.parameters.snap_corner * self.px_per_unit
        return np.where(at_corner[:, None], corners[apart.argmin(axis=1)], onto)

    @cached_property
    def grasp_pairs(self) -> tuple[GraspPair, ...]:
        """The template's grasp pairs of which both points are accessible.

        The most probable ones come first, else those with ample room, for where layers end is not known to
        the centimetre; of ones about as good the order is the template's order of preference.
        """
        marks = self.landmarks
        pairs = [
            GraspPair(
                (a, b),
                np.array([marks[a].image, marks[b].image]),
                None if self.reach is None else self.reach.of(a, b),
            )
            for a, b in self.explanation.template.grasp_pairs
            if marks[a].accessible and marks[b].accessible
        ]
        if self.reach is not None:
            return _ranked(pairs, self.parameters.as_good)
        ample = dict(zip(marks, self._clear_by(self.parameters.ample), strict=True))
        return tuple(sorted(pairs, key=lambda pair: not all(ample[name] for name in pair.landmarks)))

    @cached_property
    def unfolding(self) -> UnfoldingAction | None:
        """Undoing the last fold: what is picked goes to its mirror image over the crease; None without."""
        if not self.explanation.folds:
            return None
        crease = self.explanation.folds[-1].axis_image
        pair = self.grasp_pairs[0].landmarks if self.grasp_pairs else None
        reachable = {name: mark for name, mark in self.landmarks.items() if mark.accessible}

        def turned(name: str) -> float:
            reach = reachable[name].reach
            return self._off_crease(name, crease) * (1.0 if reach is None else reach)

        farthest = max(reachable, key=turned, default=None)
        return UnfoldingAction(
            two_arms=None if pair is None else (self._move(pair[0], crease), self._move(pair[1], crease)),
            one_arm=None if farthest is None else self._move(farthest, crease),
        )

    @cached_property
    def unfolding_plan(self) -> tuple[UnfoldingAction, ...]:
        """Undoing all folds, the last made first; each action as the garment then lies."""
        if self.unfolding is None:
            return ()
        earlier = replace(self.explanation, folds=self.explanation.folds[:-1])
        # What a fold hid has not been seen: there the model has to do.
        then = replace(self, explanation=earlier, seen_outline=None, among=())
        return (self.unfolding, *then.unfolding_plan)

    def _move(self, name: str, crease: Points) -> GraspMove:
        pick = self.landmarks[name].image
        place = _core.reflect(pick[None], crease)[0]
        clearance = float(self.layers.distance_to_double_layer(pick[None])[0]) / self.px_per_unit
        return GraspMove(name, pick, place, clearance)

    def _off_crease(self, name: str, crease: Points) -> float:
        """Distance of a landmark from the crease's line, px."""
        pick = self.landmarks[name].image
        return float(np.linalg.norm(_core.reflect(pick[None], crease)[0] - pick)) / 2.0


def _ranked(pairs: Sequence[GraspPair], as_good: float) -> tuple[GraspPair, ...]:
    """Put the most probable pairs first; of what is left those about as good as the best as they stand."""
    ranked: list[GraspPair] = []
    left = [(pair, pair.probability or 0.0) for pair in pairs]
    while left:
        least = max(probability for _, probability in left) - as_good
        ranked += [pair for pair, probability in left if probability >= least]
        left = [(pair, probability) for pair, probability in left if probability < least]
    return tuple(ranked)


def turns_at(outline: Points, points: Points, arm: float) -> NDArray[np.float64]:
    """By how much a closed outline turns at points near it, radians, positive where it bulges outwards.

    Parameters
    ----------
    outline : (n, 2) array
    points : (k, 2) array
    arm : float
        Distance along the outline before and behind each point over which the turn is taken.
    """
    ring = outline if _core.signed_area(outline) > 0 else outline[::-1].copy()
    length = perimeter(ring)
    _, _, arc = _core.nearest_on_outline(ring, points)
    before, here, behind = (_core.points_at(ring, (arc + step) % length) for step in (-arm, 0.0, arm))
    (ux, uy), (vx, vy) = (here - before).T, (behind - here).T
    return np.asarray(np.arctan2(ux * vy - uy * vx, ux * vx + uy * vy))
