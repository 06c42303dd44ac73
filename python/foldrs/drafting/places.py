"""Landmarks marked by hand, as places of the outline."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from foldrs._template_checks import LANDMARK_TOLERANCE
from foldrs._template_fields import field_error
from foldrs.drafting.corners import refined, size_of
from foldrs.drafting.halves import Halves, Places
from foldrs.drafting.parameters import DraftParameters

Points = NDArray[np.float64]

_SAME_PLACE = 0.005
"""Places nearer than this are one: 0.5 cm of a half of 1 m."""


def marked_places(
    cut: Halves, names: Sequence[str], spots: Points, corners: Places, p: DraftParameters
) -> Places:
    """Find the places of landmarks marked by hand: a corner nearby that is free, else the outline."""
    size = size_of(cut.ring)
    places, off = cut.places_of(spots)
    for n, distance in zip(names, off, strict=True):
        if distance > LANDMARK_TOLERANCE * size:
            raise field_error(
                f"landmarks.{n}", f"lies {distance:.3g} cm off the outline; landmarks must be points of it"
            )
    nearness = np.linalg.norm(spots[:, None] - refined(cut, corners, p)[None], axis=-1)
    marked: set[int] = set()
    taken: set[int] = set()
    for i, k in sorted(np.ndindex(*nearness.shape), key=lambda pair: float(nearness[pair])):
        if nearness[i, k] <= p.snap * size and i not in marked and k not in taken:
            places[i] = corners[k]
            marked.add(i)
            taken.add(k)
    return places


def joined(places: Places, more: Places, gap: float = _SAME_PLACE) -> Places:
    """Return the places in order with those of `more` that are farther than a gap from all of them."""
    new = [place for place in more if apart(places, place).min() > gap]
    return np.unique(np.concatenate([places, new]))


def snapped(places: Places, corners: Places, reach: float) -> Places:
    """Return places, each moved to the nearest corner within reach: simplified more, a corner may slip."""
    nearest = [float(corners[apart(corners, place).argmin()]) for place in places]
    found = np.array(
        [c if apart(np.array([c]), p)[0] < reach else p for c, p in zip(nearest, places, strict=True)]
    )
    return found if len(np.unique(found)) == len(found) else places


def apart(places: Places, place: float) -> Places:
    """Differences of places around the outline."""
    return np.asarray(np.abs(np.mod(places - place + 1.0, 2.0) - 1.0), dtype=np.float64)
