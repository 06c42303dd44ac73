"""The layers' areas in the picture, drawn finer than its pixels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.synth.garment import Points

Mask = NDArray[np.uint8]

FINE = 4
"""Parts a pixel is divided into each way: rims are then right to an eighth of a pixel."""

_SHIFT = 4  # fractional bits of the corner points given to OpenCV


@dataclass(frozen=True, eq=False)
class LayerMasks:
    """Masks of all layers (255 = cloth), ``FINE`` times as fine as the picture, over a window of it.

    Attributes
    ----------
    layers : list of ndarray of shape (FINE * h, FINE * w), uint8
        One mask a layer, lowest first.
    left, top : int
        The window's first pixel.
    """

    layers: list[Mask]
    left: int
    top: int

    @property
    def window(self) -> tuple[slice, slice]:
        """The window, as an index into the picture."""
        height, width = self.layers[0].shape
        return slice(self.top, self.top + height // FINE), slice(self.left, self.left + width // FINE)

    def union(self) -> Mask:
        """Return what is covered by any layer, fine."""
        return np.asarray(np.bitwise_or.reduce(self.layers), dtype=np.uint8)

    def doubled(self) -> Mask:
        """Return what is covered by two layers or more, fine."""
        once, twice = self.layers[0].copy(), np.zeros_like(self.layers[0])
        for layer in self.layers[1:]:
            cv2.bitwise_or(twice, once & layer, dst=twice)
            cv2.bitwise_or(once, layer, dst=once)
        return twice

    def to_fine(self, points: Points) -> Points:
        """Turn picture coordinates (integer = centre of a pixel) to those of the fine masks."""
        return (points - (self.left, self.top) + 0.5) * FINE - 0.5

    def from_fine(self, points: Points) -> Points:
        """Turn coordinates of the fine masks to picture coordinates."""
        return (points + 0.5) / FINE - 0.5 + (self.left, self.top)


def draw_masks(rings: list[Points], image_size: tuple[int, int]) -> LayerMasks:
    """Draw the layers' rings (picture coordinates, lowest layer first)."""
    points = np.vstack(rings)
    room = np.array(image_size)
    low = np.clip(np.floor(points.min(axis=0)).astype(int) - 2, 0, room - 1)
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 3, low + 1, room)
    width, height = (high - low) * FINE
    empty = LayerMasks([np.zeros((height, width), np.uint8)], int(low[0]), int(low[1]))
    layers = []
    for ring in rings:
        mask = np.zeros((height, width), np.uint8)
        corners = np.round(empty.to_fine(ring) * (1 << _SHIFT)).astype(np.int32)
        cv2.fillPoly(mask, [corners.reshape(-1, 1, 2)], 255, shift=_SHIFT)
        layers.append(mask)
    return LayerMasks(layers, empty.left, empty.top)


def coverage(mask: Mask) -> NDArray[np.float32]:
    """Return the share of every pixel that a fine mask covers, 0 to 1."""
    height, width = mask.shape
    area = cv2.resize(mask, (width // FINE, height // FINE), interpolation=cv2.INTER_AREA)
    return np.asarray(area.astype(np.float32) / np.float32(255), dtype=np.float32)


def outlines(mask: Mask) -> list[Points]:
    """Trace a fine mask: its outer outlines and those of holes, largest first, in its own coordinates."""
    found, _ = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    return [
        np.asarray(c, dtype=np.float64).reshape(-1, 2)
        for c in sorted(found, key=cv2.contourArea, reverse=True)
    ]
