"""Straight lines along the sides of a registered template, and the corners they make (section 2.2.3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs.parameters import FittingParameters

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SampledSides:
    """Equally spaced points of a template, grouped by its sides."""

    corners: NDArray[np.float64]
    """(n,) arc lengths of the template's corners."""
    at: NDArray[np.float64]
    """(k,) arc lengths of the points."""
    side: NDArray[np.intp]
    """(k,) the side that each lies on: i runs from corner i to the next."""

    @classmethod
    def of(cls, outline: Points, spacing: float) -> SampledSides:
        """Sample every side at about `spacing`, its corners left out."""
        lengths = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
        corners = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
        counts = np.floor(lengths / spacing).astype(np.intp)
        side = np.repeat(np.arange(len(outline)), counts)
        place = np.arange(len(side)) - np.repeat(np.cumsum(counts) - counts, counts)
        return cls(corners, corners[side] + (place + 0.5) * lengths[side] / counts[side], side)


def straight_lines(
    points: Points,
    side: NDArray[np.intp],
    supported: NDArray[np.bool_],
    unit: float,
    parameters: FittingParameters,
) -> dict[int, Points]:
    """Fit a straight line to the points of every side, outliers left out by RANSAC.

    Parameters
    ----------
    points : (k, 2) array
        Registered points of the template.
    side : (k,) array
        The side each lies on.
    supported : (k,) array
        Whether it lies where the garment is visible; the others are extrapolated and take no part.
    unit : float
        Square root of the registered template's area.
    parameters : FittingParameters
        Tolerance, fewest points and seed.

    Returns
    -------
    dict of int to (2, 2) array
        A point of the line and its direction, for every side with enough points.
    """
    from skimage import measure  # slow to import, and needed by this stage alone

    ransac: Callable[..., Any] = measure.ransac
    lines: dict[int, Points] = {}
    for i in np.unique(side):
        own = points[(side == i) & supported]
        if len(own) < parameters.fewest:
            continue
        _, inliers = ransac(
            own,
            measure.LineModelND,
            min_samples=2,
            residual_threshold=parameters.tolerance * unit,
            max_trials=parameters.trials,
            stop_probability=parameters.certainty,
            rng=parameters.seed,
        )
        if inliers is not None and inliers.sum() >= parameters.fewest:
            lines[int(i)] = principal_line(own[inliers])
    return lines


def principal_line(points: Points) -> Points:
    """Return mean and main direction of (k, 2) points: the line with the least squared distances."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    return np.stack([middle, axes[0]])


def new_corners(
    registered: Points, lines: Mapping[int, Points], unit: float, parameters: FittingParameters
) -> Points:
    """Find the corners of the updated template: where the lines of neighbouring sides meet.

    A corner stays where it was registered if one of its sides has no line, if they are nearly parallel, or if
    they meet too far away.

    Parameters
    ----------
    registered : (n, 2) array
        The registered corners.
    lines : mapping of int to (2, 2) array
        Point and direction of the sides' lines; side i starts at corner i.
    unit : float
        Square root of the registered template's area.
    parameters : FittingParameters
        Least angle and largest shift.
    """
    corners: Points = registered.copy()
    for i in range(len(corners)):
        before, after = lines.get((i - 1) % len(corners)), lines.get(i)
        if before is None or after is None:
            continue
        (p, u), (q, v) = before, after
        sine = u[0] * v[1] - u[1] * v[0]
        if abs(sine) < np.sin(np.radians(parameters.least_angle)):
            continue
        meeting = p + u * (((q - p)[0] * v[1] - (q - p)[1] * v[0]) / sine)
        if np.linalg.norm(meeting - registered[i]) <= parameters.largest_shift * unit:
            corners[i] = meeting
    return corners
