"""The picture of the published method at work: the outlines of its Figs. 1, 2 and 5 for any garment."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from foldrs import _plot_panels as panels
from foldrs import _stages_panels as stages
from foldrs._figure_files import save_figure
from foldrs.errors import ParameterError
from foldrs.image import as_rgb, read_image
from foldrs.result import FitResult
from foldrs.stages import chosen_pass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_DPI = 100  # px an inch
_WIDTH, _HEIGHT = 1600, 1260  # px
_LEFT, _RIGHT, _GAP = 0.012, 0.988, 0.010  # shares of the width
# Top of every row's heading, bottom and height of its panels: shares of the height.
_MATCHING_ROW = (0.924, 0.638, 0.254)
_FITTING_ROW = (0.612, 0.326, 0.254)
_PASSES_ROW = (0.300, 0.014, 0.254)
_FEWEST_COLUMNS = 6  # of the passes: the template as given and five passes, as in the paper


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
    if result.from_above is not None:
        photo = None if image is None else result.from_above.picture
        result = result.from_above.result
    if figure is None:
        figure = Figure(figsize=(_WIDTH / _DPI, _HEIGHT / _DPI), dpi=_DPI, facecolor="white")
    one = result.stages[shown]
    which = "the template as given" if shown == 0 else f"the template of pass {shown}"
    _draw_heading(figure, result)
    _draw_row(
        figure, _MATCHING_ROW, f"Fig. 1  Matching {which} (2.1)", stages.matching_panels(result, one, photo)
    )
    _draw_row(figure, _FITTING_ROW, f"Fig. 2  Fitting {which} (2.2)", stages.fitting_panels(one))
    title = (
        "Fig. 5  The template of every pass, its fold axis and matching cost (grey: the template as given)"
    )
    _draw_row(figure, _PASSES_ROW, title, stages.pass_panels(result.stages), _FEWEST_COLUMNS)
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
    save_figure(lambda: draw_stages(result, photo, shown=shown), Path(path))


# -- layout --


def _draw_heading(figure: Figure, result: FitResult) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    place: dict[str, Any] = {"va": "center", "parse_math": False}
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
        Line2D([], [], color=stages.PARTNERS, linewidth=1.5, label="correspondence"),
        Line2D([], [], color=panels.GRASP, linewidth=2, label="straight line"),
        Patch(facecolor="none", edgecolor="black", linewidth=2.5, label="pass chosen: the cheapest"),
    ]
    look: dict[str, Any] = {"frameon": False, "fontsize": 9, "handlelength": 1.6, "columnspacing": 1.4}
    figure.legend(handles=entries, loc="upper left", bbox_to_anchor=(0.004, 0.965), ncol=12, **look)


def _draw_row(
    figure: Figure,
    row: tuple[float, float, float],
    title: str,
    drawn: Sequence[stages.Panel],
    columns: int = 0,
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
