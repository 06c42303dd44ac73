"""The camera that pictures a scene: straight above the table, or looking at it at an angle."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.errors import ParameterError
from foldrs.synth.garment import Points
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.pose import seen_by
from foldrs.synth.textures import Picture

_FOCAL = 1.1
"""Focal length, longer sides of the picture: a field of view of 50 degrees, as common cameras have."""

_AIMS = np.linspace(0.0, 1.0, 5)
"""How far the camera is aimed away from the table's middle, towards the cloth's, until all cloth is seen."""

_DISTANCES = np.linspace(1.0, 1.5, 6)
"""How many times farther than the scale says it may be for that."""


@dataclass(frozen=True, eq=False)
class TableCamera:
    """A camera before the table. The table's frame is the view from straight above, in cm, z downwards.

    Attributes
    ----------
    matrix : ndarray of shape (3, 3)
        Intrinsic parameters, px.
    pose : ndarray of shape (4, 4)
        From the table's frame to the camera's, cm.
    px_per_cm : float
        Scale of the view from above.
    """

    matrix: Points
    pose: Points
    px_per_cm: float

    @property
    def table_to_image(self) -> Points:
        """Homography from table cm to px of the picture."""
        return np.asarray(self.matrix @ self.pose[:3, [0, 1, 3]])

    @property
    def from_above(self) -> Points:
        """Homography from px of the view from above to px of the picture."""
        return np.asarray(self.table_to_image @ np.diag([1 / self.px_per_cm, 1 / self.px_per_cm, 1.0]))

    def seen(self, table: Picture) -> Picture:
        """Picture a table top that was drawn from above; beyond what was drawn it goes on as in a mirror."""
        size = table.shape[1::-1]
        return np.asarray(
            cv2.warpPerspective(
                table, self.from_above, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101
            ),
            dtype=np.float32,
        )

    def depth_of_table(self, size: tuple[int, int]) -> tuple[NDArray[np.float64], float]:
        """Depth of the table at every pixel of a picture (width, height), and its distance; cm."""
        normal = self.pose[:3, 2]
        distance = float(normal @ self.pose[:3, 3])
        x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
        inverse = np.linalg.inv(self.matrix).T @ normal
        return distance / (inverse[0] * x + inverse[1] * y + inverse[2]), distance

    def written(self, size: tuple[int, int]) -> dict[str, object]:
        """Calibration as OpenCV names its fields, metres."""
        rotation, _ = cv2.Rodrigues(self.pose[:3, :3])
        return {
            "image_width": size[0],
            "image_height": size[1],
            "camera_matrix": self.matrix.tolist(),
            "distortion_coefficients": [0.0] * 5,
            "rvec": rotation.ravel().tolist(),
            "tvec": (self.pose[:3, 3] / 100).tolist(),
            "units": "m",
        }


def straight_above(parameters: SynthParameters) -> TableCamera:
    """Look straight down at the middle of the table."""
    return _looking(parameters, np.zeros(2), _middle(parameters), 1.0)


def draw_camera(points: Points, rng: np.random.Generator, parameters: SynthParameters) -> TableCamera:
    """Draw a camera, tilted by ``tilt_deg`` in a random direction, that sees all of the cloth.

    It looks at the middle of the table unless the cloth would be cut off, and from as far away as the scale
    says unless it must be farther.

    Parameters
    ----------
    points : ndarray of shape (n, 2)
        The cloth's rim in the view from above, px.
    rng : numpy.random.Generator
        Source of the direction.
    parameters : SynthParameters
        ``tilt_deg``, ``px_per_cm``, ``image_size`` and ``margin_cm``.

    Raises
    ------
    ParameterError
        The cloth is too large for the picture.
    """
    direction = rng.uniform(0.0, 2 * np.pi)
    tilt = np.radians(parameters.tilt_deg) * np.array([np.cos(direction), np.sin(direction)])
    middle, cloth = _middle(parameters), (points.min(axis=0) + points.max(axis=0)) / 2
    room = np.array(parameters.image_size) - 1
    for distance in _DISTANCES:
        for share in _AIMS:
            camera = _looking(parameters, tilt, middle + share * (cloth - middle), float(distance))
            seen = seen_by(camera.from_above, points)
            margin = parameters.margin_cm * parameters.px_per_cm
            if (seen >= margin).all() and (seen <= room - margin).all():
                return camera
    raise ParameterError(
        f"Tilted by {parameters.tilt_deg:g} degrees the garment does not fit into the picture: lower "
        "px_per_cm or enlarge image_size."
    )


def _looking(parameters: SynthParameters, tilt: Points, aim: Points, distance: float) -> TableCamera:
    """Turn a camera by a vector in the picture's plane (radians), its axis through a point of the view."""
    width, height = parameters.image_size
    scale = parameters.px_per_cm
    focal = _FOCAL * max(width, height)
    matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(np.append(tilt, 0.0))[0]
    pose[:3, 3] = [0.0, 0.0, distance * focal / scale] - pose[:3, :2] @ (aim / scale)
    return TableCamera(matrix, pose, scale)


def _middle(parameters: SynthParameters) -> Points:
    return (np.array(parameters.image_size, dtype=np.float64) - 1) / 2
