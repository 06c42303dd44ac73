"""The part of a picture that is shown, and the photograph cut to it and made small enough to embed."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.image import RgbImage

Points = NDArray[np.float64]

_DETAIL = 0.2
"""Units of the view: outlines are drawn with no more corners than this deviation needs."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A view of `width` x `height` units on points of an image or a template."""

    width: int
    height: int
    origin: Points
    """(2,): the point shown in the upper left corner."""
    scale: float
    """Units of the view a px, or a template unit."""

    @staticmethod
    def around(points: Points, width: int, height: int, margin: float) -> Frame:
        """Show all (n, 2) points in the middle of a view, with a margin (share of its size) around them."""
        low, high = points.min(axis=0), points.max(axis=0)
        size = np.maximum(high - low, 1e-9)
        scale = float((np.array([width, height]) * (1 - 2 * margin) / size).min())
        origin = (low + high) / 2 - np.array([width, height]) / (2 * scale)
        return Frame(width, height, origin, scale)

    def view(self, points: Points) -> Points:
        """Carry points (..., 2) into the view."""
        carried: Points = (points - self.origin) * self.scale
        return carried

    def outline(self, points: Points) -> str:
        """Return a closed outline as the data of an SVG path."""
        seen = self.view(points)
        if len(seen) > 3:
            seen = _core.simplify(seen, _DETAIL)
        return _path(seen) + "z"

    def outlines(self, pieces: Sequence[Points]) -> str:
        """Return several closed outlines as the data of one SVG path."""
        return "".join(self.outline(piece) for piece in pieces)

    def line(self, points: Points) -> str:
        """Return an open line as the data of an SVG path."""
        return _path(self.view(points))


@dataclass(frozen=True)
class Photo:
    """A piece of a photograph, as a data URI, and where it lies in its view, in % of the view's size."""

    uri: str
    left: float
    top: float
    width: float
    height: float


def cut_photo(image: RgbImage, frame: Frame, quality: int) -> Photo | None:
    """Cut from a photograph what a frame shows, no larger than the frame; None if it shows none of it."""
    height, width = image.shape[:2]
    # An integer is the centre of a pixel: its upper left corner is half a pixel before it.
    low = np.clip(np.floor(frame.origin + 0.5).astype(int), 0, [width, height])
    far = frame.origin + np.array([frame.width, frame.height]) / frame.scale
    high = np.clip(np.ceil(far + 0.5).astype(int), 0, [width, height])
    if (low >= high).any():
        return None
    piece = np.ascontiguousarray(image[low[1] : high[1], low[0] : high[0]])
    if frame.scale < 1:
        size = np.maximum(np.rint((high - low) * frame.scale), 1).astype(int)
        piece = np.asarray(cv2.resize(piece, size.tolist(), interpolation=cv2.INTER_AREA), np.uint8)
    _, data = cv2.imencode(".webp", piece[:, :, ::-1], [cv2.IMWRITE_WEBP_QUALITY, quality])
    uri = "data:image/webp;base64," + base64.b64encode(data.tobytes()).decode()
    percent = 100 / np.array([frame.width, frame.height])
    left, top = (frame.view(low - 0.5) * percent).tolist()
    across, down = ((high - low) * frame.scale * percent).tolist()
    return Photo(uri, left, top, across, down)


def _path(points: Points) -> str:
    return "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
