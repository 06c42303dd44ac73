"""Names, mirror pairs and grasp pairs of landmarks, proposed by rule from where they lie."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.drafting.halves import Places, mirrored
from foldrs.drafting.parameters import DraftParameters

Points = NDArray[np.float64]
Pair = tuple[str, str]

_MOST_WITHOUT_SYMMETRY = 6  # grasp pairs of a garment without mirror axis: beyond the widest none is natural


def generic_names(places: Places) -> list[str]:
    """Name corners by side and number from the top, ``corner_left_1``, or ``corner_top`` and so on."""
    names = [""] * len(places)
    left = [k for k, place in enumerate(places) if 0 < place < 1]
    right = [k for k, place in enumerate(places) if place > 1]
    for side, indices in (("left", left), ("right", right[::-1])):
        for number, k in enumerate(indices, start=1):
            names[k] = f"corner_{side}_{number}"
    on_axis = {0.0: "corner_top", 1.0: "corner_bottom"}
    return [name or on_axis[float(place)] for name, place in zip(names, places, strict=True)]


def mirror_pairs(names: Sequence[str], places: Places, parameters: DraftParameters) -> tuple[Pair, ...]:
    """Pair landmarks of the two halves that lie at like places of them, each the other's nearest.

    A landmark on the mirror axis is paired with itself.
    """
    pairs: list[Pair] = []
    near = parameters.same_corner
    on_axis = np.minimum(np.abs(np.mod(places + 0.5, 1.0) - 0.5), 1.0) < near
    left = [k for k, place in enumerate(places) if place < 1 and not on_axis[k]]
    right = [k for k, place in enumerate(places) if place > 1 and not on_axis[k]]
    apart = np.abs(places[left][:, None] - mirrored(places[right])[None])
    for i, k in enumerate(left if right else []):
        j = int(apart[i].argmin())
        if int(apart[:, j].argmin()) == i and apart[i, j] <= parameters.paired:
            pairs.append((names[k], names[right[j]]))
    return (*pairs, *((name, name) for name, on in zip(names, on_axis, strict=True) if on))


def grasp_pairs(landmarks: Mapping[str, Points], symmetry: Sequence[Pair]) -> tuple[tuple[Pair, str], ...]:
    """Propose pairs to grasp by, best first, each with its reason.

    Held by two corners that mirror each other a garment hangs upright and open, the wider apart the more so,
    and corners of the convex hull are within reach before others: those pairs come first, widest first, then
    mirror pairs within the hull, then two corners of the hull on one side that are far apart, farthest first;
    of pairs equally wide the upper one. Without mirror pairs it is any two corners of the hull.
    """
    points = np.array(list(landmarks.values()), dtype=np.float32)
    hull = {list(landmarks)[int(k)] for k in cv2.convexHull(points, returnPoints=False).ravel()}

    def apart(pair: Pair) -> float:
        return float(np.linalg.norm(landmarks[pair[0]] - landmarks[pair[1]]))

    def height(pair: Pair) -> float:
        return float(landmarks[pair[0]][1] + landmarks[pair[1]][1])

    paired = [pair for pair in symmetry if pair[0] != pair[1]]
    outer = [pair for pair in paired if set(pair) <= hull]
    inner = [pair for pair in paired if not set(pair) <= hull]
    groups = [(outer, "mirror pair on the hull"), (inner, "mirror pair within the hull")]
    if paired:
        sides = [[pair[0] for pair in outer], [pair[1] for pair in outer]]
        along = [pair for side in sides for pair in itertools.combinations(side, 2)]
        along = [pair for pair in along if apart(pair) >= 0.5 * max(map(apart, along))]
        groups.append((along, "one side, corners of the hull"))
    else:
        free = list(itertools.combinations([name for name in landmarks if name in hull], 2))
        groups.append((sorted(free, key=apart, reverse=True)[:_MOST_WITHOUT_SYMMETRY], "corners of the hull"))
    return tuple(
        (pair, f"{reason}, {apart(pair):.0f} apart")
        for pairs, reason in groups
        for pair in sorted(pairs, key=lambda pair: (-round(apart(pair)), height(pair)))
    )
