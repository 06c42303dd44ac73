"""What is seen inside the outline: edges and looks, the evidence of rims and regions (beyond the paper)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.looks import Looks, looks_of
from foldrs.parameters import PictureParameters


@dataclass(frozen=True, eq=False)
class Picture:
    """What is seen inside the outline."""

    edges: ColourEdges
    looks: Looks


def seen_inside(
    rgb: NDArray[np.uint8], outline: NDArray[np.float64], parameters: PictureParameters
) -> Picture:
    """Find edges and looks of the cloth in a photograph.

    Parameters
    ----------
    rgb : (h, w, 3) uint8 array
        The photograph.
    outline : (n, 2) array
        The seen outline, px.
    parameters : PictureParameters
        Sizes and blur, and how many looks.

    Returns
    -------
    Picture
    """
    return Picture(colour_edges(rgb, parameters), looks_of(rgb, outline, parameters))


@dataclass(frozen=True, eq=False)
class ColourEdges:
    """Where and in which direction the colours of a picture change, and the heights if they are known."""

    tensor: NDArray[np.float32]
    """(h, w, 3): structure tensor (xx, xy, yy) of the Lab colours of every pixel."""
    scale: float
    """Its pixels a pixel of the picture."""
    steps: NDArray[np.float32] | None = None
    """(h, w, 3): the same of the heights, if they are known."""


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


def with_heights(edges: ColourEdges, heights: NDArray[np.float32], blur: float) -> ColourEdges:
    """Add steps in height to the edges of colour: they show the rims of both layers.

    Parameters
    ----------
    edges : ColourEdges
        Of the picture.
    heights : (h, w) float32 array
        Heights above the table, pixel on pixel with the picture, in any unit.
    blur : float
        px of the edges' picture: Gaussian blur before the gradient.
    """
    size = edges.tensor.shape[1::-1]
    small = cv2.resize(heights, size, interpolation=cv2.INTER_AREA)
    smooth = np.asarray(cv2.GaussianBlur(small, (0, 0), blur), np.float32)
    return replace(edges, steps=_structure_tensor(smooth[:, :, None]))


def _structure_tensor(channels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Sum over channels, (h, w, c), of the products of their slopes: (h, w, 3)."""
    x = cv2.Scharr(channels, cv2.CV_32F, 1, 0).reshape(channels.shape)
    y = cv2.Scharr(channels, cv2.CV_32F, 0, 1).reshape(channels.shape)
    ones = np.ones((1, channels.shape[2]), np.float32)
    tensor = np.empty((*channels.shape[:2], 3), np.float32)
    for k, (a, b) in enumerate(((x, x), (x, y), (y, y))):
        cv2.insertChannel(cv2.transform(a * b, ones), tensor, k)
    return tensor
