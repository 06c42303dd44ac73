"""What the panels of a picture are drawn with: frames, lines with halos, markers, names that keep clear."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs._plot_labels import place_labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from foldrs.image import RgbImage

Points = NDArray[np.float64]

NAME_SIZE = 8.5  # points
NAME_LOOK = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
RING = 20.0  # points: diameter of the ring around a point that matters
_TABLE = "0.93"
_TICK = 0.012  # share of the panel's width: half of the tick at the end of a dimension line
_LETTER = 0.62  # mean width of a letter, in its height
_MOST_PIXELS = 1200  # px: larger photographs are reduced to this size before they are drawn


def frame(ax: Axes, points: Points, margin: float = 0.06) -> None:
    """Show all points, y down, with a margin (share of their extent); the panel is filled."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2, np.maximum(high - low, 1e-9)
    scale = float((size * (1 + 2 * margin) / [ax.bbox.width, ax.bbox.height]).max())
    half_width, half_height = scale * ax.bbox.width / 2, scale * ax.bbox.height / 2
    ax.set_xlim(middle[0] - half_width, middle[0] + half_width)
    ax.set_ylim(middle[1] + half_height, middle[1] - half_height)
    ax.set_aspect("equal")
    ax.set_facecolor(_TABLE)
    ax.set_xticks([])
    ax.set_yticks([])
    for spine in ax.spines.values():
        spine.set_visible(False)


def photograph(ax: Axes, image: RgbImage | None, *, pale: bool = False) -> None:
    """Draw what a framed panel shows of a photograph, if there is one; pale and grey if asked."""
    if image is None:
        return
    height, width = image.shape[:2]
    (x0, x1), (y1, y0) = ax.get_xlim(), ax.get_ylim()
    left, right = max(0, int(x0)), min(width, int(x1) + 2)
    top, bottom = max(0, int(y0)), min(height, int(y1) + 2)
    if left >= right or top >= bottom:
        return
    shown = np.ascontiguousarray(image[top:bottom, left:right])
    if (reduction := max(shown.shape) / _MOST_PIXELS) > 1:
        size = (max(1, round(shown.shape[1] / reduction)), max(1, round(shown.shape[0] / reduction)))
        shown = np.asarray(cv2.resize(shown, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    if pale:
        grey = np.asarray(cv2.cvtColor(shown, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
        shown = np.repeat(grey[:, :, None] // 2 + 128, 3, axis=2)
    ax.imshow(shown, extent=(left - 0.5, right - 0.5, bottom - 0.5, top - 0.5), zorder=0)
    ax.set_xlim(x0, x1)
    ax.set_ylim(y1, y0)


def line(ax: Axes, points: Points, colour: str, width: float, *, halo: str = "", **look: Any) -> None:
    """Draw a line through points; a halo keeps it visible on cloth of its own colour."""
    effects = outlined(width + 2, halo) if halo else None
    ax.plot(*points.T, color=colour, linewidth=width, path_effects=effects, **{"zorder": 3, **look})


def outlined(width: float, colour: str) -> list[Any]:
    """Path effects of a halo, `width` being that of the whole line."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=width, foreground=colour, alpha=0.8), Normal()]


def fill(ax: Axes, pieces: Iterable[Points], colour: str, opacity: float) -> None:
    """Fill outlines."""
    for piece in pieces:
        ax.fill(*piece.T, color=colour, alpha=opacity, linewidth=0, zorder=1)


def dimension(ax: Axes, segment: Points) -> None:
    """Draw a thin segment with ticks at its ends."""
    direction = segment[1] - segment[0]
    across = np.array([-direction[1], direction[0]]) / max(float(np.hypot(*direction)), 1e-9)
    tick = across * _TICK * abs(ax.get_xlim()[1] - ax.get_xlim()[0])
    for part in (segment, *(np.array([end - tick, end + tick]) for end in segment)):
        line(ax, part, "black", 0.9, halo="white", zorder=2)


def dot(ax: Axes, point: Points, *, filled: bool, size: float = 7) -> None:
    """Mark a point by a filled or hollow dot."""
    face, edge = ("black", "white") if filled else ("white", "black")
    look: dict[str, Any] = {"markerfacecolor": face, "markeredgecolor": edge, "markeredgewidth": 1.3}
    ax.plot(*point, "o", markersize=size, zorder=7, **look)


def rings(ax: Axes, points: Points, colour: str) -> None:
    """Ring points."""
    for shade, width in (("white", 6), (colour, 3.5)):
        look: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": shade, "markeredgewidth": width}
        ax.plot(*points.T, "o", markersize=RING, zorder=6, **look)


def arrow(ax: Axes, start: Points, end: Points, colour: str) -> None:
    """Draw an arrow."""
    look: dict[str, Any] = {"arrowstyle": "-|>,head_length=0.7,head_width=0.35", "color": colour}
    look |= {"linewidth": 2.2, "path_effects": outlined(4.5, "white")}
    tip, tail = (float(end[0]), float(end[1])), (float(start[0]), float(start[1]))
    ax.annotate("", xy=tip, xytext=tail, arrowprops=look, zorder=5)


def names(ax: Axes, points: Mapping[str, Points], keep_clear: Points, ringed: Collection[str] = ()) -> None:
    """Write names beside points, bold if ringed; leave the (m, 2) points to keep clear uncovered."""
    if not points:
        return
    dpi = ax.figure.dpi
    texts = [short_name(name) for name in points]
    anchors = ax.transData.transform(np.array(list(points.values())))
    height = NAME_SIZE * dpi / 72
    sizes = np.array([(_LETTER * height * len(text) + 6, 1.5 * height) for text in texts])
    angle = np.arange(24) * np.pi / 12
    circle = RING * dpi / 72 / 2 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    circles = [anchor + circle for anchor, name in zip(anchors, points, strict=True) if name in ringed]
    obstacles = np.vstack([ax.transData.transform(keep_clear), *circles])
    centres = place_labels(anchors, sizes, obstacles, np.array(ax.bbox.min), np.array(ax.bbox.max))

    to_data = ax.transData.inverted().transform
    for name, text, anchor, centre, size in zip(points, texts, anchors, centres, sizes, strict=True):
        nearest = np.clip(anchor, centre - size / 2, centre + size / 2)
        line(ax, to_data([anchor, nearest]), "black", 0.8, halo="white", zorder=6)
        x, y = to_data(centre)
        weight = "bold" if name in ringed else "normal"
        look: dict[str, Any] = {"fontsize": NAME_SIZE, "weight": weight, "bbox": NAME_LOOK}
        ax.text(x, y, text, ha="center", va="center", zorder=9, parse_math=False, **look)


def short_name(name: str) -> str:
    """Return a landmark's name with spaces, its sides as letters."""
    return " ".join({"left": "L", "right": "R"}.get(word, word) for word in name.split("_"))


def along(segment: Points, count: int = 40) -> Points:
    """Return points along a segment."""
    points: Points = segment[0] + np.linspace(0, 1, count)[:, None] * (segment[1] - segment[0])
    return points


def closed(outline: Points) -> Points:
    """Return an outline with its first point repeated at the end."""
    return np.vstack([outline, outline[:1]])
