"""The panels of the picture of a result; :mod:`foldrs.plot` lays them out.

One colour means one thing in all panels; the colours (after Okabe and Ito) suit any colour vision.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs import _plot_pens as pens
from foldrs.landmark import carried

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from foldrs.image import RgbImage
    from foldrs.result import Alternative, FitResult, FittedTemplate

Points = NDArray[np.float64]

SEEN = "#0072b2"
CREASE = "#d00000"
UNFOLDED = "#e69f00"
KEPT = "#56b4e9"
FLAP = "#e69f00"
GRASP = "#00b383"
MODEL = "black"
FAINT = "0.6"

_MOVED = 0.02  # share of the garment's size from which on a point counts as moved by unfolding
_COMPARED = 200  # points of the folded model whose distance from the outline is measured


def draw_evidence(ax: Axes, result: FitResult, image: RgbImage | None, sides: Sequence[Points]) -> None:
    """Draw what was seen and what follows from it: crease, garment unfolded, landmarks, grasp points."""
    marks = [mark.image for mark in result.landmarks.values()]
    creases = [fold.axis_image for fold in result.folds]
    pens.frame(ax, np.vstack([result.outline_image, result.unfolded_outline_image, *creases, *marks]))
    pens.photograph(ax, image)
    pens.line(
        ax, pens.closed(result.unfolded_outline_image), UNFOLDED, 2.2, halo="black", linestyle=(0, (4, 2.5))
    )
    pens.line(ax, pens.closed(result.outline_image), SEEN, 2.0, halo="white")
    for side in sides:
        pens.dimension(ax, side)
    draw_creases(ax, creases, 4.0)

    best = result.grasp_pairs[0].landmarks if result.grasp_pairs else ()
    lines = [pens.along(crease) for crease in creases]
    if best:
        lines += _draw_grasp(ax, result, best)
    for mark in result.landmarks.values():
        pens.dot(ax, mark.image, filled=mark.accessible)
    pens.names(
        ax, {n: m.image for n, m in result.landmarks.items()}, np.vstack([np.empty((0, 2)), *lines]), best
    )


def draw_fitted_template(ax: Axes, result: FitResult) -> None:
    """Draw the fitted template with its axis, over the one given with the axis of the matching stage."""
    given, fitted = result.original_template, result.template
    axes = [fold.axis_template for fold in result.folds]
    as_given = [] if given.axis is None else [given.axis]
    pens.frame(ax, np.vstack([given.outline, fitted.outline, *as_given, *axes]), margin=0.2)
    if is_fitted(result):
        pens.line(ax, pens.closed(given.outline), FAINT, 1.2, zorder=1)
        for axis in as_given:
            pens.line(ax, axis, FAINT, 2.0, linestyle=(0, (3, 1.5)), zorder=2)
    _draw_layers_unfolded(ax, fitted)
    pens.line(ax, pens.closed(fitted.outline), MODEL, 1.5)
    draw_creases(ax, axes, 3.0)
    for point in fitted.landmarks.values():
        pens.dot(ax, point, filled=True, size=4)
    pens.names(ax, fitted.landmarks, np.vstack([np.empty((0, 2)), *map(pens.along, axes)]))


def draw_agreement(ax: Axes, result: FitResult, image: RgbImage | None) -> str:
    """Draw the model, folded, over the outline seen; return how well they agree, in words."""
    folded = folded_layers(result)
    model = folded.outline if folded else result.unfolded_outline_image
    pens.frame(ax, np.vstack([result.outline_image, model]))
    pens.photograph(ax, image, pale=True)
    if folded:
        kept, flap = kept_and_flap(folded)
        opacity = 0.45 / max(1, len(result.folds))
        pens.fill(ax, kept, KEPT, opacity)
        pens.fill(ax, flap, FLAP, opacity)
    pens.line(ax, pens.closed(result.outline_image), SEEN, 2.4, halo="white")
    pens.line(ax, pens.closed(model), MODEL, 1.4, halo="white")
    for k in reversed(range(len(result.folds) if folded else 0)):
        for piece in folded.creases(k) if folded else ():
            draw_creases(ax, [piece], 2.5, earlier=k + 1 < len(result.folds))
    _, off, _ = _core.nearest_on_outline(result.outline_image, _core.resample(model, _COMPARED))
    overlap = _core.outline_iou(model, result.outline_image)
    return f"overlap {overlap:.0%}, mean distance {off.mean():.1f} px"


def draw_alternative(on_outline: Axes, on_template: Axes, seen: Points, alternative: Alternative) -> None:
    """Draw the crease of an explanation on the outline seen, and its fold on its template."""
    creases = [fold.axis_image for fold in alternative.folds]
    axes = [fold.axis_template for fold in alternative.folds]
    pens.frame(on_outline, np.vstack([seen, *creases]))
    on_outline.fill(*seen.T, color=SEEN, alpha=0.15, linewidth=0)
    pens.line(on_outline, pens.closed(seen), SEEN, 1.2)
    draw_creases(on_outline, creases, 3.0)
    template = alternative.template
    pens.frame(on_template, np.vstack([template.outline, *axes]))
    _draw_layers_unfolded(on_template, template)
    pens.line(on_template, pens.closed(template.outline), MODEL, 1.0)
    draw_creases(on_template, axes, 2.2)


def draw_match(
    on_photo: Axes, on_template: Axes, match: tuple[Points, Points], colour: Any, name: str
) -> None:
    """Draw a piece of the seen outline and the piece of the template it was matched with in one colour."""
    for ax, piece in ((on_photo, match[0]), (on_template, match[1])):
        ax.plot(*piece.T, color=colour, linewidth=6, alpha=0.45, solid_capstyle="butt", zorder=3)
        middle = piece[len(piece) // 2]
        ax.text(
            middle[0],
            middle[1],
            name,
            fontsize=pens.NAME_SIZE,
            ha="center",
            va="center",
            zorder=8,
            bbox=pens.NAME_LOOK,
        )


def legend_entries(result: FitResult, with_sides: bool) -> list[Any]:
    """Return the legend's handles for all that is drawn."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def marker(filled: bool) -> dict[str, Any]:
        face = "black" if filled else "white"
        return {"linestyle": "none", "marker": "o", "color": "black", "markerfacecolor": face}

    entries = [
        Line2D([], [], color=SEEN, linewidth=2.4, label="outline seen"),
        Line2D([], [], color=CREASE, linewidth=4, label="crease, fold axis"),
        Line2D([], [], color=UNFOLDED, linewidth=2.4, linestyle="--", label="unfolded"),
        Patch(color=KEPT, alpha=0.5, label="kept part"),
        Patch(color=FLAP, alpha=0.5, label="flap"),
        Line2D([], [], color=MODEL, linewidth=1.5, label="model"),
        Line2D([], [], label="landmark in reach", **marker(True)),
        Line2D([], [], label="landmark out of reach", **marker(False)),
    ]
    if is_fitted(result):
        entries.append(Line2D([], [], color=FAINT, linewidth=1.5, label="template as given"))
    if result.grasp_pairs:
        ring = {**marker(False), "color": GRASP, "markersize": 11, "markeredgewidth": 3}
        ring["markerfacecolor"] = "none"
        entries.append(Line2D([], [], label="best grasp pair, unfolding", **ring))
    if with_sides:
        entries.append(Line2D([], [], color="black", linewidth=1, marker="|", label="candidate crease"))
    return entries


