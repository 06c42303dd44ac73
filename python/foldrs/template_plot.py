"""Picture of a template: outline, landmarks, mirror axis and grasp pairs in their order of preference."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from foldrs.errors import TemplateError
from foldrs.template import Template

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    FloatArray = npt.NDArray[np.float64]

# All lengths of the layout are shares of the larger side of the template's bounding box.
_LABEL_GAP = 0.10  # from the outline to the columns of landmark names
_LABEL_PITCH = 0.06  # least distance of two names, one above the other
_NUMBER_PITCH = 0.07  # least distance of the number of a grasp pair from other numbers and landmarks
_BAR_GAP = 0.10  # from the lowest point or name to the scale bar
_BAR_SHARE = 0.3  # longest scale bar


def draw_template(template: Template, ax: Axes | None = None) -> Axes:
    """Draw a template with y down, as it lies in front of the viewer.

    Parameters
    ----------
    template : Template
        What to draw.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a figure of its own is made if not given (``ax.figure``).

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn in, in template units.
    """
    if ax is None:
        ax = new_figure(9, 7).add_subplot()
    low, high = template.outline.min(axis=0), template.outline.max(axis=0)
    size = float((high - low).max())
    closed = np.vstack([template.outline, template.outline[:1]])
    ax.fill(*template.outline.T, color="0.93", zorder=0)
    ax.plot(*closed.T, color="0.25", linewidth=1.5, marker=".", markersize=5, zorder=2)
    _draw_symmetry_axis(ax, template, size)
    _draw_grasp_pairs(ax, template, size)
    lowest_name = _draw_landmarks(ax, template, size)
    _draw_scale_bar(ax, template, size, float(max(high[1], lowest_name)))
    same = template.name == template.garment_type
    ax.set_title(template.name if same else f"{template.name} ({template.garment_type})")
    ax.set_aspect("equal")
    ax.set_axis_off()
    if not ax.yaxis_inverted():
        ax.invert_yaxis()
    return ax


def save_template_picture(template: Template, path: str | os.PathLike[str]) -> None:
    """Draw a template into a picture file; the suffix names the format (``.png``, ``.svg``, ``.pdf``, ...).

    Raises
    ------
    TemplateError
        If the picture cannot be written: no such folder, or a suffix that names no picture format.
    """
    figure = new_figure(9, 7)
    draw_template(template, figure.add_subplot())
    write_figure(figure, path)


def write_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure, cut to what is drawn; raises TemplateError if that cannot be done."""
    try:
        figure.savefig(path, dpi=110, bbox_inches="tight")
    except OSError as error:
        raise TemplateError(f"{path}: the picture cannot be written ({error.strerror})") from error
    except ValueError as error:
        raise TemplateError(f"{path}: the picture cannot be written ({error})") from error


