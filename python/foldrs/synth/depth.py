"""The depth image of a scene: thin layers of cloth on a table, and a sensor's noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.synth.camera import TableCamera
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.raster import LayerMasks, coverage
from foldrs.synth.textures import smooth_noise

_ROUND_CM = 0.3
"""Blur of a layer's rim: cloth rolls off, and a sensor smooths."""

_RELIEF_CM = 8.0
"""Size of the cloth's bulges."""


def draw_depth(
    masks: LayerMasks, camera: TableCamera, rng: np.random.Generator, parameters: SynthParameters
) -> NDArray[np.float32]:
    """Measure a scene's depth.

    Parameters
    ----------
    masks : LayerMasks
        The layers' areas in the picture.
    camera : TableCamera
    rng : numpy.random.Generator
        Source of thickness, bulges and noise.
    parameters : SynthParameters
        ``thickness_cm``, ``bulge_cm`` and ``depth_noise_cm``.

    Returns
    -------
    ndarray of shape (height, width), float32
        Metres along the camera's axis.
    """
    width, height = parameters.image_size
    scale = parameters.px_per_cm
    layers = np.zeros((height, width), np.float32)
    for mask in masks.layers:
        layers[masks.window] += coverage(mask)
    layers = np.asarray(cv2.GaussianBlur(layers, (0, 0), _ROUND_CM * scale), dtype=np.float32)
    bulge = np.abs(smooth_noise(rng, (height, width), _RELIEF_CM * scale)) * np.float32(parameters.bulge_cm)
    thickness = np.float32(rng.uniform(*parameters.thickness_cm))
    above = thickness * layers + bulge * np.minimum(layers, 1)
    table, distance = camera.depth_of_table((width, height))
    depth = table * (1.0 - above / distance)
    depth = depth + parameters.depth_noise_cm * rng.standard_normal(depth.shape)
    return np.asarray(depth / 100.0, dtype=np.float32)
