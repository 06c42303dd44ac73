"""The pixels of a scene: cloth upon the table, shadows, lamp and camera."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.synth.camera import TableCamera
from foldrs.synth.cloth import Cloth, draw_cloth
from foldrs.synth.garment import Garment, Photograph
from foldrs.synth.layers import Layer
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.photographs import cut_out
from foldrs.synth.pose import Pose
from foldrs.synth.raster import LayerMasks, coverage
from foldrs.synth.references import lay_references
from foldrs.synth.table import draw_table
from foldrs.synth.textures import Picture, grain, tinted

_CELL_PX = 8
"""Spacing of the grid on which the way from picture to cloth is computed; it bends over centimetres."""

_ROUND_CM = 0.35
"""Width of the darker rim where the cloth's edge turns away from the light."""

_SHADOW_CM = 0.6
"""Blur of the shadows: cloth is millimetres thick, and the lamp is wide."""

_SOFTNESS_PX = 0.6
"""Blur of the camera."""

_WHITE = np.ones(3, np.float32)


def render(
    garment: Garment,
    layers: list[Layer],
    pose: Pose,
    masks: LayerMasks,
    rng: np.random.Generator,
    parameters: SynthParameters,
    camera: TableCamera,
    aside: np.random.Generator,
    tables: Sequence[Photograph] = (),
) -> NDArray[np.uint8]:
    """Picture folded cloth on a table.

    Parameters
    ----------
    garment : Garment
        What is folded. If it has a photograph, its cloth is cut out of that, else cloth and table are drawn.
    layers : list of Layer
        The layers, lowest first.
    pose : Pose
        How they lie in the picture.
    masks : LayerMasks
        Their areas in the picture.
    rng : numpy.random.Generator
        Source of all randomness.
    parameters : SynthParameters
        Textures, light and camera.
    camera : TableCamera
        What looks at it.
    aside : numpy.random.Generator
        Source of what else lies there, apart so that the rest is the same without it.
    tables : sequence of Photograph, optional
        Those whose tables such a garment may lie on; by default its own.

    Returns
    -------
    ndarray of shape (height, width, 3), uint8
        RGB.
    """
    photograph = garment.photograph
    if photograph is None:
        picture = draw_table(rng, parameters)
        cloth = draw_cloth(garment.outline, picture, rng, parameters)
    else:
        picture, cloth = cut_out(photograph, tables or [photograph], garment.outline, rng, parameters)
    if parameters.tilt_deg > 0:
        picture = camera.seen(picture)
    if parameters.marker_cm or parameters.sheet:
        covered = np.zeros(picture.shape[:2], np.bool_)
        covered[masks.window] = coverage(masks.union()) > 0
        lay_references(picture, covered, camera, aside, parameters)
    lamp = rng.uniform(0.0, 2 * np.pi)
    shadow = parameters.shadow * rng.uniform(0.5, 1.0)
    picture_window = _padded(masks, parameters)
    part = picture[picture_window]
    rows, columns = masks.window
    inner = (
        slice(rows.start - picture_window[0].start, rows.stop - picture_window[0].start),
        slice(columns.start - picture_window[1].start, columns.stop - picture_window[1].start),
    )
    for layer, mask in zip(layers, masks.layers, strict=True):
        cover = np.zeros(part.shape[:2], np.float32)
        cover[inner] = coverage(mask)
        part *= tinted(1.0 - shadow * _shadow(cover, lamp, parameters.px_per_cm), _WHITE)
        colour = _seen(cloth, layer, pose, masks)
        colour *= tinted(_rounding(cover, parameters.px_per_cm)[inner], _WHITE)
        part[inner] += tinted(cover[inner], _WHITE) * (colour - part[inner])
    return _photographed(picture, lamp, rng, parameters)


