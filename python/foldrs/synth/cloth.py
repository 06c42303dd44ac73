"""The cloth of a garment: colours, pattern, wrinkles and hem, on both faces.

Nothing here is measured, only plausible. The texture is drawn in the unfolded garment's frame, so that it
folds with the cloth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.synth.garment import Points
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.textures import Picture, bands, grain, rgb, smooth_noise, soft_step, tinted, turned_noise

TEXELS_PER_CM = 5.0
"""Resolution of the cloth's texture, a little finer than the picture."""

_COLOUR_TRIES = 200
"""Colours drawn before the best so far is taken."""

_HEM_CM = (1.2, 3.0)
"""Distance of the hem's seam from the rim."""

BORDER_CM = 3.0
"""Texture beyond the garment's bounding box, for rims that are displaced."""


@dataclass(frozen=True, eq=False)
class Cloth:
    """Both faces of a garment's cloth, in the unfolded garment's frame.

    Attributes
    ----------
    front, back : ndarray of shape (h, w, 3), uint8
        The outer and the inner face.
    origin : ndarray of shape (2,)
        Garment coordinates (cm) of the first texel.
    """

    front: NDArray[np.uint8]
    back: NDArray[np.uint8]
    origin: Points

    def texel(self, points: Points) -> Points:
        """Turn garment coordinates (cm) to coordinates of the texture."""
        return (points - self.origin) * TEXELS_PER_CM


def draw_cloth(
    outline: Points, table: Picture, rng: np.random.Generator, parameters: SynthParameters
) -> Cloth:
    """Draw cloth for a garment, whose colours stand out from the table.

    Parameters
    ----------
    outline : ndarray of shape (n, 2)
        The unfolded outline, cm.
    table : ndarray of shape (h, w, 3)
        The table it will lie on.
    rng : numpy.random.Generator
        Source of all randomness.
    parameters : SynthParameters
        ``cloths``, ``contrast`` and ``wrinkles``.
    """
    origin = outline.min(axis=0) - BORDER_CM
    width, height = np.ceil((outline.max(axis=0) + BORDER_CM - origin) * TEXELS_PER_CM).astype(int)
    size = (int(height), int(width))
    ground, second = _cloth_colours(rng, np.array(cv2.mean(table)[:3]), parameters.contrast)
    kind = str(rng.choice(np.array(parameters.cloths)))
    share = _CLOTHS[kind](rng, size)
    # Woven-in patterns show on the inner face too, printed ones hardly do.
    through = rng.uniform(0.6, 1.0) if kind in ("stripes", "checks", "denim") else rng.uniform(0.0, 0.3)
    shade = (parameters.wrinkles * _relief(rng, size) + np.float32(1.0)) * _hem(outline, origin, size, rng)
    faces = []
    tint = (rng.uniform(0.72, 1.06) + rng.normal(0.0, 0.02, 3)).astype(np.float32)
    for seen, colour in ((1.0, np.ones(3, np.float32)), (through, tint)):
        face = tinted(shade, ground * colour) + tinted(
            shade * share * np.float32(seen), (second - ground) * colour
        )
        faces.append(cv2.convertScaleAbs(np.maximum(face, 0, out=face)))
    return Cloth(faces[0], faces[1], origin)


