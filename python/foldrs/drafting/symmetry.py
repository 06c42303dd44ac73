"""The mirror axis of a flat garment: the line over which its outline is most like its own mirror image."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.drafting.parameters import DraftParameters

Points = NDArray[np.float64]


_SAME_AXIS = math.radians(15.0)
"""Axes whose directions differ by less are one: those of a garment are 45 degrees apart or more."""


@dataclass(frozen=True, eq=False)
class MirrorAxis:
    """A mirror axis, and how well it fits."""

    axis: Points
    """(2, 2) two points of it, in the frame of the outline, the upper one (smaller y) first."""
    deviation: float
    """Share of the area of garment and mirror image together that only one of them covers."""


def mirror_axis(outline: Points, parameters: DraftParameters) -> MirrorAxis:
    """Find the mirror axis of an outline.

    From every direction the axis goes step by step to where the mirror image lies nearest to the outline; far
    points, as those of a sleeve that lies otherwise than the other, count little. Of axes that are as good
    (a towel has two) the one nearest to the vertical is taken.

    Parameters
    ----------
    outline : (n, 2) array
        The flat garment's outline, y down.
    parameters : DraftParameters
    """
    size = math.sqrt(abs(_core.signed_area(outline)))
    points = _core.resample(outline, parameters.axis_points)
    angles = np.pi * np.arange(parameters.directions) / parameters.directions
    found = [_settled(points, angle, size, parameters) for angle in angles]
    least = min(one.deviation for one in found)
    factor, more = parameters.axis_tie
    good = [one for one in found if one.deviation <= factor * least + more]
    # Many starts end near one axis: of those the best, not the one that happens to stand straightest.
    straightest = _slope(min(good, key=lambda one: abs(_slope(one.axis))).axis)
    near = [one for one in good if abs(_slope(one.axis) - straightest) <= _SAME_AXIS]
    return min(near, key=lambda one: one.deviation)


def _settled(points: Points, angle: float, size: float, parameters: DraftParameters) -> MirrorAxis:
    """Follow the axis from a direction through the middle to the best symmetry near it."""
    axis = _line(points.mean(axis=0), angle)
    first, last = parameters.posed
    for step in range(parameters.axis_iterations):
        nearest, distance, _ = _core.nearest_on_outline(points, _core.reflect(points, axis))
        share = step / (parameters.axis_iterations - 1)
        reach = size * first ** (1 - share) * last**share
        axis = _best_axis(points, nearest, (1.0 + (distance / reach) ** 2) ** -2)
    deviation = 1.0 - _core.outline_iou(points, _core.reflect(points, axis))
    return MirrorAxis(axis if axis[0, 1] <= axis[1, 1] else axis[::-1].copy(), deviation)


def _best_axis(points: Points, images: Points, weight: NDArray[np.float64]) -> Points:
    """Return the line whose reflection carries points onto their images best, by weighted least squares."""
    p, q = np.average(points, axis=0, weights=weight), np.average(images, axis=0, weights=weight)
    a, b = points - p, images - q
    cosine = float(np.sum(weight * (a[:, 0] * b[:, 0] - a[:, 1] * b[:, 1])))
    sine = float(np.sum(weight * (a[:, 0] * b[:, 1] + a[:, 1] * b[:, 0])))
    return _line((p + q) / 2, math.atan2(sine, cosine) / 2)


def _line(through: Points, angle: float) -> Points:
    along = np.array([math.cos(angle), math.sin(angle)])
    return np.array([through - along, through + along])


def _slope(axis: Points) -> float:
    """Radians from the vertical to an axis given upper end first: between -pi/2 and pi/2."""
    x, y = axis[1] - axis[0]
    return math.atan2(float(x), float(y))
