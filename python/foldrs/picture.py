"""Edges of colour and height, for the evidence of rims seen inside the outline (beyond the paper)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.parameters import PictureParameters


@dataclass(frozen=True, eq=False)
class ColourEdges:
    """Where and in which direction the colours of a picture change, and the heights if they are known."""

    tensor: NDArray[np.float32]
    """(h, w, 3): structure tensor (xx, xy, yy) of every pixel: of its Lab colours, or of colours and height,
    each measured by what is usual within the garment."""
    scale: float
    """Its pixels a pixel of the picture."""


def colour_edges(rgb: NDArray[np.uint8], parameters: PictureParameters) -> ColourEdges:
    """Structure tensor of all colours at once (Di Zenzo 1986), of a picture no larger than it need be.

    Parameters
    ----------
    rgb : (h, w, 3) uint8 array
        The photograph.
    parameters : PictureParameters
        Size and blur.

    Returns
    -------
    ColourEdges
    """
    scale = min(1.0, parameters.longest / max(rgb.shape[:2]))
    if scale < 1.0:
        shrunk = cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        rgb = np.asarray(shrunk, np.uint8)
    lab = cv2.cvtColor(rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2Lab)
    lab = cv2.GaussianBlur(lab, (0, 0), parameters.blur)
    return ColourEdges(_structure_tensor(lab), scale)


def with_heights(
    edges: ColourEdges, heights: NDArray[np.float32], outline: NDArray[np.float64], weight: float
) -> ColourEdges:
    """Add steps in height to the edges of colour: the rim of a layer on top is both.

    Parameters
    ----------
    edges : ColourEdges
        Of the picture.
    heights : (h, w) float32 array
        Heights above the table, pixel on pixel with the picture, in any unit.
    outline : (n, 2) array
        The garment's outline, px of the picture. What is usual within it is what both are measured by: a
        strong print says little by its colours, and then the height decides.
    weight : float
        Of the heights beside the colours.
    """
    size = edges.tensor.shape[1::-1]
    small = np.asarray(cv2.resize(heights, size, interpolation=cv2.INTER_AREA), np.float32)
    tensor = _structure_tensor(small[:, :, None])
    cloth = np.zeros(size[::-1], np.uint8)
    corners = np.round((outline + 0.5) * edges.scale - 0.5).astype(np.int32)
    cv2.fillPoly(cloth, [corners.reshape(-1, 1, 2)], 1)
    both = _usual(edges.tensor, cloth > 0) + weight * _usual(tensor, cloth > 0)
    return ColourEdges(np.ascontiguousarray(both, dtype=np.float32), edges.scale)


def _structure_tensor(channels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Sum over channels, (h, w, c), of the products of their slopes: (h, w, 3)."""
    x = cv2.Scharr(channels, cv2.CV_32F, 1, 0).reshape(channels.shape)
    y = cv2.Scharr(channels, cv2.CV_32F, 0, 1).reshape(channels.shape)
    tensor = np.stack([(x * x).sum(axis=2), (x * y).sum(axis=2), (y * y).sum(axis=2)], axis=2)
    return np.ascontiguousarray(tensor, dtype=np.float32)


def _usual(tensor: NDArray[np.float32], cloth: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Measure a tensor by its median strength within the cloth."""
    strength = (tensor[:, :, 0] + tensor[:, :, 2])[cloth]
    median = float(np.median(strength)) if strength.size else 0.0
    return np.asarray(tensor / np.float32(median + 1e-6), dtype=np.float32)