def _relief(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    """Draw the shading by wrinkles: the slope, in raking light, of soft folds and a few sharper ones."""
    height = np.zeros(size, np.float32)
    for cell in (rng.uniform(3.0, 5.0), rng.uniform(9.0, 14.0)):
        long = cell * rng.uniform(1.5, 3.5)
        noise = turned_noise(rng, size, (cell * TEXELS_PER_CM, long * TEXELS_PER_CM), rng.uniform(0, np.pi))
        wave = noise if rng.random() < 0.5 else np.float32(1.0) - np.abs(noise)
        height = np.asarray(height + np.float32(cell) * wave, dtype=np.float32)
    lamp = rng.uniform(0, 2 * np.pi)
    x, y = math.cos(lamp), math.sin(lamp)
    slope = cv2.filter2D(height, -1, np.array([[0, -y, 0], [-x, 0, x], [0, y, 0]], np.float32))
    mean, deviation = (float(value[0, 0]) for value in cv2.meanStdDev(slope))
    return np.asarray(np.clip((slope - mean) / max(deviation, 1e-6), -2.5, 2.5), dtype=np.float32)


def _hem(outline: Points, origin: Points, size: tuple[int, int], rng: np.random.Generator) -> Picture:
    """Draw the brightness of a seam that runs along the rim."""
    inside = np.zeros(size, np.uint8)
    cv2.fillPoly(inside, [np.round((outline - origin) * TEXELS_PER_CM).astype(np.int32).reshape(-1, 1, 2)], 1)
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
    seam, depth = rng.uniform(*_HEM_CM) * TEXELS_PER_CM, rng.uniform(0.0, 0.22)
    line = np.exp(-(((distance - seam) / 1.2) ** 2))
    return np.asarray(1.0 - depth * line, dtype=np.float32)


def _cloth_colours(rng: np.random.Generator, table: Picture, contrast: float) -> tuple[Picture, Picture]:
    """Draw ground and pattern colour: the first far enough from the table, else the farthest."""

    def draw() -> Picture:
        if rng.random() < 0.25:
            return rgb(rng.random(), rng.uniform(0.0, 0.08), float(rng.choice([0.14, 0.25, 0.5, 0.75, 0.88])))
        return rgb(rng.random(), rng.uniform(0.2, 0.75), rng.uniform(0.22, 0.8))

    def first_far(least: float) -> Picture:
        best, most = draw(), -1.0
        for _ in range(_COLOUR_TRIES):
            colour = draw()
            distance = float(np.linalg.norm(cielab(colour) - cielab(table)))
            if distance >= least:
                return colour
            if distance > most:
                best, most = colour, distance
        return best

    return first_far(contrast), first_far(0.6 * contrast)


def cielab(colour: NDArray[np.floating]) -> Picture:
    """Turn an RGB colour, 0 to 255, to CIE L*, a*, b*."""
    pixel = (np.asarray(colour, np.float32) / np.float32(255)).reshape(1, 1, 3)
    return np.asarray(cv2.cvtColor(pixel, cv2.COLOR_RGB2Lab), dtype=np.float32).reshape(3)


def _texel_grid(size: tuple[int, int]) -> tuple[Picture, Picture]:
    """Return the coordinates y, shape (h, 1), and x, shape (1, w), of a cloth's texels, cm."""
    y, x = (np.arange(n, dtype=np.float32) / np.float32(TEXELS_PER_CM) for n in size)
    return y[:, None], x[None, :]


# Cloth patterns: the share of the second colour, 0 to 1, at every texel.


def _plain(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    return np.asarray(0.06 * grain(rng, size), dtype=np.float32)


def _stripes(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    y, x = _texel_grid(size)
    along = x if rng.random() < 0.4 else y
    return np.broadcast_to(bands(along, rng.uniform(2.0, 8.0), rng.uniform(0.2, 0.6)), size)


def _checks(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    y, x = _texel_grid(size)
    period, share = rng.uniform(2.5, 8.0), rng.uniform(0.25, 0.5)
    return np.asarray((bands(x, period, share) + bands(y, period, share)) / 2, dtype=np.float32)


def _dots(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    y, x = _texel_grid(size)
    period = rng.uniform(2.5, 6.0)
    radius = period * rng.uniform(0.15, 0.3)
    row = np.floor(y / period)
    dx = (x / period + 0.5 * (row % 2)) % 1.0 - 0.5
    dy = (y / period) % 1.0 - 0.5
    return soft_step(radius - period * np.hypot(dx, dy))


def _print(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    """Draw flowers or camouflage all over, or one large motif in the middle."""
    if rng.random() < 0.5:
        noise = smooth_noise(rng, size, rng.uniform(2.0, 5.0) * TEXELS_PER_CM)
        return soft_step((noise - np.float32(rng.uniform(0.0, 0.6))) * np.float32(2.0))
    y, x = _texel_grid(size)
    height, width = size[0] / TEXELS_PER_CM, size[1] / TEXELS_PER_CM
    across, down = (float(half) for half in min(width, height) * rng.uniform(0.12, 0.25, 2))
    middle = height * rng.uniform(0.4, 0.6)
    frame = np.minimum(across - np.abs(x - width / 2), down - np.abs(y - middle))
    blobs = smooth_noise(rng, size, rng.uniform(1.0, 2.5) * TEXELS_PER_CM)
    return soft_step(np.minimum(frame, np.float32(2.0) * (blobs + np.float32(0.3))))


def _denim(rng: np.random.Generator, size: tuple[int, int]) -> Picture:
    y, x = _texel_grid(size)
    twill = np.sin((x + y) * np.float32(8.0))
    threads = grain(rng, size)
    faded = smooth_noise(rng, size, 12 * TEXELS_PER_CM)
    return np.asarray(0.08 * twill + 0.10 * threads + 0.12 * faded + 0.1, dtype=np.float32)


_CLOTHS: dict[str, Callable[[np.random.Generator, tuple[int, int]], Picture]] = {
    "plain": _plain,
    "stripes": _stripes,
    "checks": _checks,
    "dots": _dots,
    "print": _print,
    "denim": _denim,
}
