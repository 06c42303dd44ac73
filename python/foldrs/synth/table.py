"""Table tops: plain, wood, checks and tiles, stone and carpet."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from foldrs.synth.parameters import SynthParameters
from foldrs.synth.textures import Picture, bands, rgb, smooth_noise, tinted, turned_noise


def draw_table(rng: np.random.Generator, parameters: SynthParameters) -> Picture:
    """Draw a table top that fills the picture."""
    width, height = parameters.image_size
    kind = str(rng.choice(np.array(parameters.tables)))
    base = _table_colour(rng, wooden=kind == "wood")
    relief = _TABLES[kind](rng, (height, width), parameters.px_per_cm)
    return tinted(relief + np.float32(1.0), base)


def _table_colour(rng: np.random.Generator, *, wooden: bool) -> Picture:
    """Draw mostly the colours of wood, stone and paint, now and then of a coloured table cloth."""
    if rng.random() < 0.75 or wooden:
        return rgb(rng.uniform(0.05, 0.14), rng.uniform(0.02, 0.3), rng.uniform(0.5, 0.92))
    return rgb(rng.random(), rng.uniform(0.3, 0.75), rng.uniform(0.35, 0.8))


# Tables: relative brightness at every pixel, 0 = the table's colour.


def _plain_table(rng: np.random.Generator, size: tuple[int, int], px_per_cm: float) -> Picture:
    relief = smooth_noise(rng, size, 40 * px_per_cm) * np.float32(rng.uniform(0.0, 0.03))
    return np.asarray(relief, dtype=np.float32)


def _wood(rng: np.random.Generator, size: tuple[int, int], px_per_cm: float) -> Picture:
    angle = float(rng.choice([0.0, math.pi / 2]) + rng.normal(0.0, 0.03))
    grain = turned_noise(rng, size, (0.5 * px_per_cm, 30 * px_per_cm), angle)
    rings = turned_noise(rng, size, (8 * px_per_cm, 60 * px_per_cm), angle)
    waves = np.sin(rings * np.float32(rng.uniform(4.0, 9.0)))
    depth = rng.uniform(0.4, 1.0)
    relief = depth * (0.03 * grain + 0.05 * waves)
    if rng.random() < 0.5:  # boards
        y, x = np.indices(size, dtype=np.float32) / np.float32(px_per_cm)
        across = math.cos(angle) * y + math.sin(angle) * x
        width = rng.uniform(9.0, 20.0)
        relief -= 0.25 * np.exp(-((((across + width / 2) % width - width / 2) / 0.25) ** 2))
    return np.asarray(relief, dtype=np.float32)


def _checked_table(rng: np.random.Generator, size: tuple[int, int], px_per_cm: float) -> Picture:
    """Draw a checked cloth, or tiles with joints."""
    y, x = np.indices(size, dtype=np.float32) / np.float32(px_per_cm)
    turn = rng.uniform(0.0, np.pi / 2)
    cos, sin = math.cos(turn), math.sin(turn)
    u, v = cos * x + sin * y, cos * y - sin * x
    if rng.random() < 0.5:
        period, depth = rng.uniform(6.0, 16.0), rng.uniform(0.03, 0.12)
        return np.asarray(-depth * (bands(u, period, 0.5) + bands(v, period, 0.5)), dtype=np.float32)
    period, joint = rng.uniform(10.0, 30.0), rng.uniform(0.02, 0.05)
    lines = np.maximum(bands(u, period, joint), bands(v, period, joint))
    return np.asarray(smooth_noise(rng, size, 10 * px_per_cm) * 0.02 - 0.25 * lines, dtype=np.float32)


def _noise_table(rng: np.random.Generator, size: tuple[int, int], px_per_cm: float) -> Picture:
    """Draw stone or carpet: speckles of several sizes."""
    relief = np.zeros(size, np.float32)
    for cell, depth in ((0.4, 0.04), (1.0, 0.04), (3.0, 0.025), (10.0, 0.015)):
        relief += smooth_noise(rng, size, cell * px_per_cm) * np.float32(rng.uniform(0.1, 1.0) * depth)
    return relief


_TABLES: dict[str, Callable[[np.random.Generator, tuple[int, int], float], Picture]] = {
    "plain": _plain_table,
    "wood": _wood,
    "checks": _checked_table,
    "noise": _noise_table,
}
