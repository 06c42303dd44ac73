"""What textures are made of: noise, bands, colours. Pictures are float32, colours RGB from 0 to 255."""

from __future__ import annotations

import colorsys
import math

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.float32]

_SOFT_CM = 0.2
"""Width of a pattern's rims: about a pixel."""


def tinted(brightness: Picture, colour: Picture) -> Picture:
    """Return a colour at the brightness given for every pixel, shape (h, w, 3)."""
    return np.asarray(cv2.merge([brightness * np.float32(c) for c in colour]), dtype=np.float32)


def grain(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    """Draw independent values, mean 0 and standard deviation 1 (triangular, which is quick to draw)."""
    count = size[0] * size[1]
    first, second = np.frombuffer(rng.bytes(2 * count), np.uint8).reshape(2, *size)
    total = cv2.add(first, second, dtype=cv2.CV_32F)
    return np.asarray((total - np.float32(255)) / np.float32(104.5), dtype=np.float32)


def smooth_noise(
    rng: np.random.Generator, size: tuple[int, int], cell: float | tuple[float, float]
) -> Picture:
    """Draw smooth values, mean 0, standard deviation about 1, features of about ``cell`` (y, x) pixels."""
    cells = (cell, cell) if isinstance(cell, (int, float)) else cell
    rows, columns = (max(2, round(n / c) + 2) for n, c in zip(size, cells, strict=True))
    grid = rng.standard_normal((rows, columns), dtype=np.float32)
    # 1.5 makes up for what the interpolation between the grid's values takes away
    smooth = cv2.resize(grid, size[::-1], interpolation=cv2.INTER_CUBIC)
    return np.asarray(smooth * np.float32(1.5), dtype=np.float32)


def turned_noise(
    rng: np.random.Generator, size: tuple[int, int], cell: tuple[float, float], angle: float
) -> Picture:
    """Draw smooth noise with features drawn out along a direction (radians)."""
    reach = int(np.hypot(*size)) + 2
    noise = smooth_noise(rng, (reach, reach), cell)
    x, y, cos, sin = size[1] / 2, size[0] / 2, math.cos(angle), math.sin(angle)
    middle = reach / 2
    matrix = np.array(
        [[cos, sin, x - middle * (cos + sin)], [-sin, cos, y - middle * (cos - sin)]], dtype=np.float64
    )
    return np.asarray(cv2.warpAffine(noise, matrix, size[::-1], flags=cv2.INTER_LINEAR), dtype=np.float32)


def bands(along: Picture, period: float, share: float) -> Picture:
    """Return 1 within bands that take up a share of every period (cm); their rims are 2 mm soft."""
    phase = np.abs((along / np.float32(period)) % 1 - np.float32(0.5))
    return soft_step((np.float32(share / 2) - phase) * np.float32(period))


def soft_step(distance: NDArray[np.floating]) -> Picture:
    """Return 0 to 1 across a rim, from the distance to it in cm."""
    return np.asarray(np.clip(distance / _SOFT_CM + 0.5, 0.0, 1.0), dtype=np.float32)


def rgb(hue: float, saturation: float, value: float) -> Picture:
    """Return the colour of a hue, a saturation and a value, each 0 to 1."""
    return np.array([255 * part for part in colorsys.hsv_to_rgb(hue, saturation, value)], dtype=np.float32)
