"""The layers of a folded garment, and where every point of it comes to lie.

The cutting and turning over is :func:`foldrs._core.fold_layers`; here its pieces are stacked. Every layer
keeps its ring in the garment's own unfolded frame together with the turns it has made, so that any point of
the garment (rim, landmark, crease, thread of a print) is carried to where it lies by the same function.
Lengths are in centimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.errors import ParameterError
from foldrs.synth.garment import STEP_CM, Points

_TOUCH_CM = 0.3
"""A layer that reaches across a fold line by less than this is not cut by it."""

_LOOSE_CM = 4.0
"""Distance from the crease over which the flap's own turn grows: at the crease the cloth holds together."""

_SHORTEST_PIECE_CM = 1.0
"""Pieces of a crease shorter than this are not listed."""


@dataclass(frozen=True, eq=False)
class Turn:
    """A piece of cloth turned over a line, and lying a little turned away from where it should.

    Attributes
    ----------
    axis : ndarray of shape (2, 2)
        End points of the fold axis.
    angle : float
        Extra turn about the middle of the axis, radians.
    """

    axis: Points
    angle: float = 0.0

    def apply(self, points: Points) -> Points:
        """Carry points of the piece to where they lie after the turn."""
        turned = self.reflect(points)
        return turned + self._slip(turned)

    def undo(self, points: Points) -> Points:
        """Carry points of the turned piece back to where they were."""
        before = points
        for _ in range(4):  # the slip changes slowly: at 2 degrees four steps leave well under 1 mm
            before = points - self._slip(before)
        return self.reflect(before)

    def reflect(self, points: Points) -> Points:
        """Return the mirror images of points in the axis."""
        normal, offset = self._line
        return np.asarray(points - 2 * (points @ normal - offset)[:, None] * normal, dtype=np.float64)

    def height(self, points: Points) -> NDArray[np.float64]:
        """Return the distance of points from the axis's line, positive on the side that is turned over."""
        normal, offset = self._line
        return np.asarray(points @ normal - offset, dtype=np.float64)

    @cached_property
    def _line(self) -> tuple[Points, float]:
        along = self.axis[1] - self.axis[0]
        normal = np.array([-along[1], along[0]]) / float(np.hypot(*along))
        return normal, float(normal @ self.axis[0])

    def _slip(self, points: Points) -> Points:
        distance = np.abs(self.height(points))
        angle = self.angle * distance / (distance + _LOOSE_CM)
        arm = points - self.axis.mean(axis=0)
        cos, sin = np.cos(angle) - 1, np.sin(angle)
        return np.column_stack([cos * arm[:, 0] - sin * arm[:, 1], sin * arm[:, 0] + cos * arm[:, 1]])


@dataclass(frozen=True, eq=False)
class Layer:
    """One piece of cloth between creases.

    Attributes
    ----------
    ring : ndarray of shape (n, 2)
        Its rim in the unfolded garment.
    turns : tuple of Turn
        The turns it has made, first made first.
    """

    ring: Points
    turns: tuple[Turn, ...] = ()

    def place(self, points: Points) -> Points:
        """Carry points of the unfolded garment to where they lie on the table."""
        for turn in self.turns:
            points = turn.apply(points)
        return points

    def unplace(self, points: Points) -> Points:
        """Carry points of this layer on the table back to the unfolded garment."""
        for turn in reversed(self.turns):
            points = turn.undo(points)
        return points

    def exact(self) -> Points:
        """Return the ring where it would lie after exact folds."""
        ring = self.ring
        for turn in self.turns:
            ring = turn.reflect(ring)
        return ring

    def holds(self, point: Points) -> float:
        """Tell how far inside this layer (negative: outside) a point of the unfolded garment is."""
        ring = self.ring.astype(np.float32).reshape(-1, 1, 2)
        return float(cv2.pointPolygonTest(ring, (float(point[0]), float(point[1])), True))


@dataclass(frozen=True, eq=False)
class Fold:
    """One fold of a flat garment or of a stack of layers.

    Attributes
    ----------
    turn : Turn
        The axis, from the first entry into the outline folded to the last exit from it, with the flap's slip.
    creases : ndarray of shape (c, 2, 2)
        The creased pieces of the axis.
    outline : ndarray of shape (n, 2)
        Outline of the whole after this fold, exact.
    fraction : float
        Share of the area of the outline folded that is turned over.
    under : bool
        Whether the flap lies below the kept part.
    scenario : str
        How the line was drawn.
    """

    turn: Turn
    creases: Points
    outline: Points
    fraction: float
    under: bool
    scenario: str