def new_figure(width: float, height: float) -> Figure:
    """Return a figure of that many inches that is unknown to pyplot: no window, nothing to close."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _draw_symmetry_axis(ax: Axes, template: Template, size: float) -> None:
    """Draw the line through the middles of the symmetric pairs, square to what joins them."""
    landmarks = template.landmarks
    pairs = [(landmarks[a], landmarks[b]) for a, b in template.symmetry if a != b]
    if not pairs:
        return
    across = np.array([b - a for a, b in pairs])
    across *= np.sign(across @ across[0])[:, None]  # a pair may be listed right side first
    x, y = across.sum(axis=0)
    along = np.array([-y, x]) / max(math.hypot(x, y), 1e-12)
    middle = np.mean([(a + b) / 2 for a, b in pairs], axis=0)
    reach = (template.outline - middle) @ along
    ends = np.array([middle + t * along for t in (reach.min() - 0.04 * size, reach.max() + 0.04 * size)])
    ax.plot(*ends.T, color="0.55", linewidth=0.8, linestyle="-.", zorder=1)


def _draw_grasp_pairs(ax: Axes, template: Template, size: float) -> None:
    """Join the points of every pair, numbered from 1, the most preferred; later ones are fainter."""
    taken = list(template.landmarks.values())
    for rank, (first, second) in enumerate(template.grasp_pairs):
        a, b = template.landmarks[first], template.landmarks[second]
        alpha = max(0.35, 1 - 0.12 * rank)
        ax.plot(
            *np.array([a, b]).T, color="tab:blue", alpha=alpha, linewidth=max(0.6, 2 - 0.3 * rank), zorder=3
        )
        spot = _free_spot(a, b, taken, _NUMBER_PITCH * size)
        taken.append(spot)
        circle = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": "tab:blue"}
        ax.text(
            spot[0],
            spot[1],
            str(rank + 1),
            ha="center",
            va="center",
            fontsize=8,
            color="tab:blue",
            bbox=circle,
            zorder=5,
        )


def _free_spot(a: FloatArray, b: FloatArray, taken: list[FloatArray], pitch: float) -> FloatArray:
    """Return the point of a segment nearest its middle that is `pitch` away from all taken, or the freest."""
    shares = sorted(np.linspace(0.1, 0.9, 33), key=lambda share: abs(share - 0.5))
    spots = [a + share * (b - a) for share in shares]
    room = [min(math.dist(spot, other) for other in taken) for spot in spots]
    return next(
        (spot for spot, free in zip(spots, room, strict=True) if free >= pitch), spots[int(np.argmax(room))]
    )


def _draw_landmarks(ax: Axes, template: Template, size: float) -> float:
    """Mark the landmarks, name them in a column left and one right; return the y of the lowest name."""
    points = template.landmark_array
    ax.plot(*points.T, linestyle="none", marker="o", markersize=6, color="tab:red", zorder=4)
    low, high = template.outline.min(axis=0), template.outline.max(axis=0)
    on_left = points[:, 0] < (low[0] + high[0]) / 2
    names = np.array(list(template.landmarks))
    lowest = float(high[1])
    for chosen, x, side in (
        (on_left, low[0] - _LABEL_GAP * size, "right"),
        (~on_left, high[0] + _LABEL_GAP * size, "left"),
    ):
        order = np.argsort(points[chosen, 1], kind="stable")
        column = points[chosen][order]
        heights = _spread(column[:, 1], _LABEL_PITCH * size)
        for name, point, y in zip(names[chosen][order], column, heights, strict=True):
            ax.annotate(
                name.replace("_", " "),
                xy=point,
                xytext=(x, y),
                ha=side,
                va="center",
                fontsize=9,
                arrowprops={"arrowstyle": "-", "color": "tab:red", "linewidth": 0.6, "alpha": 0.6},
            )
            lowest = max(lowest, float(y))
        # Text does not count for the limits of the axes; an invisible point at the column's edge does.
        ax.plot([x], [low[1]], linestyle="none")
    return lowest


def _spread(wanted: FloatArray, pitch: float) -> FloatArray:
    """Return ascending heights at least `pitch` apart, as a whole no lower or higher than those wanted."""
    heights = np.array(wanted, dtype=np.float64)
    for i in range(1, len(heights)):
        heights[i] = max(heights[i], heights[i - 1] + pitch)
    if len(heights):
        heights -= float((heights - wanted).mean())
    return heights


def _draw_scale_bar(ax: Axes, template: Template, size: float, below: float) -> None:
    """Draw a bar of a round length (1, 2 or 5 times a power of ten) under the template."""
    longest = _BAR_SHARE * size
    power = 10.0 ** math.floor(math.log10(longest))
    length = next(step * power for step in (5, 2, 1) if step * power <= longest)
    x, y = float(template.outline[:, 0].min()), below + _BAR_GAP * size
    ax.plot([x, x + length], [y, y], color="black", linewidth=3, solid_capstyle="butt")
    ax.text(
        x + length / 2, y + 0.02 * size, f"{length:g} {template.units}", ha="center", va="top", fontsize=9
    )
