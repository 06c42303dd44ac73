"""What the parts of a template must be to each other; every error names the field at fault.

Single values have been parsed by then (:mod:`foldrs._template_fields`); geometry is the compiled module's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from foldrs import _core
from foldrs._template_fields import Pairs, field_error, shown

LANDMARK_TOLERANCE = 0.05
"""How far off the outline a landmark may be given, as a share of the square root of the area: 3 cm on a shirt
of 60 x 60 cm. Corners marked by hand on a garment with a rounded hem lie that far off, wrong ones farther."""

_ROUNDING = 1e-9
"""Distance, in the same measure, that is rounding only: such a landmark is kept exactly as given."""


def read_only(array: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return a float64 copy that cannot be written to."""
    copy = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy


def check_outline(outline: npt.NDArray[np.float64]) -> None:
    """Refuse an outline that is no simple polygon."""
    if outline.ndim != 2 or outline.shape[1] != 2:
        raise field_error("outline", f"must be (n, 2) coordinates, not an array of shape {outline.shape}")
    repeated = np.flatnonzero((outline == np.roll(outline, 1, axis=0)).all(axis=1))
    if len(outline) > 1 and repeated.size:
        # The first point equals the one before it, the last, where somebody closed the outline.
        i = int(repeated[-1]) or len(outline) - 1
        raise field_error(
            f"outline[{i}]", "repeats its neighbour; leave it out (outlines close by themselves)"
        )
    try:
        _core.check_outline(outline)
    except ValueError as error:
        raise field_error("outline", str(error)) from error


def snap_landmarks(
    outline: npt.NDArray[np.float64], landmarks: Mapping[str, npt.NDArray[np.float64]]
) -> dict[str, npt.NDArray[np.float64]]:
    """Return the landmarks moved onto the outline, or refuse those too far off it."""
    if not landmarks:
        raise field_error("landmarks", "there must be at least one, or there is nothing to find")
    given = np.array(list(landmarks.values()), dtype=np.float64)
    nearest, distances, _ = _core.nearest_on_outline(outline, given)
    size = math.sqrt(abs(_core.signed_area(outline)))
    for name, distance in zip(landmarks, distances, strict=True):
        if not distance <= LANDMARK_TOLERANCE * size:
            problem = f"lies {distance:.3g} off the outline, more than {LANDMARK_TOLERANCE * size:.3g}"
            raise field_error(f"landmarks.{name}", f"{problem}; landmarks must be points of the outline")
    # A landmark on the outline is kept as given, so that saving and loading changes nothing.
    snapped = np.where((distances > _ROUNDING * size)[:, None], nearest, given)
    return {name: read_only(point) for name, point in zip(landmarks, snapped, strict=True)}


def check_symmetry(pairs: Pairs, landmarks: Mapping[str, object]) -> None:
    """Refuse unknown landmarks and those with two mirror images."""
    _check_names("symmetry", pairs, landmarks)
    paired: set[str] = set()
    for i, pair in enumerate(pairs):
        if paired & set(pair):
            name = next(name for name in pair if name in paired)
            raise field_error(f"symmetry[{i}]", f"{shown(name)} has a mirror image already")
        paired.update(pair)


def check_grasp_pairs(pairs: Pairs, landmarks: Mapping[str, object]) -> None:
    """Refuse unknown landmarks, a point paired with itself and a pair given twice."""
    _check_names("grasp_pairs", pairs, landmarks)
    seen: set[frozenset[str]] = set()
    for i, pair in enumerate(pairs):
        if pair[0] == pair[1]:
            raise field_error(f"grasp_pairs[{i}]", "names one landmark twice; two hands need two points")
        if frozenset(pair) in seen:
            raise field_error(f"grasp_pairs[{i}]", "is listed already; keep the more preferred of the two")
        seen.add(frozenset(pair))


def check_spread(spread: Mapping[str, float], landmarks: Mapping[str, object]) -> None:
    """Refuse unknown landmarks and spreads that are not positive."""
    for name, value in spread.items():
        if name not in landmarks:
            raise field_error(f"spread.{name}", "is no landmark of this template")
        if not (math.isfinite(value) and value > 0):
            raise field_error(f"spread.{name}", f"must be a positive number, not {value}")


def _check_names(field: str, pairs: Pairs, landmarks: Mapping[str, object]) -> None:
    for i, pair in enumerate(pairs):
        for j, name in enumerate(pair):
            if name not in landmarks:
                raise field_error(f"{field}[{i}][{j}]", f"{shown(name)} is no landmark of this template")
