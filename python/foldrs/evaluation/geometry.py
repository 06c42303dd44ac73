"""Plane geometry of the measures, by shapely; outlines are (n, 2), closed implicitly, either winding."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import MultiPoint, Polygon

Points = NDArray[np.float64]

_COARSE_TURN = 6
"""Degrees between the first turns tried for the best rigid motion: garments have no narrower optimum."""
_FIRST_STEP, _LAST_STEP = 4.0, 0.4
"""Degrees and px: steps of its refinement, halved from the first while above the last."""
_GAIN = 1e-4
"""Overlap a step must gain."""
_RIM = 1.0
"""px: detail left out of outlines compared by rigid motion, for speed."""


def polygon(points: Points) -> Polygon:
    """Make a polygon of an outline; of one that crosses itself take the largest valid part."""
    shape = Polygon(points)
    if shape.is_valid:
        return shape
    parts = [part for part in shapely.get_parts(shape.buffer(0)) if isinstance(part, Polygon)]
    return max(parts, key=lambda part: part.area, default=Polygon())


def area(points: Points) -> float:
    """Area enclosed by an outline."""
    return float(polygon(points).area)


def iou(a: Points, b: Points) -> float:
    """Intersection over union of two outlines."""
    first, second = polygon(a), polygon(b)
    union = float(first.union(second).area)
    return float(first.intersection(second).area) / union if union > 0 else 0.0


def hull_share(axis: Points, true_axis: Points, whole: float) -> float:
    """dA: area of the convex hull of two axes' end points, as a share of the area `whole` (section 4.1).

    Examples
    --------
    A crease 40 cm long, found 1.5 cm beside where it is, on a towel of 60 by 40 cm:

    >>> true_axis = np.array([[30.0, 0.0], [30.0, 40.0]])
    >>> hull_share(true_axis + [1.5, 0.0], true_axis, whole=60 * 40)
    0.025
    """
    hull = float(MultiPoint(np.vstack([axis, true_axis])).convex_hull.area)
    return hull / whole if whole > 0 else float("inf")


def angle_between(axis: Points, other: Points) -> float:
    """dtheta: angle between two lines without direction, 0 to 90 degrees."""
    u, v = axis[1] - axis[0], other[1] - other[0]
    cosine = abs(float(u @ v)) / (float(np.linalg.norm(u) * np.linalg.norm(v)) + 1e-12)
    return float(np.degrees(np.arccos(min(1.0, cosine))))


def cut_to(axis: Points, true_axis: Points) -> Points | None:
    """Cut a line to the extent of a true axis, which it may run past; None if it has no direction."""
    along = axis[1] - axis[0]
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return None
    along = along / length
    reach = (true_axis - axis[0]) @ along
    return np.asarray(axis[0] + np.outer([reach.min(), reach.max()], along), dtype=np.float64)


def mirrored(points: Points, axis: Points) -> Points:
    """Mirror image of points over an axis's line."""
    along = (axis[1] - axis[0]) / np.linalg.norm(axis[1] - axis[0])
    foot = axis[0] + np.outer((points - axis[0]) @ along, along)
    return np.asarray(2 * foot - points, dtype=np.float64)


def similarity(before: Points, after: Points, *, reflecting: bool) -> Points:
    """Least-squares similarity (2, 3) of (n, 2) points onto (n, 2) others, proper or reflecting."""
    z, w = (points[:, 0] + 1j * points[:, 1] for points in (before, after))
    z = z.conj() if reflecting else z
    spread = z - z.mean()
    a = complex((spread.conj() @ (w - w.mean())) / max(float((abs(spread) ** 2).sum()), 1e-300))
    b = complex(w.mean() - a * z.mean())
    sign = -1.0 if reflecting else 1.0
    return np.array([[a.real, -sign * a.imag, b.real], [a.imag, sign * a.real, b.imag]])


def iou_by_rigid_motion(a: Points, b: Points) -> float:
    """Intersection over union of two outlines after the best rigid motion, either face up, no scaling.

    Centroids on each other, all turns in coarse steps, then steps uphill of ever smaller size.
    """
    still, moving = (_centred(polygon(points).simplify(_RIM)) for points in (a, b))
    faces = {face: affinity.scale(moving, face, 1.0, origin=(0, 0)) for face in (1.0, -1.0)}

    def overlap(face: float, pose: tuple[float, float, float]) -> float:
        turn, dx, dy = pose
        moved = affinity.translate(affinity.rotate(faces[face], turn, origin=(0, 0)), dx, dy)
        common = float(still.intersection(moved).area)
        union = float(still.area) + float(moved.area) - common
        return common / union if union > 0 else 0.0

    best, pose, face = max(
        (overlap(face, (turn, 0.0, 0.0)), (float(turn), 0.0, 0.0), face)
        for face in faces
        for turn in range(0, 360, _COARSE_TURN)
    )
    step = _FIRST_STEP
    while step > _LAST_STEP:
        moves = [tuple(p + step * d for p, d in zip(pose, way, strict=True)) for way in _WAYS]
        value, better = max((overlap(face, (t, x, y)), (t, x, y)) for t, x, y in moves)
        if value > best + _GAIN:
            best, pose = value, better
        else:
            step /= 2
    return best


_WAYS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))


def _centred(shape: Polygon) -> Polygon:
    middle = shape.centroid
    return affinity.translate(shape, -middle.x, -middle.y) if not shape.is_empty else shape
