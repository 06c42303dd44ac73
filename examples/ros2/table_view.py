"""From a camera's picture to the table seen from straight above, and to poses on the table. No ROS here.

Frames: the camera's is x right, y down, z forward; the table's has its z axis up from the cloth, its origin
and x and y axes wherever the robot has them. Metres, but for px: (x, y), y down, an integer is the centre of
a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

CHANNELS = {"mono8": 1, "rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4}
"""Encodings of `sensor_msgs/Image` that are understood, and their bytes a pixel."""


def picture_of(encoding: str, height: int, width: int, step: int, data: bytes) -> Picture:
    """Pixels (height, width, 3) in RGB of an image message; its rows may be padded to `step` bytes."""
    if encoding not in CHANNELS:
        raise ValueError(f"images of encoding {encoding} are not understood, only {', '.join(CHANNELS)}")
    channels = CHANNELS[encoding]
    rows = np.frombuffer(data, np.uint8).reshape(height, step)[:, : width * channels]
    pixels = rows.reshape(height, width, channels)
    if channels == 1:
        return np.repeat(pixels, 3, axis=2)
    return np.ascontiguousarray(pixels[..., 2::-1] if encoding.startswith("bgr") else pixels[..., :3])


def rotation_of(quaternion: tuple[float, float, float, float]) -> Floats:
    """Rotation matrix (3, 3) of a quaternion x, y, z, w."""
    x, y, z, w = np.asarray(quaternion) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@dataclass(frozen=True)
class TableView:
    """A window of the table, seen from straight above.

    Attributes
    ----------
    camera : (3, 3) array
        Camera matrix of the undistorted picture: P of `sensor_msgs/CameraInfo` without its last column.
    rotation, translation : (3, 3), (3,) arrays
        The table's frame in the camera's: x_camera = rotation x_table + translation.
    corner : (2,) array
        Least x and y of the window on the table.
    size : (2,) array
        Extent of the window along x and y.
    px_per_cm : float
        Resolution of the view; 4 tells a hem from a crease.
    """

    camera: Floats
    rotation: Floats
    translation: Floats
    corner: Floats
    size: Floats
    px_per_cm: float = 4.0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the view."""
        columns, rows = np.ceil(np.asarray(self.size) * 100 * self.px_per_cm).astype(int)
        return int(rows), int(columns)

    def to_table(self, pixels: Floats) -> Floats:
        """Points (n, 2) on the table of view px (n, 2): x to the right, y up in the view."""
        across, down = (np.asarray(pixels).T + 0.5) / (100 * self.px_per_cm)
        return np.stack([self.corner[0] + across, self.corner[1] + self.size[1] - down], axis=1)

    def to_camera_picture(self, pixels: Floats) -> Floats:
        """Camera px (n, 2) of view px (n, 2)."""
        table = self.to_table(pixels)
        seen = np.column_stack([table, np.zeros(len(table))]) @ self.rotation.T + self.translation
        if (seen[:, 2] <= 0).any():
            raise ValueError("a part of the window lies behind the camera: check the table's frame")
        projected = seen @ np.asarray(self.camera).T
        return np.asarray(projected[:, :2] / projected[:, 2:])

    def of(self, picture: Picture) -> Picture:
        """Draw the view from an undistorted picture of the camera."""
        rows, columns = self.shape
        corners = np.array([[0, 0], [columns - 1, 0], [columns - 1, rows - 1], [0, rows - 1]], float)
        seen = self.to_camera_picture(corners)
        homography = cv2.getPerspectiveTransform(seen.astype(np.float32), corners.astype(np.float32))
        view = cv2.warpPerspective(picture, homography, (columns, rows), flags=cv2.INTER_AREA)
        return np.asarray(view, dtype=np.uint8)


def grasp_pose(point: Floats, inwards: Floats) -> tuple[Floats, Floats]:
    """Pose of a gripper over a point of the table: position (3,) and quaternion (4,) as x, y, z, w.

    The gripper's z axis points down onto the table, its x axis along `inwards`, from the edge into the cloth.
    """
    angle = np.arctan2(inwards[1], inwards[0])
    # Half a turn about x points z down; then the turn about the table's z.
    return np.array([*point, 0.0]), np.array([np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0])
