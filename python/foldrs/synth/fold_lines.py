"""Where a garment is folded: lines drawn in the ways people fold.

========== ===========================================================================================
random     any direction, any place
landmarks  through or near two landmarks
parallel   along a side of the outline, at some distance from it
corner     across a corner
halves     along the garment's line of symmetry or near it (needs symmetric pairs of landmarks)
limb       a line across several protruding parts, or one of them and the body, that folds one part only
limbs      the same line, folding all that lies beyond it
========== ===========================================================================================

A way that a garment does not offer (no landmarks, no protruding part) is passed over. Lengths are in cm.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from foldrs import _core
from foldrs.errors import ParameterError
from foldrs.synth.garment import Garment, Points, polygon_area
from foldrs.synth.layers import Fold, Turn
from foldrs.synth.parameters import SynthParameters

_TRIES = 40
"""Lines drawn in one way before it is passed over."""

_SHORTEST_CREASE_CM = 4.0
"""A crease shorter than this is not a fold one would make."""

_NEAR_CM, _NEAR_RAD = 2.0, np.radians(4.0)
"""How near "near a landmark", "near the symmetry line" and "along a side" are (standard deviations)."""

_SIDE_TOLERANCE = 0.02
"""Simplification tolerance that gives an outline's sides, share of the root of its area."""

_ACROSS = ("random", "parallel", "corner")
"""Ways of drawing a line that need no landmark and run all across: those of a second fold."""

Line = tuple[Points, float]
"""A point of the line and its direction (radians)."""


def draw_fold(garment: Garment, rng: np.random.Generator, parameters: SynthParameters) -> Fold:
    """Draw the fold of a flat garment.

    Parameters
    ----------
    garment : Garment
        The unfolded garment.
    rng : numpy.random.Generator
        Source of all randomness.
    parameters : SynthParameters
        ``scenarios``, ``flap_fraction``, ``under``, ``flap_turn_deg``.

    Raises
    ------
    ParameterError
        If no way of folding asked for gives a flap within the bounds on this garment.
    """
    return _draw(garment, rng, parameters, parameters.scenarios)


def draw_second_fold(folded: Points, rng: np.random.Generator, parameters: SynthParameters) -> Fold:
    """Draw a further fold, all across the outline of a folded garment; see :func:`draw_fold`."""
    ways = tuple(way for way in parameters.scenarios if way in _ACROSS)
    return _draw(Garment("", folded, {}), rng, parameters, ways or _ACROSS)


def _draw(
    garment: Garment, rng: np.random.Generator, parameters: SynthParameters, ways: tuple[str, ...]
) -> Fold:
    angle = np.radians(rng.normal(0.0, parameters.flap_turn_deg)) if parameters.flap_turn_deg else 0.0
    under = bool(rng.random() < parameters.under)
    for way in rng.permutation(np.array(ways)).tolist():
        for _ in range(_TRIES):
            line = _LINES[way](garment, rng)
            if line is None:
                break
            fold = _fold_along(garment, line, way, float(angle), under, rng)
            if (
                fold is not None
                and parameters.flap_fraction[0] <= fold.fraction <= parameters.flap_fraction[1]
            ):
                return fold
    raise ParameterError(
        f"No fold ({', '.join(dict.fromkeys(ways))}) of the garment {garment.name!r} turns over a share of "
        f"{parameters.flap_fraction[0]:g} to {parameters.flap_fraction[1]:g} of it: "
        "widen flap_fraction or name other scenarios."
    )


