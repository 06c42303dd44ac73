"""The picture of the published method at work: the outlines of its Figs. 1, 2 and 5 for any garment."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs import _core
from foldrs import _plot_panels as panels
from foldrs import _plot_pens as pens
from foldrs.errors import ParameterError
from foldrs.explanation import apply
from foldrs.image import RgbImage, as_rgb, read_image
from foldrs.plot import _drawing as one_at_a_time
from foldrs.result import FitResult, FittedTemplate, write_whole
from foldrs.stages import FittingPass, UpdatePass, chosen_pass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Points = NDArray[np.float64]
_Panel: TypeAlias = "tuple[str, Callable[[Axes], None]]"

_DPI = 100  # px an inch
_WIDTH, _HEIGHT = 1600, 1260  # px
_LEFT, _RIGHT, _GAP = 0.012, 0.988, 0.010  # shares of the width
# Top of every row's heading, bottom and height of its panels: shares of the height.
_MATCHING_ROW = (0.924, 0.638, 0.254)
_FITTING_ROW = (0.612, 0.326, 0.254)
_PASSES_ROW = (0.300, 0.014, 0.254)
_FEWEST_COLUMNS = 6  # of the passes: the template as given and five passes, as in the paper
_PARTNERS = "#cc79a7"  # correspondences
_BESIDE = 1.15  # distance from the folded template to the seen outline beside it, in widths of the wider one
_EVERY = 2  # correspondences drawn: one in so many
_BEYOND = 0.12  # share of its length that a straight line is drawn beyond its side


def draw_stages(
    result: FitResult, image: ArrayLike | None, figure: Figure | None = None, *, shown: int = 0
) -> Figure:
    """Draw every stage of the published method into a matplotlib figure.

    The rows are the paper's Fig. 1, from the seen outline to its correspondences with a virtually folded
    template; Fig. 2, from those to the updated template; and Fig. 5, the template of every pass.

    Parameters
    ----------
    result : FitResult
        A result of the published method (``fit(..., method="paper")``).
    image : (h, w), (h, w, 3) or (h, w, 4) array_like, optional
        The photograph the result was found in; None draws on a plain background.
    figure : matplotlib.figure.Figure, optional
        Where to draw, empty; without it one of 1600 x 1260 px is made, unknown to pyplot.
    shown : int
        Index of the pass that the first two rows show, by default the one of the template as given.

    Returns
    -------
    matplotlib.figure.Figure
        The figure drawn in.

    Raises
    ------
    ParameterError
        The result has no stages, as those of other methods, or no pass `shown`.
    NotAnImageError
        `image` is no image array.
    """
    from matplotlib.figure import Figure

    if not result.stages:
        raise ParameterError('the result has no stages to draw: only fit(..., method="paper") keeps them')
    if not 0 <= shown < len(result.stages):
        raise ParameterError(f"there is no pass {shown}: the passes are 0 to {len(result.stages) - 1}")
    photo = None if image is None else as_rgb(image)
    if figure is None:
        figure = Figure(figsize=(_WIDTH / _DPI, _HEIGHT / _DPI), dpi=_DPI, facecolor="white")
    one = result.stages[shown]
    which = "the template as given" if shown == 0 else f"the template of pass {shown}"
    _draw_heading(figure, result)
    _draw_row(figure, _MATCHING_ROW, f"Fig. 1  Matching {which} (2.1)", _matching_panels(result, one, photo))
    _draw_row(figure, _FITTING_ROW, f"Fig. 2  Fitting {which} (2.2)", _fitting_panels(one))
    title = "Fig. 5  The template of every pass with its fold axis and matching cost (grey: the template as given)"
    _draw_row(figure, _PASSES_ROW, title, _pass_panels(result.stages), _FEWEST_COLUMNS)
    _mark(figure.axes[-len(result.stages) :][chosen_pass(result.stages)])
    return figure


def save_stages(
    result: FitResult,
    image: str | os.PathLike[str] | ArrayLike | None,
    path: str | os.PathLike[str],
    *,
    shown: int = 0,
) -> None:
    """Write the picture of the stages as a PNG file of 1600 x 1260 px, whole or not at all.

    May be called by several threads at once.

    Parameters
    ----------
    result : FitResult
        A result of the published method (``fit(..., method="paper")``).
    image : path or image array, optional
        The photograph the result was found in; None draws on a plain background.
    path : path
        The file to write.
    shown : int
        Index of the pass that the first two rows show.

    Raises
    ------
    ParameterError
        The result has no stages, or no pass `shown`.
    ImageNotFoundError
        There is no file `image`.
    NotAnImageError
        `image` cannot be read as an image.
    """
    photo = read_image(Path(image)) if isinstance(image, (str, os.PathLike)) else image
    pixels = io.BytesIO()
    with one_at_a_time:
        figure = draw_stages(result, photo, shown=shown)
        figure.savefig(pixels, format="raw", dpi=_DPI)
    rgba = np.frombuffer(pixels.getvalue(), np.uint8).reshape(_HEIGHT, _WIDTH, 4)
    _, png = cv2.imencode(".png", rgba[:, :, 2::-1])
    write_whole(Path(path), png.tobytes())


# -- layout --


def _draw_heading(figure: Figure, result: FitResult) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    place = {"va": "center", "parse_math": False}
    title = f"{result.garment_type}: the published method, stage by stage"
    figure.text(_LEFT, 0.978, title, fontsize=18, weight="bold", **place)
    chosen = chosen_pass(result.stages)
    costs = f"matching cost {result.matching_cost:.3f} in pass {chosen}, as given {result.stages[0].cost:.3f}"
    words = f"{result.image}     {costs}" if result.image else costs
    figure.text(_RIGHT, 0.978, words, fontsize=11, ha="right", color="0.25", **place)
    entries = [
        Line2D([], [], color=panels.SEEN, linewidth=2.4, label="outline seen"),
        Line2D([], [], color="black", linewidth=1, marker="|", label="candidate crease"),
        Line2D([], [], color=panels.CREASE, linewidth=4, label="crease, fold axis"),
        Patch(color=panels.KEPT, alpha=0.5, label="kept part"),
        Patch(color=panels.FLAP, alpha=0.5, label="flap"),
        Line2D([], [], color=panels.MODEL, linewidth=1.5, label="template"),
        Line2D([], [], color=_PARTNERS, linewidth=1.5, label="correspondence"),
        Line2D([], [], color=panels.GRASP, linewidth=2, label="straight line"),
        Patch(facecolor="none", edgecolor="black", linewidth=2.5, label="pass chosen: the cheapest"),
    ]
    look = {"frameon": False, "fontsize": 9, "handlelength": 1.6, "columnspacing": 1.4}
    figure.legend(handles=entries, loc="upper left", bbox_to_anchor=(0.004, 0.965), ncol=12, **look)


def _draw_row(
    figure: Figure, row: tuple[float, float, float], title: str, drawn: Sequence[_Panel], columns: int = 0
) -> None:
    """Draw panels side by side below a heading, the axes in their order."""
    top, bottom, height = row
    columns = max(columns, len(drawn))
    pitch = (_RIGHT - _LEFT + _GAP) / columns
    figure.text(_LEFT, top, title, fontsize=12, weight="bold", va="center", parse_math=False)
    for i, (caption, draw) in enumerate(drawn):
        ax = figure.add_axes((_LEFT + i * pitch, bottom, pitch - _GAP, height))
        draw(ax)
        ax.set_title(caption, fontsize=9.5, loc="left", pad=4, parse_math=False)


def _mark(ax: Axes) -> None:
    """Frame the panel of the pass chosen."""
    for spine in ax.spines.values():
        spine.set_visible(True)
        spine.set_linewidth(2.5)
    ax.set_title(ax.get_title(loc="left"), fontsize=9.5, loc="left", pad=4, weight="bold", parse_math=False)


# -- Fig. 1 --


def _matching_panels(result: FitResult, one: FittingPass, photo: RgbImage | None) -> list[_Panel]:
    return [
        ("FC: candidate creases, shaded that of the crease (2.1.1)", lambda ax: _draw_seen(ax, result, one, photo)),
        ("UC: template, hypothesised fold axis FAxis (2.1.2)", lambda ax: _draw_template(ax, one.template)),
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


def _draw_template(ax: Axes, template: FittedTemplate, given: FittedTemplate | None = None) -> None:
    """Draw a template with its axis, kept part and flap shaded, over the one given if it differs."""
    outlines = [template.outline] if given is None else [template.outline, given.outline]
    pens.frame(ax, np.vstack([*outlines, template.axis]))
    ax.fill(*template.outline.T, color="white", linewidth=0, zorder=0.5)
    layers = _core.fold_layers(template.outline, template.axis)
    pens.fill(ax, layers.kept, panels.KEPT, 0.35)
    pens.fill(ax, [_core.reflect(piece, template.axis) for piece in layers.flap], panels.FLAP, 0.5)
    if given is not None:
        pens.line(ax, pens.closed(given.outline), panels.FAINT, 1.2, zorder=2)
    pens.line(ax, pens.closed(template.outline), panels.MODEL, 1.5)
    pens.line(ax, template.axis, panels.CREASE, 3.0, halo="white", zorder=4)


def _draw_folded(ax: Axes, one: FittingPass) -> None:
    layers = _core.fold_layers(one.template.outline, one.template.axis)
    pens.frame(ax, np.vstack([one.template.outline, one.folded, one.template.axis]))
    ax.fill(*one.folded.T, color="white", linewidth=0, zorder=0.5)
    pens.fill(ax, layers.kept, panels.KEPT, 0.35)
    pens.fill(ax, layers.flap, panels.FLAP, 0.5)
    pens.line(ax, pens.closed(one.template.outline), panels.FAINT, 1.0, linestyle=(0, (3, 2)), zorder=2)
    pens.line(ax, pens.closed(one.folded), panels.MODEL, 1.5)
    pens.line(ax, one.template.axis, panels.CREASE, 3.0, halo="white", zorder=4)


def _draw_partners(ax: Axes, one: FittingPass) -> None:
    """Draw the folded template beside the seen outline, turned and scaled as it, joined point by point."""
    folded = one.folded_image
    width = max(np.ptp(folded[:, 0]), np.ptp(one.seen[:, 0]))
    beside = one.seen + [_BESIDE * width, 0.0]
    pens.frame(ax, np.vstack([folded, beside]))
    paired = np.flatnonzero(one.partner >= 0)
    for i in paired[::_EVERY]:
        pens.line(ax, np.stack([folded[i], beside[one.partner[i]]]), _PARTNERS, 0.8, zorder=2)
    pens.line(ax, pens.closed(folded), panels.MODEL, 1.5)
    pens.line(ax, pens.closed(beside), panels.SEEN, 2.0)
    pens.line(ax, apply(one.to_image, one.template.axis), panels.CREASE, 2.5, halo="white", zorder=4)
    _dots(ax, folded[paired], panels.MODEL)
    _dots(ax, beside[one.partner[paired]], panels.SEEN)


# -- Fig. 2 --


def _fitting_panels(one: FittingPass) -> list[_Panel]:
    update = one.update
    if update is None:
        return [("the template could not be updated: too little corresponds", lambda ax: _draw_partners(ax, one))]
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


def _pass_panels(passes: Sequence[FittingPass]) -> list[_Panel]:
    given = passes[0].template

    def panel(number: int, one: FittingPass) -> _Panel:
        name = "as given" if number == 0 else f"pass {number}"
        return f"{name}: cost {one.cost:.3f}", lambda ax: _draw_template(ax, one.template, given)

    return [panel(number, one) for number, one in enumerate(passes)]