def _padded(masks: LayerMasks, parameters: SynthParameters) -> tuple[slice, slice]:
    """Return the window of the cloth and of the shadow around it."""
    pad = int(np.ceil(4 * _SHADOW_CM * parameters.px_per_cm))
    rows, columns = masks.window
    width, height = parameters.image_size
    return (
        slice(max(0, rows.start - pad), min(height, rows.stop + pad)),
        slice(max(0, columns.start - pad), min(width, columns.stop + pad)),
    )


def _shadow(cover: Picture, lamp: float, px_per_cm: float) -> Picture:
    """Return the share of light that a layer takes from what lies below it, more on the side off the lamp."""
    reach = _SHADOW_CM * px_per_cm
    move = np.array([[1.0, 0.0, -0.5 * reach * math.cos(lamp)], [0.0, 1.0, -0.5 * reach * math.sin(lamp)]])
    fallen = cv2.warpAffine(cover, move, cover.shape[::-1], flags=cv2.INTER_LINEAR)
    return np.asarray(cv2.GaussianBlur(fallen, (0, 0), reach), dtype=np.float32)


def _rounding(cover: Picture, px_per_cm: float) -> Picture:
    """Return the brightness of a layer that is rounded at its rim and its crease."""
    near_rim = 1.0 - cv2.GaussianBlur(cover, (0, 0), _ROUND_CM * px_per_cm)
    return np.asarray(1.0 - 0.35 * near_rim, dtype=np.float32)


def _seen(cloth: Cloth, layer: Layer, pose: Pose, masks: LayerMasks) -> Picture:
    """Return the face of the cloth that a layer shows, over the window of the masks."""
    rows, columns = masks.window
    height, width = rows.stop - rows.start, columns.stop - columns.start
    # Grid points are the centres of cells; a cell more on each side keeps the interpolation exact within.
    y = (np.arange(-1, -(-height // _CELL_PX) + 1) + 0.5) * _CELL_PX - 0.5
    x = (np.arange(-1, -(-width // _CELL_PX) + 1) + 0.5) * _CELL_PX - 0.5
    grid = np.stack(np.meshgrid(x + columns.start, y + rows.start), axis=-1)
    texels = cloth.texel(layer.unplace(pose.to_table(grid.reshape(-1, 2)))).reshape(grid.shape)
    fine = (len(x) * _CELL_PX, len(y) * _CELL_PX)
    way = cv2.resize(texels.astype(np.float32), fine, interpolation=cv2.INTER_LINEAR)
    way = way[_CELL_PX : _CELL_PX + height, _CELL_PX : _CELL_PX + width]
    turned_over = (len(layer.turns) + pose.mirrored) % 2 == 1
    face = cloth.back if turned_over else cloth.front
    seen = cv2.remap(face, way[..., 0], way[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(seen, dtype=np.float32)


def _photographed(
    picture: Picture, lamp: float, rng: np.random.Generator, parameters: SynthParameters
) -> NDArray[np.uint8]:
    """Light the whole scene, and return what the camera makes of it."""
    width, height = parameters.image_size
    x = np.linspace(-1.0, 1.0, width, dtype=np.float32)
    y = np.linspace(-1.0, 1.0, height, dtype=np.float32)[:, None]
    slope = parameters.light * rng.uniform(0.0, 1.0) / math.sqrt(2)
    corner = parameters.vignette * rng.uniform(0.0, 1.0) / 2
    gain = (1.0 - slope * (math.cos(lamp) * x + math.sin(lamp) * y)) * (1.0 - corner * (x**2 + y**2))
    warm = rng.normal(0.0, parameters.warmth)
    colour = np.array([1.0 + warm, 1.0, 1.0 - warm], np.float32) * np.float32(rng.uniform(0.9, 1.08))
    lit = cv2.GaussianBlur(picture * tinted(gain, colour), (0, 0), _SOFTNESS_PX)
    if parameters.noise:
        lit = cv2.add(lit, tinted(grain(rng, (height, width)), _WHITE * np.float32(parameters.noise)))
    return np.asarray(cv2.convertScaleAbs(np.maximum(lit, 0)), dtype=np.uint8)  # rounds, and cuts at 255
