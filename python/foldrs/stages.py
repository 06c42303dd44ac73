"""Every intermediate outline of the published method, pass by pass: what its Figs. 1, 2 and 5 show.

The names in capitals are the paper's. Coordinates are image px unless template units are named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.explanation import apply
from foldrs.fitting import FitStage, IterativeFit
from foldrs.registration import CREASE, FLAP
from foldrs.result import FittedTemplate
from foldrs.template_update import TemplateUpdate

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class UpdatePass:
    """How the fitting stage makes the next template of a matched one (section 2.2, Fig. 2)."""

    folded: Points
    """(m, 2) px: RVFC, the folded outline registered to the seen one (section 2.2.1)."""
    axis: Points
    """(2, 2) px: RFAxis, the axis moved with its points."""
    unfolded: Points
    """(v, 2) px: VUC, the visible points of the virtually unfolded outline; hidden points are left out."""
    on_flap: NDArray[np.bool_]
    """(v,) whether each of them was turned back with the flap."""
    registered: Points
    """(k, 2) px: RUC, points of the template registered to VUC (section 2.2.2)."""
    lines: tuple[Points, ...]
    """(2, 2) px each: straight lines fitted to the sides by RANSAC, as long as the updated side (section
    2.2.3). Sides without enough visible points have none."""
    corners: Points
    """(n, 2) px: UCfit, corners of the updated template where it lies."""
    outline: Points
    """(n, 2) template units: the updated template, upright; the template of the next pass."""


@dataclass(frozen=True, eq=False)
class FittingPass:
    """One pass: a template matched with the seen outline (section 2.1, Fig. 1), then updated."""

    seen: Points
    """(s, 2) px: FC, equally spaced points of the seen outline; the same in every pass."""
    garment_type: str
    """Kind of the template."""
    template: FittedTemplate
    """UC with its landmarks and FAxis, the axis of the cheapest hypothesis, in template units."""
    folded: Points
    """(m, 2) template units: VFC, equally spaced points of the virtually folded template."""
    partner: NDArray[np.int64]
    """(m,) PC: index into `seen` of the point that corresponds to each folded one; -1 for none."""
    to_image: Points
    """(2, 3) similarity of the folded template onto the seen outline; reflects for the other face."""
    axis: Points
    """(2, 2) template units: FAxis once more."""
    crease: Points
    """(2, 2) px: the axis on the seen outline."""
    cost: float
    """Matching cost; the cheapest pass is chosen, the earliest of equals."""
    update: UpdatePass | None
    """What the fitting stage made of it; None if the template could not be updated."""

    @property
    def folded_image(self) -> Points:
        """(m, 2) px: VFC laid over the seen outline as a whole."""
        return apply(self.to_image, self.folded)


def fitting_passes(fit: IterativeFit, seen: _core.Seen) -> tuple[FittingPass, ...]:
    """Bring one course of the iteration into plain arrays, all px in the frame of the image.

    Parameters
    ----------
    fit : IterativeFit
        The course: the template as given and all that became of it.
    seen : _core.Seen
        The outline it was matched with.

    Returns
    -------
    tuple of FittingPass
        The template as given first.
    """
    return tuple(_fitting_pass(stage, seen.points) for stage in fit.stages)


def chosen_pass(passes: Sequence[FittingPass]) -> int:
    """Index of the pass that is the method's answer: the cheapest, the earliest of equals."""
    return min(range(len(passes)), key=lambda i: passes[i].cost)


def _fitting_pass(stage: FitStage, seen: Points) -> FittingPass:
    explanation, laid = stage.explanation, stage.laid
    (fold,) = explanation.folds
    return FittingPass(
        seen=seen,
        garment_type=explanation.template.garment_type,
        template=explanation.fitted,
        folded=laid.folded,
        partner=laid.partner,
        to_image=laid.to_seen,
        axis=fold.axis_template,
        crease=fold.axis_image,
        cost=explanation.cost,
        update=None if stage.update is None else _update_pass(stage.update, laid),
    )


def _update_pass(update: TemplateUpdate, laid: _core.Explanation) -> UpdatePass:
    # Where the garment shows its other face, the registration's frame has x the other way round.
    way = np.array([-1.0 if np.linalg.det(laid.to_seen[:, :2]) < 0 else 1.0, 1.0])
    visible = laid.layer != CREASE
    ends = np.stack([update.corners, np.roll(update.corners, -1, axis=0)], axis=1)
    lines = tuple(_along_line(ends[i], line) * way for i, line in sorted(update.lines.items()))
    return UpdatePass(
        folded=update.fold.folded * way,
        axis=update.fold.axis * way,
        unfolded=update.fold.unfolded * way,
        on_flap=laid.layer[visible] == FLAP,
        registered=update.registered * way,
        lines=lines,
        corners=update.corners * way,
        outline=update.outline,
    )


def _along_line(side: Points, line: Points) -> Points:
    """Return the piece of a line (point and unit direction) that lies beside a side."""
    middle, direction = line
    return np.asarray(middle + ((side - middle) @ direction)[:, None] * direction)
