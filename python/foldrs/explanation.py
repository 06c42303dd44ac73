"""An explanation of an outline: a template, how it was changed, its fold axis, where it lies in the image."""

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
    original_axis: Points
    """(2, 2) axis found on it by the matching stage, template units."""
    fitted: FittedTemplate
    """The fitted template with its axis; its outline has the vertices of the given one, moved."""
    to_image: Points
    """(2, 3) similarity from template units to image px; reflecting if the garment shows its other face."""
    crease: Points
    """(2, 2) px: the axis in the image. The flap was on its left (from x towards y) before it was turned."""
    cost: float
    """Cost of the method that made it; comparable within that method."""
    original_cost: float
    """Cost found by the matching stage on the template as given."""
    unfolded_cost: float
    """Cost of the same template unfolded."""
    placed: Points | None = None
    """(n, 2) px: the fitted template's corners where a piecewise registration puts them; None if they lie
    where `to_image` puts them."""

    flap_on_top: bool | None = None
    """Whether the flap lies on top of the kept part; None where the picture does not tell."""

    weight: float = 1.0
    """Share of its kind's prior probability that stands behind it, of 1: less where the kind has several
    templates (:mod:`foldrs.alternatives`)."""

    @property
    def accepted(self) -> bool:
        """Whether the fold explains the outline better than the unfolded template."""
        return self.cost < self.unfolded_cost

    @property
    def outline_image(self) -> Points:
        """(n, 2) px: the fitted template unfolded, its kept part where it lies."""
        return apply(self.to_image, self.fitted.outline) if self.placed is None else self.placed

    @property
    def folds(self) -> bool:
        """Whether the crease folds the template where it lies; a poor map may carry it off."""
        try:
            _core.fold_layers(self.outline_image, self.crease)
        except ValueError:
            return False
        return True

    @property
    def fold(self) -> Fold:
        """The fold of this explanation."""
        return Fold(self.crease, self.fitted.axis, self.flap_on_top)


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
