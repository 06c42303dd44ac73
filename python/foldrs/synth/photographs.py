"""Real cloth upon real tables: both cut out of photographs of garments that lie flat.

What is drawn (:mod:`~foldrs.synth.cloth`, :mod:`~foldrs.synth.table`) is our own invention; this
is not. The cloth's inner face is unknown, and shown as a darker outer one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.errors import ParameterError
from foldrs.image import RgbImage, read_image
from foldrs.synth.cloth import BORDER_CM, TEXELS_PER_CM, Cloth, cielab
from foldrs.synth.garment import Photograph, Points
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.table import draw_table
from foldrs.synth.textures import Picture

_RIM_PX = 2
"""Pixels within the traced outline that may still be table, or a mixture."""

_NEAR_PX = 12
"""Pixels around the garment that may be its shadow, or an outline traced roughly."""

_INNER_FACE = (0.82, 1.0)
"""Brightness of the inner face, as a share of the outer one's."""

_TABLE_SHARE = 0.12
"""Least width of a strip of table, as a share of the picture's shorter side."""

_EVEN = (8.5, 6.0)
"""Most variation of a table's brightness and colours (standard deviation, CIE 1976): beyond it are things."""

_TABLE_CM = (30.0, 60.0)
"""Real width of what such a strip shows: photographs of garments show little more than these."""

_TABLE_TRIES = 60
"""Photographs looked at, or tables drawn, before the one that stands out most is taken."""


def cut_out(
    photograph: Photograph,
    tables: Sequence[Photograph],
    outline: Points,
    rng: np.random.Generator,
    parameters: SynthParameters,
) -> tuple[Picture, Cloth]:
    """Cut a garment's cloth out of a photograph, and a table that it stands out from out of another.

    Parameters
    ----------
    photograph : Photograph
        Where the cloth is seen. Its garment's bounding box becomes that of the outline.
    tables : sequence of Photograph
        The tables to choose from. If none of them shows enough table, one is drawn.
    outline : ndarray of shape (n, 2)
        The unfolded outline, cm. What of it lies beyond the cloth shows the nearest cloth.
    rng : numpy.random.Generator
        Source of all randomness.
    parameters : SynthParameters
        ``image_size``, ``px_per_cm`` and ``contrast``.

    Returns
    -------
    tuple of Picture and Cloth
        The table, which fills the picture and is mirrored where the strip seen of it ends; and the cloth.

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        As :func:`foldrs.image.read_image`.
    ParameterError
        If the outline encloses nothing in the photograph.
    """
    picture = read_image(photograph.path)
    inner = _inner(photograph, picture)
    table = _lay_table(tables, picture[inner > 0].reshape(-1, 3).mean(axis=0), rng, parameters)
    return table, _cut_cloth(_with_cloth_beyond(picture, inner), photograph.outline, outline, rng)


