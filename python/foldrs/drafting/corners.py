"""The corners of an outline: by Douglas-Peucker, then where the straight sides between them meet."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.drafting.halves import Halves, Places, mirrored
from foldrs.drafting.parameters import DraftParameters
from foldrs.errors import ParameterError
from foldrs.straight_sides import new_corners, principal_line

Points = NDArray[np.float64]

_SIDE_SAMPLES = 24
_SIDE_PART = (0.15, 0.85)  # of a side that its line is fitted to: corners are rounded
_FACTORS = np.geomspace(1.0, 4.0, 20)  # on the usual tolerance, tried for a given number of corners


def corners_of(cut: Halves, tolerance: float, symmetric: bool, parameters: DraftParameters) -> Places:
    """Find the places of the corners of an upright outline, in their order from the top.

    Parameters
    ----------
    cut : Halves
        The outline.
    tolerance : float
        Of the Douglas-Peucker simplification, as a share of the square root of the area.
    symmetric : bool
        Whether the garment is its own mirror image: then corners are looked for in the mean of the two
        halves, and every corner has its partner.
    parameters : DraftParameters
    """
    near = parameters.same_corner
    of = cut.mean(parameters.samples) if symmetric else cut
    places, _ = of.places_of(_core.simplify(of.ring, tolerance * size_of(of.ring)))
    if not symmetric:
        return np.sort(places)
    # What the simplification finds on one half only is a corner of both.
    shares = np.sort(np.where(places > 1, 2 - places, places))
    groups = np.split(shares, np.flatnonzero(np.diff(shares) > near) + 1)
    shares = np.array([group.mean() for group in groups])
    shares = np.where(shares < near, 0.0, np.where(shares > 1.0 - near, 1.0, shares))
    return np.unique(np.concatenate([shares, mirrored(shares)]))


def salient_corners(cut: Halves, count: int, symmetric: bool, parameters: DraftParameters) -> Places:
    """Find as many corners as asked for, those that stand out most; or, for 0, those that stand out clearly.

    Raises
    ------
    ParameterError
        If no simplification has so many; the message tells which numbers there are.
    """
    if count == 0:
        return corners_of(cut, parameters.corner_tolerance, symmetric, parameters)
    offered: set[int] = set()
    # The usual tolerance first, then farther and farther from it, so that the corners shown are those named.
    for factor in np.stack([_FACTORS, 1 / _FACTORS], axis=1).ravel():
        tolerance = float(factor) * parameters.corner_tolerance
        places = corners_of(cut, tolerance, symmetric, parameters)
        if len(places) == count:
            return places
        offered.add(len(places))
    numbers = ", ".join(map(str, sorted(offered)))
    raise ParameterError(
        f"{count} landmarks are named, but the outline offers {numbers} corners: name as many as one of "
        "these, with - for a corner that is no landmark"
    )


def refined(cut: Halves, places: Places, parameters: DraftParameters) -> Points:
    """Return the corners at ascending places, moved to where the straight sides beside them meet.

    A corner between sides that are nearly parallel stays, and so does one that would move far: there a side
    is curved. All stay if the outline would cross itself.
    """
    spans = np.mod(np.roll(places, -1) - places, 2.0)
    part = np.linspace(*_SIDE_PART, _SIDE_SAMPLES)
    lines = {
        side: principal_line(cut.at(np.mod(place + span * part, 2.0)))
        for side, (place, span) in enumerate(zip(places, spans, strict=True))
    }
    corners = new_corners(cut.at(places), lines, size_of(cut.ring), parameters.meeting)
    return corners if _is_simple(corners) else cut.at(places)  # lines beside a narrow gap may cross


def symmetrised(corners: Points, places: Places) -> Points:
    """Return corners that are mirror images of each other, each the mean of its own and its partner's."""
    partner = np.array([int(np.abs(places - place).argmin()) for place in mirrored(places)])
    return np.asarray((corners + corners[partner] * [-1.0, 1.0]) / 2, dtype=np.float64)


def _is_simple(ring: Points) -> bool:
    try:
        _core.check_outline(ring)
    except ValueError:
        return False
    return True


def size_of(ring: Points) -> float:
    """Square root of the area, the measure of all tolerances."""
    return math.sqrt(abs(_core.signed_area(ring)))
