"""An explanation of an outline: a template, how it was changed, its folds, where it lies in the image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.result import FittedTemplate, Fold
from foldrs.template import Template

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Explanation:
    """A folded template laid over the seen outline. Every method of fitting ends in these."""

    template: Template
    """The template as given."""
    original_axis: Points | None
    """(2, 2) axis found on it by the matching stage, template units; of several folds that of the first
    made; None if there is no fold."""
    fitted: FittedTemplate
    """The fitted template with its axis; its outline has the vertices of the given one, moved."""
    to_image: Points
    """(2, 3) similarity from template units to image px; reflecting if the garment shows its other face."""
    folds: tuple[Fold, ...]
    """First made first; empty for a garment that lies unfolded. The flap was on a crease's left (from x
    towards y) before it was turned."""
    cost: float
    """Cost of the method that made it; comparable within that method."""
    original_cost: float
    """Cost found by the matching stage on the template as given."""
    unfolded_cost: float
    """Cost of the same template unfolded."""
    placed: Points | None = None
    """(n, 2) px: the fitted template's corners where a piecewise registration puts them; None if they lie
    where `to_image` puts them."""

    joint: _core.JointExplanation | None = None
    """The joint fit it tells of, from which garments as likely are drawn; None of the published method."""
    weight: float = 1.0
    """Share of its kind's prior probability that stands behind it, of 1: less where the kind has several
    templates (:mod:`foldrs.alternatives`)."""

    @property
    def accepted(self) -> bool:
        """Whether the folds explain the outline better than the unfolded template."""
        return bool(self.folds) and self.cost < self.unfolded_cost

    @property
    def outline_image(self) -> Points:
        """(n, 2) px: the fitted template unfolded, its kept part where it lies."""
        return apply(self.to_image, self.fitted.outline) if self.placed is None else self.placed

    @property
    def layers(self) -> _core.FoldedStack:
        """The garment folded where it lies.

        Raises
        ------
        ValueError
            If a crease does not fold it; see `holds`.
        """
        creases = [fold.axis_image for fold in self.folds]
        on_top = [fold.flap_on_top is not False for fold in self.folds]
        return _core.fold_stack(self.outline_image, creases, on_top)

    @property
    def holds(self) -> bool:
        """Whether every crease folds the template where it lies; a poor map may carry it off."""
        try:
            _ = self.layers
        except ValueError:
            return False
        return True


def apply(plane_map: Points, points: Points) -> Points:
    """Apply a (2, 3) map to (n, 2) points."""
    mapped: Points = points @ plane_map[:, :2].T + plane_map[:, 2]
    return mapped


def directed_crease(crease: Points, axis: Points, to_image: Points) -> Points:
    """Direct the crease so that it has the flap on its left, as `axis` has it on the template."""
    mapped = apply(to_image, axis)
    same = float(np.dot(crease[1] - crease[0], mapped[1] - mapped[0])) > 0
    reflects = float(np.linalg.det(to_image[:, :2])) < 0
    return crease if same != reflects else crease[::-1].copy()
