"""The plane on which rectangles of known size lie, seen by a camera that may be unknown.

An unknown camera has square pixels, its principal point in the middle of the picture and no distortion.
Unknown are then its focal length, the tilt of the plane and the scale, and of every rectangle how it lies on
the plane. One rectangle determines the tilt poorly, several spread over the table well: expectations of focal
length and tilt are therefore part of the least squares, and the corners outvote them as far as they can.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from foldrs.camera._matrices import carried, inverse
from foldrs.camera.pinhole import Camera
from foldrs.camera.plane import TablePlane
from foldrs.camera.pose import Pose
from foldrs.errors import CalibrationError
from foldrs.parameters import ScaleParameters

Points = npt.NDArray[np.float64]

_START_TILT = 0.45
"""Radians: tilt of the starts, in eight directions and none; a small rectangle leaves two minima."""

_DIRECTIONS = 8

_EVALUATIONS = 40
"""At most so many a start: what has not settled then is no rectangle of that size."""


@dataclass(frozen=True, eq=False)
class Solved:
    """A plane, and how well the rectangles lie on it."""

    plane: TablePlane
    """Its frame is turned as the picture is, y down; the origin is where the camera's axis meets it."""
    tilt: float
    """Degrees between the camera's axis and the plane's normal."""
    worst: float
    """px: largest distance of a corner from where it should be."""


def plane_of_rectangles(
    corners: Sequence[Points],
    sizes: Sequence[tuple[float, float]],
    image_size: tuple[int, int],
    camera: Camera | None,
    parameters: ScaleParameters,
) -> Solved:
    """Find the plane.

    Parameters
    ----------
    corners : sequence of (4, 2) arrays
        Corners in the photograph, px, clockwise as seen.
    sizes : sequence of (width, height)
        cm: lengths of the first side (from the first corner to the second) and of the next.
    image_size : (width, height)
        px.
    camera : Camera, optional
        Known intrinsic parameters.
    parameters : ScaleParameters
    """
    from scipy.optimize import least_squares  # slow to import, and needed here alone

    ideal = [quad if camera is None else camera.undistorted(quad) for quad in corners]
    rectangles = [_rectangle(*size) for size in sizes]
    width, height = image_size
    focal = parameters.focal * max(width, height) if camera is None else float(camera.matrix[0, 0])
    scale = math.sqrt(sum(map(_area, ideal)) / sum(w * h for w, h in sizes))

    def matrix(log_focal: float) -> Points:
        if camera is not None:
            return camera.matrix
        f = focal * math.exp(log_focal)
        return np.array([[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1]])

    def to_image(unknown: Points) -> Points:
        """Homography from table cm to ideal px."""
        x, y, log_focal, log_scale = unknown
        intrinsic = matrix(log_focal)
        turn = Pose.of_vectors([x, y, 0.0], np.zeros(3)).matrix[:3, :3]
        distance = intrinsic[0, 0] / (scale * math.exp(log_scale))
        return np.asarray(intrinsic @ np.column_stack([turn[:, 0], turn[:, 1], [0.0, 0.0, distance]]))

    def off(unknown: Points) -> Points:
        """Distances of all corners from where rectangles of that size have them, px."""
        there = to_image(unknown)
        back = inverse(there)
        return np.concatenate(
            [
                _apply(there, _laid(rectangle, _apply(back, quad))) - quad
                for quad, rectangle in zip(ideal, rectangles, strict=True)
            ]
        )

    def residuals(unknown: Points) -> Points:
        spreads = np.array([parameters.tilt_spread, parameters.tilt_spread, parameters.focal_spread])
        return np.concatenate([off(unknown).ravel() / parameters.corner_noise, unknown[:3] / spreads])

    angles = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
    starts = [np.zeros(4), *(np.array([np.cos(a), np.sin(a), 0, 0]) * _START_TILT for a in angles)]
    fits = (least_squares(residuals, start, x_scale=0.1, max_nfev=_EVALUATIONS) for start in starts)
    best = min(fits, key=lambda fit: fit.cost)
    homography = inverse(to_image(best.x))
    return Solved(
        plane=TablePlane(homography, camera),
        tilt=math.degrees(float(np.hypot(*best.x[:2]))),
        worst=float(np.linalg.norm(off(best.x), axis=1).max()),
    )


def in_frame_of(plane: TablePlane, origin: Points, along: Points, *, up: bool) -> TablePlane:
    """Give a plane another frame: its origin, and the direction of x, in the old one, cm.

    With `up`, y runs to the left of x as seen, so that z comes out of the table; otherwise to its right.
    """
    x = along / np.linalg.norm(along)
    y = np.array([x[1], -x[0]]) if up else np.array([-x[1], x[0]])
    turn = np.eye(3)
    turn[:2, :2] = [x, y]
    turn[:2, 2] = -turn[:2, :2] @ origin
    return TablePlane(turn @ plane.homography, plane.camera)


def _rectangle(width: float, height: float) -> Points:
    return np.array([[-width, -height], [width, -height], [width, height], [-width, height]]) / 2


def _laid(rectangle: Points, points: Points) -> Points:
    """Lay a rectangle (centred) on four points by the rigid motion that fits best."""
    z, w = (p[:, 0] + 1j * p[:, 1] for p in (rectangle, points))
    middle = w.mean()
    turn = np.vdot(z, w - middle)
    laid = middle + z * turn / max(abs(turn), 1e-300)
    return np.column_stack([laid.real, laid.imag])


def _apply(homography: Points, points: Points) -> Points:
    """Apply a homography; points at its horizon go far away, and stay finite, while the best is sought."""
    there = carried(homography, points)
    depth = np.where(np.abs(there[:, 2]) < 1e-9, 1e-9, there[:, 2])
    return np.asarray(np.clip(there[:, :2] / depth[:, None], -1e6, 1e6))


def _area(quad: Points) -> float:
    (x, y), (x1, y1) = quad.T, np.roll(quad, -1, axis=0).T
    area = abs(float((x * y1 - x1 * y).sum())) / 2
    if area == 0:
        raise CalibrationError("The corners of a marker lie on one line: take another photograph.")
    return area
