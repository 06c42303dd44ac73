"""A sheet of white paper lying on the table."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from foldrs.camera.pinhole import Camera
from foldrs.errors import ParameterError, ScaleReferenceError
from foldrs.image import RgbImage
from foldrs.parameters import ScaleParameters
from foldrs.scale.paint import RIM_SIDE, filled_quads, widened
from foldrs.scale.reference import FoundReference
from foldrs.scale.solve import Solved, in_frame_of, plane_of_rectangles

Points = npt.NDArray[np.float64]

_SIDE = 1280
"""px: pictures with a longer side are made smaller to look for the sheet."""

_LEVELS = range(50, 98, 3)
"""Lightnesses at which the picture is thresholded: the one between sheet and table is not known."""

_SAME = 0.8
"""Two quadrilaterals that overlap this much (intersection over union) are one."""


@dataclass(frozen=True)
class Sheet:
    """A sheet of white paper, lying flat and whole in sight. The default is A4.

    The table's frame has its origin in the middle of the sheet, x along the long side towards the right of
    the picture (downwards, if the side is upright), and y to the left of x as seen, so that z comes out of
    the table.

    Parameters
    ----------
    short_cm, long_cm : float
        Lengths of its sides.

    Raises
    ------
    ParameterError
        They are not positive, or in the wrong order.
    """

    short_cm: float = 21.0
    long_cm: float = 29.7

    def __post_init__(self) -> None:
        if not (0 < self.short_cm <= self.long_cm < math.inf):
            raise ParameterError(
                f"The sheet's sides are {self.short_cm} and {self.long_cm} cm: give two positive lengths, "
                "the shorter first."
            )

    def find(self, rgb: RgbImage, camera: Camera | None, parameters: ScaleParameters) -> FoundReference:
        """Find the sheet in a photograph, and the table it lies on.

        Raises
        ------
        ScaleReferenceError
            Nothing is white, even, of four straight sides and of these proportions; or more than one thing.
        """
        size = (rgb.shape[1], rgb.shape[0])
        found: list[tuple[Points, Solved]] = []
        tried: list[Points] = []
        for quad in _white_quads(rgb, parameters):
            if any(_overlap(quad, other, rgb.shape[:2]) > _SAME for other in tried):
                continue
            tried.append(quad)
            sheet = self._solved(quad, size, camera, parameters)
            if sheet is not None:
                found.append(sheet)
        if not found:
            raise ScaleReferenceError(
                f"No white sheet of {self.short_cm:g} x {self.long_cm:g} cm is seen: lay one flat on a "
                "darker part of the table, whole and not touching the garment."
            )
        if len(found) > 1:
            places = ", ".join(f"({x:.0f}, {y:.0f})" for x, y in (quad.mean(axis=0) for quad, _ in found))
            raise ScaleReferenceError(
                f"{len(found)} things look like a sheet of {self.short_cm:g} x {self.long_cm:g} cm, at "
                f"{places} px: leave one of them, or use a marker."
            )
        quad, solved = found[0]
        covered = widened(filled_quads([quad], rgb.shape[:2]), parameters.rim * max(size) / RIM_SIDE)
        corners = solved.plane.to_table(quad)
        along = corners[1] - corners[0]
        plane = in_frame_of(solved.plane, corners.mean(axis=0), along, up=True)
        return FoundReference(plane, (quad,), covered)

    def _solved(
        self, quad: Points, size: tuple[int, int], camera: Camera | None, parameters: ScaleParameters
    ) -> tuple[Points, Solved] | None:
        """Take a quadrilateral for the sheet, long side first; its plane too, or None if it cannot be it."""
        turned = (quad, np.roll(quad, -1, axis=0))
        tried = [
            (one, plane_of_rectangles([one], [(self.long_cm, self.short_cm)], size, camera, parameters))
            for one in turned
        ]
        best, solved = min(tried, key=lambda one: one[1].worst + one[1].tilt / 10)
        limit = parameters.proportion * math.sqrt(cv2.contourArea(quad.astype(np.float32)))
        if solved.worst > limit or solved.tilt > parameters.most_tilt:
            return None
        side = best[1] - best[0]
        rightwards = side[0] > 0 if abs(side[0]) >= abs(side[1]) else side[1] > 0
        return (best if rightwards else np.roll(best, -2, axis=0)), solved


A4 = Sheet()
"""A sheet of A4."""


def _white_quads(rgb: RgbImage, parameters: ScaleParameters) -> Iterator[Points]:
    """Yield white, even quadrilaterals of straight sides, corners clockwise, px."""
    factor = min(1.0, _SIDE / max(rgb.shape[:2]))
    small = cv2.resize(rgb, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA) if factor < 1 else rgb
    sharp = cv2.cvtColor(small.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    lab = np.asarray(cv2.GaussianBlur(sharp, (0, 0), 1.0), dtype=np.float32)
    white = np.hypot(lab[:, :, 1], lab[:, :, 2]) < parameters.whiteness
    least = parameters.least_side * max(small.shape[:2])
    for level in _LEVELS:
        bright = (white & (lab[:, :, 0] > level)).astype(np.uint8)
        contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for contour in contours:
            quad = _quad_of(np.asarray(contour, np.int32), least, parameters)
            if quad is not None and _is_paper(lab, quad, parameters):
                quad = _placed(lab, quad, least, parameters)
                if quad is not None:
                    yield (quad + 0.5) / factor - 0.5


def _quad_of(contour: npt.NDArray[np.int32], least: float, parameters: ScaleParameters) -> Points | None:
    """Corners of a contour of four straight sides, where lines fitted to them meet; None if it has not."""
    if cv2.contourArea(contour) < least**2:
        return None
    rough = cv2.approxPolyDP(contour, 0.03 * cv2.arcLength(contour, True), True).reshape(-1, 2)
    if len(rough) != 4 or not cv2.isContourConvex(rough):
        return None
    if cv2.contourArea(rough.astype(np.float32), oriented=True) < 0:
        rough = rough[::-1]  # clockwise as seen, y being down
    points = contour.reshape(-1, 2).astype(np.float64)
    lines = []
    for a, b in zip(rough, np.roll(rough, -1, axis=0), strict=True):
        along = (b - a).astype(np.float64)
        length = float(np.hypot(*along))
        if length < least:
            return None
        along /= length
        share = (points - a) @ along / length
        off = (points - a) @ np.array([-along[1], along[0]])
        own = points[(share > 0.1) & (share < 0.9) & (np.abs(off) < 0.06 * length)]
        if len(own) < 0.5 * length:  # a diagonal has 0.57 pixels a px of its middle part
            return None
        middle = own.mean(axis=0)
        _, spread, directions = np.linalg.svd(own - middle, full_matrices=False)
        if spread[1] / math.sqrt(len(own)) > parameters.straight * length:
            return None
        lines.append((middle, directions[0]))
    corners = [_meeting(lines[k - 1], lines[k]) for k in range(4)]
    if any(corner is None for corner in corners):
        return None
    # A contour runs through the centres of the outermost pixels: the rim lies half a pixel further out.
    quad = np.array(corners)
    middle = quad.mean(axis=0)
    size = math.sqrt(cv2.contourArea(quad.astype(np.float32)))
    return np.asarray(middle + (quad - middle) * (1 + 1 / max(size, 1.0)))


def _placed(
    lab: npt.NDArray[np.float32], quad: Points, least: float, parameters: ScaleParameters
) -> Points | None:
    """Move a sheet's sides to where its colour turns into that around it; None if it has not four then."""
    shape = lab.shape[:2]
    inside = filled_quads([quad], shape, -0.15)
    near = filled_quads([quad], shape, 0.3)
    around = near & ~filled_quads([quad], shape, 0.15)
    paper, table = (np.median(lab[where], axis=0) for where in (inside, around))
    across = (paper - table) / float(np.square(paper - table).sum())
    sheet = near & ((lab - table) @ across > 0.5)
    contours, _ = cv2.findContours(sheet.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    largest = max(contours, key=cv2.contourArea, default=None)
    return None if largest is None else _quad_of(np.asarray(largest, np.int32), least, parameters)


def _meeting(line: tuple[Points, Points], other: tuple[Points, Points]) -> Points | None:
    """Where two lines, each a point and a direction, meet; None if they are nearly parallel."""
    (p, u), (q, v) = line, other
    across = u[0] * v[1] - u[1] * v[0]
    if abs(across) < 0.2:
        return None
    d = q - p
    return np.asarray(p + u * (d[0] * v[1] - d[1] * v[0]) / across)


def _is_paper(lab: npt.NDArray[np.float32], quad: Points, parameters: ScaleParameters) -> bool:
    """Whether a quadrilateral is white, even, and lighter than what lies around it."""
    shape = lab.shape[:2]
    inside = filled_quads([quad], shape, -0.15)
    around = filled_quads([quad], shape, 0.35) & ~filled_quads([quad], shape, 0.15)
    if not inside.any() or not around.any():
        return False
    light = lab[:, :, 0]
    paper = float(np.median(light[inside]))
    return (
        paper >= parameters.brightness
        and float(np.median(np.hypot(lab[:, :, 1], lab[:, :, 2])[inside])) < parameters.whiteness
        and float(np.std(light[inside])) <= parameters.evenness
        and paper - float(np.percentile(light[around], 75)) >= parameters.step
    )


def _overlap(quad: Points, other: Points, shape: tuple[int, int]) -> float:
    """Intersection over union of two quadrilaterals."""
    a, b = filled_quads([quad], shape), filled_quads([other], shape)
    return float(np.count_nonzero(a & b)) / max(1.0, float(np.count_nonzero(a | b)))