def fold_flat(garment: Points, fold: Fold) -> list[Layer]:
    """Fold a flat garment; return its layers, lowest first.

    Raises
    ------
    ParameterError
        If the fold's axis does not cut the garment cleanly; another one will.
    """
    kept, flap = _pieces(garment, fold.turn, ())
    return _stacked(kept, flap, fold.under)


def fold_again(layers: list[Layer], fold: Fold) -> list[Layer]:
    """Fold the whole stack along a line that runs all across it; return its layers, lowest first."""
    kept, flap = [], []
    for layer in layers:
        ring = layer.exact()
        height = fold.turn.height(ring)
        if height.max() < _TOUCH_CM:
            kept.append(layer)
        elif height.min() > -_TOUCH_CM:
            flap.append(Layer(layer.ring, (*layer.turns, fold.turn)))
        else:
            stays, turned = _pieces(ring, _lengthened(fold.turn, ring), layer.turns)
            kept += stays
            flap += [Layer(piece.ring, (*layer.turns, fold.turn)) for piece in turned]
    return _stacked(kept, flap, fold.under)


def layer_of(layers: list[Layer], point: Points) -> Layer:
    """Find the layer a point of the unfolded garment belongs to."""
    return max(layers, key=lambda layer: layer.holds(point))


def crease_pieces(folds: list[Fold]) -> list[Points]:
    """Find where the first fold's creases lie after all the folds, in pieces of shape (2, 2).

    A later fold across a crease breaks it in two and turns one of them over.
    """
    pieces = [np.asarray(crease, dtype=np.float64) for crease in folds[0].creases]
    for fold in folds[1:]:
        broken: list[Points] = []
        for piece in pieces:
            first, last = fold.turn.height(piece)
            parts = [piece]
            if first * last < 0:
                cut = piece[0] + (piece[1] - piece[0]) * (first / (first - last))
                parts = [np.array([piece[0], cut]), np.array([cut, piece[1]])]
            broken += [fold.turn.apply(p) if fold.turn.height(p).sum() > 0 else p for p in parts]
        pieces = broken
    lengths = [float(np.linalg.norm(p[1] - p[0])) for p in pieces]
    longest = max(lengths)
    return [p for p, n in zip(pieces, lengths, strict=True) if n >= min(_SHORTEST_PIECE_CM, longest)]


def _pieces(ring: Points, turn: Turn, before: tuple[Turn, ...]) -> tuple[list[Layer], list[Layer]]:
    """Cut a ring that has made the turns ``before`` along an axis: the layers kept, those turned over."""
    try:
        folded = _core.fold_layers(np.ascontiguousarray(ring), np.ascontiguousarray(turn.axis))
    except ValueError as error:
        raise ParameterError(f"A layer cannot be cut cleanly: {error}.") from error

    def layer(piece: Points, turns: tuple[Turn, ...]) -> Layer:
        for done in reversed(turns):
            piece = done.reflect(piece)
        return Layer(_densified(piece), turns)

    kept = [layer(np.asarray(piece, dtype=np.float64), before) for piece in folded.kept]
    flap = [layer(np.asarray(piece, dtype=np.float64), (*before, turn)) for piece in folded.flap]
    return kept, flap


def _stacked(kept: list[Layer], flap: list[Layer], under: bool) -> list[Layer]:
    """Stack layers, lowest first; what was on top of the flap comes to lie at its bottom."""
    flap = flap[::-1]
    return flap + kept if under else kept + flap


def _lengthened(turn: Turn, ring: Points) -> Turn:
    """Lengthen a turn's axis past a ring at both ends, so that every chord of the ring is creased."""
    start, end = turn.axis
    along = (end - start) / float(np.linalg.norm(end - start))
    reach = (ring - start) @ along
    axis = np.array([start + (reach.min() - 1) * along, start + (reach.max() + 1) * along])
    return Turn(axis, turn.angle)


def _densified(ring: Points) -> Points:
    """Add points on the long sides of a ring (the creases), so that it can be bent."""
    ahead = np.roll(ring, -1, axis=0)
    counts = np.maximum(1, np.ceil(np.linalg.norm(ahead - ring, axis=1) / STEP_CM)).astype(int)
    index = np.repeat(np.arange(len(ring)), counts)
    share = np.concatenate([np.arange(c) / c for c in counts])[:, None]
    return np.asarray(ring[index] * (1 - share) + ahead[index] * share, dtype=np.float64)
