"""How the folded garment lies in the picture: smoothly deformed, turned, mirrored or not, and placed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs.camera._matrices import carried, inverse
from foldrs.errors import ParameterError
from foldrs.synth.garment import Points
from foldrs.synth.parameters import SynthParameters

_WAVES = 5
"""Plane waves the deformation is made of: enough that no direction stands out."""

_WAVELENGTH_CM = (30.0, 90.0)
"""Range of their wavelengths: a sleeve bends, a hem does not crinkle."""

_TURNS = 60
"""Directions tried before a garment is declared too large for the picture."""


@dataclass(frozen=True, eq=False)
class Pose:
    """The map from the table (cm, exact folds) to the picture (px).

    A point p goes to ``matrix @ (p + d(p)) + offset`` with the displacement d(p) = sum over waves k of
    ``amplitudes[k] * sin(waves[k] . p + phases[k])``.

    Attributes
    ----------
    waves, amplitudes : ndarray of shape (k, 2)
        Wave vectors (radians per cm) and amplitudes (cm).
    phases : ndarray of shape (k,)
        Phases, radians.
    matrix : ndarray of shape (2, 2)
        Turn, mirror image and scale, px per cm.
    offset : ndarray of shape (2,)
        Position in the picture, px.
    camera : ndarray of shape (3, 3), optional
        Homography from this view from above to the picture of a camera that looks at an angle, px both.
    """

    waves: Points
    amplitudes: Points
    phases: NDArray[np.float64]
    matrix: Points
    offset: Points
    camera: Points | None = None

    @property
    def mirrored(self) -> bool:
        """Whether the garment is seen from behind."""
        return bool(np.linalg.det(self.matrix) < 0)

    def to_image(self, points: Points) -> Points:
        """Carry points on the table (cm), shape (n, 2), to the picture (px)."""
        bent = points + self._displacement(points)
        above = np.asarray(bent @ self.matrix.T + self.offset, dtype=np.float64)
        return above if self.camera is None else seen_by(self.camera, above)

    def to_table(self, points: Points) -> Points:
        """Carry points of the picture (px), shape (n, 2), back to the table (cm)."""
        points = points if self.camera is None else seen_by(inverse(self.camera), points)
        bent = (points - self.offset) @ np.linalg.inv(self.matrix).T
        flat = np.asarray(bent, dtype=np.float64)
        for _ in range(3):  # the displacement changes slowly: three steps leave less than 0.1 mm
            flat = bent - self._displacement(flat)
        return flat

    def _displacement(self, points: Points) -> Points:
        return np.asarray(np.sin(points @ self.waves.T + self.phases) @ self.amplitudes, dtype=np.float64)


def seen_by(homography: Points, points: Points) -> Points:
    """Carry points, shape (n, 2), by a homography."""
    there = carried(homography, points)
    return np.asarray(there[:, :2] / there[:, 2:], dtype=np.float64)


def draw_pose(rings: list[Points], rng: np.random.Generator, parameters: SynthParameters) -> Pose:
    """Draw a pose in which all of the cloth is seen.

    Parameters
    ----------
    rings : list of ndarray of shape (n, 2)
        The rings of all layers on the table, cm.
    rng : numpy.random.Generator
        Source of all randomness.
    parameters : SynthParameters
        ``image_size``, ``px_per_cm``, ``margin_cm``, ``mirrored`` and ``deformation_cm``.

    Raises
    ------
    ParameterError
        If the cloth fits into the picture in no direction.
    """
    points = np.vstack(rings)
    length = rng.uniform(*_WAVELENGTH_CM, _WAVES)
    direction = rng.uniform(0.0, 2 * np.pi, (2, _WAVES))
    size = parameters.deformation_cm * np.sqrt(2 / _WAVES)
    waves = (2 * np.pi / length * np.array([np.cos(direction[0]), np.sin(direction[0])])).T
    amplitudes = size * np.array([np.cos(direction[1]), np.sin(direction[1])]).T
    phases = rng.uniform(0.0, 2 * np.pi, _WAVES)
    flat = parameters.folds == 0
    face = np.diag([-1.0 if rng.random() < parameters.mirrored and not flat else 1.0, 1.0])
    turned = np.radians(parameters.flat_turn_deg)
    turns = (-turned, turned) if flat else (0.0, 2 * np.pi)
    room = np.array(parameters.image_size, dtype=np.float64) - 1
    margin = parameters.margin_cm * parameters.px_per_cm
    for _ in range(_TURNS):
        turn = rng.uniform(*turns)
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        pose = Pose(waves, amplitudes, phases, parameters.px_per_cm * rotation @ face, np.zeros(2))
        seen = pose.to_image(points)
        low, high = seen.min(axis=0) - margin, seen.max(axis=0) + margin
        if (high - low <= room).all():
            return Pose(waves, amplitudes, phases, pose.matrix, rng.uniform(-low, room - high))
    width, height = parameters.image_size
    raise ParameterError(
        f"At {parameters.px_per_cm:g} px/cm the garment does not fit into a picture of {width} x {height} "
        "px: lower px_per_cm or enlarge image_size."
    )
