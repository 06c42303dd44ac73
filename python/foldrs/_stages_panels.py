"""The panels of the picture of the published method; :mod:`foldrs.stages_plot` lays them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs import _plot_panels as panels
from foldrs import _plot_pens as pens
from foldrs.explanation import apply

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from foldrs.image import RgbImage
    from foldrs.result import FitResult, FittedTemplate
    from foldrs.stages import FittingPass, UpdatePass

Points = NDArray[np.float64]
Panel: TypeAlias = "tuple[str, Callable[[Axes], None]]"
"""A caption, and what draws the panel into its axes."""

PARTNERS = "#cc79a7"  # correspondences
_BESIDE = 1.15  # distance from the folded template to the seen outline beside it, in widths of the wider one
_EVERY = 2  # correspondences drawn: one in so many
_BEYOND = 0.12  # share of its length that a straight line is drawn beyond its side


# -- Fig. 1 --


def matching_panels(result: FitResult, one: FittingPass, photo: RgbImage | None) -> list[Panel]:
    """Return the panels of Fig. 1: how a template was matched."""
    return [
        (
            "FC: candidate creases, shaded that of the crease (2.1.1)",
            lambda ax: _draw_seen(ax, result, one, photo),
        ),
        ("UC: template, hypothesised fold axis FAxis (2.1.2)", lambda ax: _draw_template(ax, one)),
        ("VFC: template virtually folded (2.1.2)", lambda ax: _draw_folded(ax, one)),
        ("PC: its correspondences to the outline (2.1.2)", lambda ax: _draw_partners(ax, one)),
    ]


def _draw_seen(ax: Axes, result: FitResult, one: FittingPass, photo: RgbImage | None) -> None:
    pens.frame(ax, np.vstack([result.outline_image, one.crease]))
    pens.photograph(ax, photo)
    pens.line(ax, pens.closed(result.outline_image), panels.SEEN, 3.5, halo="white", zorder=1.5)
    for side in result.candidate_creases:
        pens.dimension(ax, side)
    # The one that the crease found lies along, which need not be the one that the hypothesis was made from.
    along = min(
        result.candidate_creases, key=lambda side: _core.axis_difference(side, one.crease), default=one.crease
    )
    ax.plot(*along.T, color=panels.CREASE, linewidth=12, alpha=0.35, solid_capstyle="butt", zorder=2.5)
    pens.line(ax, one.crease, panels.CREASE, 3.5, halo="white", zorder=5)


def _draw_template(ax: Axes, one: FittingPass, given: FittedTemplate | None = None) -> None:
    """Draw a template with its axis, kept part and flap shaded, over the one given if it differs."""
    template = one.template
    outlines = [template.outline] if given is None else [template.outline, given.outline]
    pens.frame(ax, np.vstack([*outlines, one.axis]))
    ax.fill(*template.outline.T, color="white", linewidth=0, zorder=0.5)
    layers = _core.fold_layers(template.outline, one.axis)
    pens.fill(ax, layers.kept, panels.KEPT, 0.35)
    pens.fill(ax, [_core.reflect(piece, one.axis) for piece in layers.flap], panels.FLAP, 0.5)
    if given is not None:
        pens.line(ax, pens.closed(given.outline), panels.FAINT, 1.2, zorder=2)
    pens.line(ax, pens.closed(template.outline), panels.MODEL, 1.5)
    pens.line(ax, one.axis, panels.CREASE, 3.0, halo="white", zorder=4)


def _draw_folded(ax: Axes, one: FittingPass) -> None:
    layers = _core.fold_layers(one.template.outline, one.axis)
    pens.frame(ax, np.vstack([one.template.outline, one.folded, one.axis]))
    ax.fill(*one.folded.T, color="white", linewidth=0, zorder=0.5)
    pens.fill(ax, layers.kept, panels.KEPT, 0.35)
    pens.fill(ax, layers.flap, panels.FLAP, 0.5)
    pens.line(ax, pens.closed(one.template.outline), panels.FAINT, 1.0, linestyle=(0, (3, 2)), zorder=2)
    pens.line(ax, pens.closed(one.folded), panels.MODEL, 1.5)
    pens.line(ax, one.axis, panels.CREASE, 3.0, halo="white", zorder=4)


def _draw_partners(ax: Axes, one: FittingPass) -> None:
    """Draw the folded template beside the seen outline, turned and scaled as it, joined point by point."""
    folded = one.folded_image
    width = max(np.ptp(folded[:, 0]), np.ptp(one.seen[:, 0]))
    beside = one.seen + np.array([_BESIDE * width, 0.0])
    pens.frame(ax, np.vstack([folded, beside]))
    paired = np.flatnonzero(one.partner >= 0)
    for i in paired[::_EVERY]:
        pens.line(ax, np.stack([folded[i], beside[one.partner[i]]]), PARTNERS, 0.8, zorder=2)
    pens.line(ax, pens.closed(folded), panels.MODEL, 1.5)
    pens.line(ax, pens.closed(beside), panels.SEEN, 2.0)
    pens.line(ax, apply(one.to_image, one.axis), panels.CREASE, 2.5, halo="white", zorder=4)
    _dots(ax, folded[paired], panels.MODEL)
    _dots(ax, beside[one.partner[paired]], panels.SEEN)


# -- Fig. 2 --


def fitting_panels(one: FittingPass) -> list[Panel]:
    """Return the panels of Fig. 2: how a template was updated; one that says so if it could not be."""
    update = one.update
    if update is None:
        return [
            ("the template could not be updated: too little corresponds", lambda ax: _draw_partners(ax, one))
        ]
    return [
        ("RVFC, RFAxis: registered to the outline (2.2.1)", lambda ax: _draw_registered(ax, one, update)),
        ("VUC: virtually unfolded, hidden parts missing (2.2.1)", lambda ax: _draw_unfolded(ax, one, update)),
        ("RUC: template registered to VUC (2.2.2)", lambda ax: _draw_whole(ax, one, update)),
        ("straight lines; UCfit: updated template (2.2.3)", lambda ax: _draw_lines(ax, one, update)),
    ]


def _frame_update(ax: Axes, one: FittingPass, update: UpdatePass) -> None:
    """Frame all panels of the row alike, the seen outline in each."""
    pens.frame(ax, np.vstack([one.seen, update.axis, update.unfolded, update.registered, update.corners]))
    pens.line(ax, pens.closed(one.seen), panels.SEEN, 1.6, alpha=0.6, zorder=1.5)


def _draw_registered(ax: Axes, one: FittingPass, update: UpdatePass) -> None:
    _frame_update(ax, one, update)
    pens.line(ax, pens.closed(one.folded_image), panels.FAINT, 1.0, linestyle=(0, (3, 2)), zorder=2)
    pens.line(ax, pens.closed(update.folded), panels.MODEL, 1.5)
    _dots(ax, update.folded, panels.MODEL)
    pens.line(ax, update.axis, panels.CREASE, 3.0, halo="white", zorder=4)


def _draw_unfolded(ax: Axes, one: FittingPass, update: UpdatePass) -> None:
    _frame_update(ax, one, update)
    _draw_visible(ax, update, 3.6)
    pens.line(ax, update.axis, panels.CREASE, 3.0, halo="white", zorder=4)


def _draw_whole(ax: Axes, one: FittingPass, update: UpdatePass) -> None:
    _frame_update(ax, one, update)
    _draw_visible(ax, update, 5.5)
    _dots(ax, update.registered, panels.MODEL, 2.6)


def _draw_lines(ax: Axes, one: FittingPass, update: UpdatePass) -> None:
    _frame_update(ax, one, update)
    for line in update.lines:
        reach = _BEYOND * (line[1] - line[0])
        pens.line(ax, np.stack([line[0] - reach, line[1] + reach]), panels.GRASP, 2.0, zorder=2.5)
    pens.line(ax, pens.closed(update.corners), panels.MODEL, 1.5)
    _dots(ax, update.registered, panels.FAINT, 2.2)
    for corner in update.corners:
        pens.dot(ax, corner, filled=True, size=5)


def _draw_visible(ax: Axes, update: UpdatePass, size: float) -> None:
    """Mark the points of the virtually unfolded outline, by layer."""
    _dots(ax, update.unfolded[~update.on_flap], panels.KEPT, size)
    _dots(ax, update.unfolded[update.on_flap], panels.FLAP, size)


def _dots(ax: Axes, points: Points, colour: str, size: float = 2.4) -> None:
    ax.plot(*points.T, "o", color=colour, markersize=size, markeredgewidth=0, zorder=3.5)


# -- Fig. 5 --


def pass_panels(passes: Sequence[FittingPass]) -> list[Panel]:
    """Return the panels of Fig. 5: the template of every pass."""
    given = passes[0].template

    def panel(number: int, one: FittingPass) -> Panel:
        name = "as given" if number == 0 else f"pass {number}"
        return f"{name}: cost {one.cost:.3f}", lambda ax: _draw_template(ax, one, given)

    return [panel(number, one) for number, one in enumerate(passes)]
