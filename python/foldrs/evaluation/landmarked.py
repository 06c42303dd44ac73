"""Places on an outline told by its landmarks: so they can be carried to another garment of its kind.

A place (k, t) lies a share t of the way along the outline from landmark k to landmark k + 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Places:
    """Places on an outline, each by a landmark and a share of the way to the next."""

    after: NDArray[np.intp]
    """(m,) index of the landmark before the place."""
    share: NDArray[np.float64]
    """(m,) share of the way to the next landmark, 0 to 1."""


@dataclass(frozen=True, eq=False)
class LandmarkedOutline:
    """A closed outline with its landmarks, in their order along it."""

    points: Points
    """(n, 2) outline, either winding."""
    landmarks: Points
    """(l, 2) at least three, in the order of the outline, in either direction."""

    @cached_property
    def _ring(self) -> LineString:
        return LineString(np.vstack([self.points, self.points[:1]]))

    @cached_property
    def _arc(self) -> NDArray[np.float64]:
        return self._arc_of(self.landmarks)

    @cached_property
    def _sign(self) -> int:
        """1 if the landmarks follow each other in the direction of the points, -1 if against it.

        The right direction passes all of them in one turn, the wrong one needs a turn for almost each.
        """
        forward = ((np.roll(self._arc, -1) - self._arc) % self._ring.length).sum()
        backward = ((self._arc - np.roll(self._arc, -1)) % self._ring.length).sum()
        return 1 if forward <= backward else -1

    @cached_property
    def _spans(self) -> NDArray[np.float64]:
        """Length of outline from every landmark to the next."""
        steps = (np.roll(self._arc, -1) - self._arc) * self._sign
        return np.asarray(steps % self._ring.length, dtype=np.float64)

    def locate(self, points: Points) -> Places:
        """Places of the points of the outline nearest to given ones."""
        away = ((self._arc_of(points)[:, None] - self._arc) * self._sign) % self._ring.length
        # Beyond the next landmark by rounding alone is still before it.
        beyond = np.where(self._spans > 0, np.maximum(away - self._spans, 1e-9), np.inf)
        after = beyond.argmin(axis=1)
        share = away[np.arange(len(points)), after] / self._spans[after]
        return Places(after, np.minimum(share, 1.0))

    def at(self, places: Places) -> Points:
        """Points (m, 2) at places."""
        arc = self._arc[places.after] + self._sign * places.share * self._spans[places.after]
        found = shapely.line_interpolate_point(self._ring, arc % self._ring.length)
        return np.asarray(shapely.get_coordinates(found), dtype=np.float64)

    def at_relabelled(self, places: Places, relabelling: Sequence[int]) -> Points:
        """Points at places of another garment, whose landmark k is called ``relabelling[k]`` here."""
        names, n = np.asarray(relabelling, dtype=np.intp), len(relabelling)
        a, b = names[places.after], names[(places.after + 1) % n]
        same_way = b == (a + 1) % n
        return self.at(Places(np.where(same_way, a, b), np.where(same_way, places.share, 1 - places.share)))

    def spread(self, n: int) -> Points:
        """Return n points (n, 2) at equal distance along the outline."""
        arc = np.arange(n) * self._ring.length / n
        return np.asarray(
            shapely.get_coordinates(shapely.line_interpolate_point(self._ring, arc)), dtype=np.float64
        )

    def _arc_of(self, points: Points) -> NDArray[np.float64]:
        return np.asarray(shapely.line_locate_point(self._ring, shapely.points(points)), dtype=np.float64)