def is_fitted(result: FitResult) -> bool:
    """Whether the fitted template differs from the one given."""
    given, fitted = result.original_template, result.template
    if given.outline.shape != fitted.outline.shape:
        return True
    if given.axis is None or fitted.axis is None:
        return not np.allclose(given.outline, fitted.outline)
    return not (np.allclose(given.outline, fitted.outline) and np.allclose(given.axis, fitted.axis))


def folded_layers(result: FitResult | Alternative) -> _core.FoldedStack | None:
    """Fold the garment of an explanation over all its creases; None if a crease folds nothing."""
    creases = [fold.axis_image for fold in result.folds]
    try:
        return _core.fold_stack(result.unfolded_outline_image, creases)
    except ValueError:
        return None


def kept_and_flap(layers: _core.FoldedStack) -> tuple[list[Points], list[Points]]:
    """Part the layers into those the last fold kept and those it turned over."""
    parts: tuple[list[Points], list[Points]] = ([], [])
    for layer, turned in zip(layers.layers, layers.turned, strict=True):
        parts[any(turned[-1:])].append(layer)
    return parts


def draw_creases(ax: Axes, creases: Sequence[Points], width: float, *, earlier: bool = False) -> None:
    """Draw creases or axes, first made first: the last one bold, or none if they are `earlier` ones."""
    for k, crease in enumerate(creases):
        if earlier or k + 1 < len(creases):
            pens.line(ax, crease, CREASE, 0.5 * width, halo="white", linestyle=(0, (3, 2)), zorder=5)
        else:
            pens.line(ax, crease, CREASE, width, halo="white", zorder=5)


def fold_once(outline: Points, axis: Points) -> _core.FoldedLayers | None:
    """Fold an outline over an axis; None if that folds nothing."""
    # An axis may miss its outline by a hair after rounding or fitting: then there is nothing to shade.
    try:
        return _core.fold_layers(outline, axis)
    except ValueError:
        return None


def _draw_layers_unfolded(ax: Axes, template: FittedTemplate) -> None:
    """Shade the kept part and the flap of a template, the flap turned back."""
    ax.fill(*template.outline.T, color="white", linewidth=0, zorder=0.5)
    if template.axis is None:
        pens.fill(ax, [template.outline], KEPT, 0.35)
    elif layers := fold_once(template.outline, template.axis):
        pens.fill(ax, layers.kept, KEPT, 0.35)
        pens.fill(ax, [_core.reflect(piece, template.axis) for piece in layers.flap], FLAP, 0.5)


def _draw_grasp(ax: Axes, result: FitResult, names: tuple[str, str]) -> list[Points]:
    """Ring a grasp pair, join its points, and point to where unfolding takes them; return the lines."""
    points = np.array([result.landmarks[name].image for name in names])
    lines = [pens.along(points)]
    pens.line(ax, points, GRASP, 1.6, halo="white", zorder=5)
    unfolded = _landmarks_unfolded(result)
    size = float(np.ptp(result.outline_image, axis=0).max())
    for name, now in zip(names, points, strict=True):
        if name in unfolded and np.hypot(*(unfolded[name] - now)) > _MOVED * size:
            pens.arrow(ax, now, unfolded[name], GRASP)
            lines.append(pens.along(np.array([now, unfolded[name]])))
    pens.rings(ax, points, GRASP)
    return lines


def _landmarks_unfolded(result: FitResult) -> dict[str, Points]:
    """Where the landmarks lie in the image when the garment is unfolded again."""
    outline, unfolded = result.template.outline, result.unfolded_outline_image
    if outline.shape != unfolded.shape:
        return {}
    # The unfolded outline is the template's, laid into the image piece by piece: their corners correspond.
    return carried(result.template.landmarks, outline, unfolded)