def _fold_along(
    garment: Garment, line: Line, way: str, angle: float, under: bool, rng: np.random.Generator
) -> Fold | None:
    """Fold along a line, the smaller part being the flap; None where that gives no clean fold."""
    point, direction = line
    along = np.array([np.cos(direction), np.sin(direction)])
    reach = (garment.outline - point) @ along
    axis = np.array([point + (reach.min() - 1) * along, point + (reach.max() + 1) * along])
    try:
        if way in ("limb", "limbs"):
            chords = _core.fold_layers(garment.outline, axis).creases
            if len(chords) < 2:
                return None
            if way == "limb":
                axis = np.asarray(chords[rng.integers(len(chords))], dtype=np.float64)
        area = polygon_area(garment.outline)
        for ends in (axis, axis[::-1]):
            folded = _core.fold_layers(garment.outline, np.ascontiguousarray(ends))
            fraction = sum(polygon_area(np.asarray(piece)) for piece in folded.flap) / area
            if fraction <= 0.5:
                break
        else:
            return None
    except ValueError:  # the line misses the garment, or no clean piece comes off
        return None
    creases = np.asarray(folded.creases, dtype=np.float64).reshape(-1, 2, 2)
    lengths = np.linalg.norm(creases[:, 1] - creases[:, 0], axis=1)
    if len(folded.kept) != 1 or folded.holes or lengths.min() < _SHORTEST_CREASE_CM:
        return None
    ahead = ends[1] - ends[0]
    ordered = creases.reshape(-1, 2)
    ordered = ordered[np.argsort((ordered - ends[0]) @ ahead, kind="stable")]
    turn = Turn(np.array([ordered[0], ordered[-1]]), angle)
    return Fold(turn, creases, np.asarray(folded.outline, dtype=np.float64), fraction, under, way)


def _random(garment: Garment, rng: np.random.Generator) -> Line | None:
    direction = rng.uniform(0.0, np.pi)
    normal = np.array([-np.sin(direction), np.cos(direction)])
    height = garment.outline @ normal
    return normal * rng.uniform(height.min(), height.max()), direction


def _near_landmarks(garment: Garment, rng: np.random.Generator) -> Line | None:
    if len(garment.landmarks) < 2:
        return None
    points = np.array(list(garment.landmarks.values()))
    first, second = points[rng.choice(len(points), 2, replace=False)] + rng.normal(0.0, _NEAR_CM, (2, 2))
    return first, float(np.arctan2(*(second - first)[::-1]))


def _parallel(garment: Garment, rng: np.random.Generator) -> Line | None:
    corners = _corners(garment.outline)
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    side = sides[rng.choice(len(sides), p=lengths / lengths.sum())]
    direction = float(np.arctan2(side[1], side[0]) + rng.normal(0.0, _NEAR_RAD))
    normal = np.array([-np.sin(direction), np.cos(direction)])
    height = garment.outline @ normal
    return normal * rng.uniform(height.min(), height.max()), direction


def _corner(garment: Garment, rng: np.random.Generator) -> Line | None:
    corners = _corners(garment.outline)
    corner, centre = corners[rng.integers(len(corners))], garment.outline.mean(axis=0)
    inward = centre - corner
    direction = float(np.arctan2(inward[1], inward[0]) + np.pi / 2 + rng.normal(0.0, np.radians(15)))
    return corner + inward * rng.uniform(0.15, 0.8), direction


def _halves(garment: Garment, rng: np.random.Generator) -> Line | None:
    pairs = [
        (garment.landmarks[a], garment.landmarks[b])
        for a, b in garment.symmetry
        if a != b and a in garment.landmarks and b in garment.landmarks
    ]
    if not pairs:
        return None
    left, right = np.array(pairs).transpose(1, 0, 2)
    across = (right - left).sum(axis=0)
    direction = float(np.arctan2(across[1], across[0]) + np.pi / 2 + rng.normal(0.0, _NEAR_RAD))
    return (left + right).mean(axis=0) / 2 + rng.normal(0.0, _NEAR_CM, 2), direction


def _corners(outline: Points) -> Points:
    tolerance = _SIDE_TOLERANCE * float(np.sqrt(polygon_area(outline)))
    return np.asarray(_core.simplify(np.ascontiguousarray(outline), tolerance), dtype=np.float64)


_LINES: dict[str, Callable[[Garment, np.random.Generator], Line | None]] = {
    "random": _random,
    "landmarks": _near_landmarks,
    "parallel": _parallel,
    "corner": _corner,
    "halves": _halves,
    "limb": _random,
    "limbs": _random,
}