def _cut_cloth(seen: RgbImage, traced: Points, outline: Points, rng: np.random.Generator) -> Cloth:
    """Take the cloth over the bounding box of an outline (cm) from that of the traced one (px)."""
    origin = outline.min(axis=0) - BORDER_CM
    width, height = np.ceil((outline.max(axis=0) + BORDER_CM - origin) * TEXELS_PER_CM).astype(int)
    px_per_cm = np.ptp(traced, axis=0) / np.ptp(outline, axis=0)
    step = px_per_cm / TEXELS_PER_CM
    if step.max() > 1:  # finer than the texture: what it cannot show is blurred away first
        seen = np.asarray(cv2.GaussianBlur(seen, (0, 0), 0.4 * float(step.max())), np.uint8)
    corner = traced.min(axis=0) - BORDER_CM * px_per_cm
    way = np.array([[step[0], 0.0, corner[0]], [0.0, step[1], corner[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    front = cv2.warpAffine(seen, way, (int(width), int(height)), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    back = cv2.convertScaleAbs(front, alpha=rng.uniform(*_INNER_FACE))
    return Cloth(np.asarray(front, np.uint8), np.asarray(back, np.uint8), origin)


def _lay_table(
    photographs: Sequence[Photograph],
    cloth: NDArray[np.floating],
    rng: np.random.Generator,
    parameters: SynthParameters,
) -> Picture:
    """Fill a picture with a table that stands out from the mean colour of the cloth."""
    looked_at = (photographs[k] for k in rng.permutation(len(photographs))[:_TABLE_TRIES])
    strips = (strip for strip in map(_table_beside, looked_at) if strip is not None)
    first = next(strips, None)
    tables = (
        (draw_table(rng, parameters) for _ in range(_TABLE_TRIES))
        if first is None
        else (_tiled(strip, rng, parameters) for strip in chain([first], strips))
    )
    return _standing_out(tables, cloth, parameters.contrast)


def _standing_out(tables: Iterator[Picture], cloth: NDArray[np.floating], enough: float) -> Picture:
    """Return the first table whose mean colour is far enough from the cloth's, else the farthest."""
    best, most = next(tables), -math.inf
    for table in chain([best], tables):
        contrast = float(np.linalg.norm(cielab(np.array(cv2.mean(table)[:3])) - cielab(cloth)))
        if contrast > most:
            best, most = table, contrast
        if contrast >= enough:
            break
    return best


def _inner(photograph: Photograph, picture: RgbImage) -> NDArray[np.uint8]:
    """Return 1 where a photograph surely shows cloth, else 0."""
    mask = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillPoly(mask, [np.round(photograph.outline).astype(np.int32).reshape(-1, 1, 2)], 1)
    size = 2 * _RIM_PX + 1
    inner = np.asarray(cv2.erode(mask, np.ones((size, size), np.uint8)), np.uint8)
    if not inner.any():
        raise ParameterError(
            f"{photograph.path}: the garment's outline encloses nothing in this photograph; give the "
            "photograph that it was traced in, at the same size."
        )
    return inner


def _with_cloth_beyond(picture: RgbImage, cloth: NDArray[np.uint8]) -> RgbImage:
    """Replace what is not cloth by the nearest cloth."""
    _, nearest = cv2.distanceTransformWithLabels(1 - cloth, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    colours = np.zeros((int(nearest.max()) + 1, 3), np.uint8)
    colours[nearest[cloth > 0]] = picture[cloth > 0]
    return np.asarray(colours[nearest], np.uint8)


def _table_beside(photograph: Photograph) -> RgbImage | None:
    """Return the largest strip beside the garment; None if it is small, or no even table."""
    picture = read_image(photograph.path)
    height, width = picture.shape[:2]
    (left, top), (right, bottom) = (
        np.clip(np.round(end).astype(int), 0, (width, height))
        for end in (photograph.outline.min(axis=0) - _NEAR_PX, photograph.outline.max(axis=0) + _NEAR_PX)
    )
    strips = (picture[:top], picture[bottom:], picture[:, :left], picture[:, right:])
    widest = max(strips, key=lambda strip: (min(strip.shape[:2]), max(strip.shape[:2])))
    if min(widest.shape[:2]) < max(2.0, _TABLE_SHARE * min(height, width)):
        return None
    spread = cv2.cvtColor(widest.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2Lab).std(axis=(0, 1))
    if spread[0] > _EVEN[0] or spread[1:].max() > _EVEN[1]:
        return None
    return widest


def _tiled(table: RgbImage, rng: np.random.Generator, parameters: SynthParameters) -> Picture:
    """Fill a picture with a strip of table and its mirror images, some of it, turned or not."""
    width, height = parameters.image_size
    grown = rng.uniform(*_TABLE_CM) * parameters.px_per_cm / min(table.shape[:2])
    size = (max(2, round(table.shape[1] * grown)), max(2, round(table.shape[0] * grown)))
    way = cv2.INTER_AREA if grown < 1 else cv2.INTER_LINEAR
    tile = np.asarray(cv2.resize(table, size, interpolation=way))
    if rng.random() < 0.5:
        tile = tile.transpose(1, 0, 2)
    row = np.hstack([tile, tile[:, ::-1]] * (math.ceil(width / tile.shape[1] / 2) + 1))
    whole = np.vstack([row, row[::-1]] * (math.ceil(height / tile.shape[0] / 2) + 1))
    top = rng.integers(whole.shape[0] - height + 1)
    left = rng.integers(whole.shape[1] - width + 1)
    return np.asarray(whole[top : top + height, left : left + width], dtype=np.float32)
