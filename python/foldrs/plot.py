"""The picture of a result: what was seen, how it was explained, and what else it could be."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs import _plot_panels as panels
from foldrs._figure_files import save_figure
from foldrs.errors import ParameterError
from foldrs.image import as_rgb, read_any
from foldrs.result import FitResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from foldrs.image import RgbImage

Points = NDArray[np.float64]

_DPI = 100  # px an inch
_WIDTH, _HEIGHT = 1600, 1000  # px
_MATCH_COLOURS = ("#cc79a7", "#f0e442", "#7b3294", "#8b5a2b")
_OUTSIDE = 1.0  # px an outline may reach out of its photograph, for rounding
# Panels as (left, bottom, width, height), shares of the figure.
_EVIDENCE = (0.012, 0.262, 0.535, 0.618)
_TEMPLATE = (0.557, 0.262, 0.210, 0.618)
_AGREEMENT = (0.777, 0.262, 0.211, 0.618)
_STRIP_LEFT, _STRIP_WIDTH, _STRIP_GAP = 0.012, 0.976, 0.010
_STRIP_BOTTOM, _STRIP_HEIGHT = 0.052, 0.150
_BAR_BOTTOM, _BAR_HEIGHT = 0.018, 0.022
_FEWEST_COLUMNS, _MOST_COLUMNS = 3, 6  # of the strip: wider ones would be empty, narrower ones too small

_LONGEST_KIND, _LONGEST_FILE = 16, 24  # letters shown


@dataclass(frozen=True, eq=False)
class MatchingDetails:
    """What the matching stage considered, for a picture that shows it too (section 2.1)."""

    sides: Sequence[Points] = ()
    """Candidate creases, (2, 2) px each."""
    matches: Sequence[tuple[Points, Points]] = ()
    """Matched pieces: (k, 2) px of the outline seen with (m, 2) template units of the template given."""


def draw_result(
    result: FitResult,
    image: ArrayLike | None,
    figure: Figure | None = None,
    *,
    details: MatchingDetails | None = None,
) -> Figure:
    """Draw a result into a matplotlib figure.

    The panels: the photograph with crease, garment unfolded, landmarks and best grasp pair; the fitted
    template with its axis; the template folded, over the outline seen; and the distinct explanations with
    their probabilities. A result of a camera that looks at an angle is drawn in the view from above.

    Parameters
    ----------
    result : FitResult
        What to draw.
    image : (h, w), (h, w, 3) or (h, w, 4) array_like, optional
        The photograph the result was found in; None draws on a plain background.
    figure : matplotlib.figure.Figure, optional
        Where to draw, empty; without it one of 1600 x 1000 px is made, unknown to pyplot.
    details : MatchingDetails, optional
        Candidate creases and partial matches to show as well.

    Returns
    -------
    matplotlib.figure.Figure
        The figure drawn in.

    Raises
    ------
    NotAnImageError
        `image` is no image array.
    ParameterError
        `image` is too small to hold the outline: it is another one, an outline, or was made smaller.
    """
    from matplotlib.figure import Figure

    photo = None if image is None else as_rgb(image)
    if photo is not None:
        _check_holds(photo, result.outline_image)
    if result.from_above is not None:
        photo = None if image is None else result.from_above.picture
        result = result.from_above.result
    details = details or MatchingDetails()
    if figure is None:
        figure = Figure(figsize=(_WIDTH / _DPI, _HEIGHT / _DPI), dpi=_DPI, facecolor="white")
    _draw_heading(figure, result, details)

    evidence = figure.add_axes(_EVIDENCE)
    panels.draw_evidence(evidence, result, photo, details.sides)
    numbered = "; numbers: pieces matched with the template" if details.matches else ""
    _caption(evidence, f"outline, crease, and the garment unfolded where it lies{numbered}")

    template = figure.add_axes(_TEMPLATE)
    panels.draw_fitted_template(template, result)
    kind = "fitted template" if panels.is_fitted(result) else "template as given"
    _caption(template, f"{kind} and fold axis")

    agreement = figure.add_axes(_AGREEMENT)
    words = panels.draw_agreement(agreement, result, photo)
    _caption(agreement, "folded again, over the outline seen", words)

    for i, match in enumerate(details.matches):
        colour = _MATCH_COLOURS[i % len(_MATCH_COLOURS)]
        panels.draw_match(evidence, template, match, colour, str(i + 1))
    _draw_alternatives(figure, result)
    return figure


def save_picture(
    result: FitResult,
    image: str | os.PathLike[str] | ArrayLike | None,
    path: str | os.PathLike[str],
    *,
    details: MatchingDetails | None = None,
) -> None:
    """Write the picture of a result as a PNG file of 1600 x 1000 px, whole or not at all.

    May be called by several threads at once.

    Parameters
    ----------
    result : FitResult
        What to draw.
    image : path or image array, optional
        The photograph the result was found in; None draws on a plain background.
    path : path
        The file to write.
    details : MatchingDetails, optional
        Candidate creases and partial matches to show as well.

    Raises
    ------
    ImageNotFoundError
        There is no file `image`.
    NotAnImageError
        `image` cannot be read as an image.
    ParameterError
        `image` is too small to hold the outline: it is another one, an outline, or was made smaller.
    """
    photo = read_any(image)
    save_figure(lambda: draw_result(result, photo, details=details), Path(path))


def _check_holds(photo: RgbImage, outline: Points) -> None:
    """Raise ParameterError for a photograph that an outline, (n, 2) px, reaches out of."""
    height, width = photo.shape[:2]
    low, high = outline.min(axis=0), outline.max(axis=0)
    if (low < -_OUTSIDE).any() or (high > np.array([width, height]) - 1 + _OUTSIDE).any():
        raise ParameterError(
            f"the image is {width} x {height} pixels, the result's outline lies from "
            f"({low[0]:.0f}, {low[1]:.0f}) to ({high[0]:.0f}, {high[1]:.0f}): "
            "pass the photograph that it was found in, in its own size"
        )


def _draw_heading(figure: Figure, result: FitResult, details: MatchingDetails) -> None:
    """Write the decision in one line, with the legend below it."""
    title = _clipped(result.garment_type, _LONGEST_KIND)
    if result.alternatives:
        title += f"   {_percent(result.alternatives[0].probability)}"
    figure.text(0.012, 0.972, title, fontsize=22, weight="bold", va="center", parse_math=False)
    ink, paper = ("white", "black") if result.accepted else ("black", "white")
    verdict = _verdict(result)
    badge = {"boxstyle": "round,pad=0.4", "facecolor": paper, "edgecolor": "black"}
    figure.text(0.30, 0.972, verdict, fontsize=13, va="center", color=ink, bbox=badge)
    numbers = f"matching cost {result.matching_cost:.3f}"
    if panels.is_fitted(result):
        numbers += f" (as given {result.original_matching_cost:.3f})"
    if result.image:
        numbers = f"{_clipped(result.image, _LONGEST_FILE)}     {numbers}"
    figure.text(0.988, 0.972, numbers, fontsize=12, va="center", ha="right", color="0.25", parse_math=False)
    figure.legend(
        handles=panels.legend_entries(result, bool(details.sides)),
        loc="upper left",
        bbox_to_anchor=(0.004, 0.952),
        ncol=12,
        frameon=False,
        fontsize=8.7,
        handlelength=1.6,
        columnspacing=1.0,
    )


def _verdict(result: FitResult) -> str:
    if not result.folds:
        return "not folded: no fold explains the outline better"
    if not result.accepted:
        return "fold NOT accepted: none explains the outline better than no fold"
    if len(result.folds) == 1:
        return "fold accepted: it explains the outline better than no fold"
    return f"{len(result.folds)} folds accepted: they explain the outline better than none"


def _percent(probability: float) -> str:
    return "<1%" if 0 < probability < 0.01 else f"{probability:.0%}"


def _clipped(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


def _caption(ax: Axes, *lines: str, weight: str = "normal") -> None:
    ax.set_title("\n".join(lines), fontsize=10, loc="left", pad=4, weight=weight, parse_math=False)


def _draw_alternatives(figure: Figure, result: FitResult) -> None:
    """Draw the distinct explanations side by side, each over a bar of its probability."""
    shown = result.alternatives[:_MOST_COLUMNS]
    columns = max(len(shown), _FEWEST_COLUMNS)
    pitch = _STRIP_WIDTH / columns
    width = pitch - _STRIP_GAP
    for rank, alternative in enumerate(shown):
        left = _STRIP_LEFT + rank * pitch
        on_outline = figure.add_axes((left, _STRIP_BOTTOM, width * 0.56, _STRIP_HEIGHT))
        on_template = figure.add_axes((left + width * 0.58, _STRIP_BOTTOM, width * 0.42, _STRIP_HEIGHT))
        panels.draw_alternative(on_outline, on_template, result.outline_image, alternative)
        kind = _clipped(alternative.garment_type, _LONGEST_KIND)
        name = f"{rank + 1}  {kind}   {_percent(alternative.probability)}"
        _caption(on_outline, name, weight="bold" if rank == 0 else "normal")
        bar = figure.add_axes((left, _BAR_BOTTOM, width, _BAR_HEIGHT))
        bar.barh([0], [1.0], color="0.93")
        bar.barh([0], [alternative.probability], color="0.2" if rank == 0 else "0.55")
        bar.set_xlim(0, 1)
        bar.set_axis_off()
