"""Stage 6, the polygon model of the folded garment and its grasp points (section 3).

The model is the fitted template's polygon in the image with the crease (eq. 3 and 4). Folding it says which
landmarks lie on the flap, where the layers overlap, and which landmarks a gripper can reach.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.explanation import Explanation
from foldrs.landmark import carried
from foldrs.parameters import GraspParameters
from foldrs.result import GraspMove, GraspPair, LandmarkInImage, UnfoldingAction

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FoldedModel:
    """The augmented polygon model [F_axis | L0] (eq. 4), in image px."""

    explanation: Explanation
    px_per_unit: float
    """Scale of the picture: px a template unit."""
    parameters: GraspParameters
    seen_outline: Points
    """(n, 2) px: the outline seen in the image."""

    @cached_property
    def unfolded_outline(self) -> Points:
        """(n, 2) px: the garment unfolded again, its kept part where it lies."""
        return self.explanation.outline_image

    @cached_property
    def layers(self) -> _core.FoldedLayers:
        """The layers of the folded model."""
        return _core.fold_layers(self.unfolded_outline, self.explanation.crease)

    @cached_property
    def landmarks(self) -> Mapping[str, LandmarkInImage]:
        """Every landmark where it lies now, and whether it is accessible (section 3.2).

        Accessible: on the folded outline, and no double layer within a radius.
        """
        fitted = self.explanation.fitted
        marks = carried(fitted.landmarks, fitted.outline, self.unfolded_outline)
        names, unfolded = list(marks), np.array(list(marks.values()))
        _, _, arc = _core.nearest_on_outline(self.unfolded_outline, unfolded)
        turned = self.layers.is_turned(arc)
        now = np.where(turned[:, None], _core.reflect(unfolded, self.explanation.crease), unfolded)
        _, off_outline, _ = _core.nearest_on_outline(self.layers.outline, now)
        clear = self.layers.distance_to_double_layer(now) > self.parameters.clearance * self.px_per_unit
        visible = off_outline <= self.parameters.on_outline * self.px_per_unit
        now = np.where(visible[:, None], self._on_seen_outline(now), now)
        return {n: LandmarkInImage(p, bool(r)) for n, p, r in zip(names, now, clear & visible, strict=True)}

    def _on_seen_outline(self, points: Points) -> Points:
        """Points of the model's outline moved onto the seen one: to a corner near by, else straight to it."""
        unit = float(np.sqrt(abs(_core.signed_area(self.seen_outline))))
        corners = _core.simplify(self.seen_outline, self.parameters.corner_tolerance * unit)
        apart = np.linalg.norm(points[:, None] - corners[None], axis=2)
        nearest, distance, _ = _core.nearest_on_outline(self.seen_outline, points)
        limit = self.parameters.snap * self.px_per_unit
        onto = np.where((distance <= limit)[:, None], nearest, points)
        at_corner = apart.min(axis=1) <= self.parameters.snap_corner * self.px_per_unit
        return np.where(at_corner[:, None], corners[apart.argmin(axis=1)], onto)

    @cached_property
    def grasp_pairs(self) -> tuple[GraspPair, ...]:
        """The template's grasp pairs of which both points are accessible, in its order of preference."""
        marks = self.landmarks
        return tuple(
            GraspPair((a, b), np.array([marks[a].image, marks[b].image]))
            for a, b in self.explanation.template.grasp_pairs
            if marks[a].accessible and marks[b].accessible
        )

    @cached_property
    def unfolding(self) -> UnfoldingAction:
        """Undoing the fold: every point picked goes to its mirror image over the crease."""
        pair = self.grasp_pairs[0].landmarks if self.grasp_pairs else None
        reachable = [name for name, mark in self.landmarks.items() if mark.accessible]
        farthest = max(reachable, key=self._reach, default=None)
        return UnfoldingAction(
            two_arms=None if pair is None else (self._move(pair[0]), self._move(pair[1])),
            one_arm=None if farthest is None else self._move(farthest),
        )

    def _move(self, name: str) -> GraspMove:
        pick = self.landmarks[name].image
        place = _core.reflect(pick[None], self.explanation.crease)[0]
        clearance = float(self.layers.distance_to_double_layer(pick[None])[0]) / self.px_per_unit
        return GraspMove(name, pick, place, clearance)

    def _reach(self, name: str) -> float:
        """Distance of a landmark from the crease's line, px."""
        pick = self.landmarks[name].image
        return float(np.linalg.norm(_core.reflect(pick[None], self.explanation.crease)[0] - pick)) / 2.0
