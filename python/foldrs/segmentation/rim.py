"""The outline moved onto the rim of the cloth, where the colours of its two sides meet.

A graph cut over colours of the whole garment places the outline within a few pixels; soft shadows draw it
outwards. Close to the rim the two sides are compared anew, each with its own mean and spread there: a
shadow widens the spread of the table's side in lightness, so that hue decides.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from ..image import Mask
from ..parameters import OutlineParameters
from .masks import largest_part, tidied, window
from .table import FloatImage

_LEAST_VARIANCE = 4.0  # of a side's colour, CIELAB units squared: noise that a small strip may not show
_VOTE_BLUR = 0.8  # px; neighbours vote together, which keeps the outline smooth


class _Side(NamedTuple):
    """Colours beside the outline, as seen from every pixel: their number, mean and variance."""

    number: FloatImage
    mean: FloatImage
    variance: FloatImage


def snap_to_rim(lab: FloatImage, mask: Mask, parameters: OutlineParameters) -> Mask:
    """Move the outline of `mask` by at most `rim_reach` px a round to where cloth meets table.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB.
    mask : (h, w) bool
        The cloth within a few px.
    parameters : OutlineParameters

    Returns
    -------
    (h, w) bool
        One part without holes.
    """
    p = parameters
    for _ in range(p.rim_rounds):
        if not mask.any():
            break
        part = window(mask, p.rim_reach + p.rim_gap + p.rim_ring + 2)
        colours, inside = lab[part], mask[part]
        depth, height = _distance(inside), _distance(~inside)
        cloth, table = _side(colours, depth, p), _side(colours, height, p)
        contrast = cloth.mean - table.mean
        precision = 1 / (cloth.variance + table.variance + _LEAST_VARIANCE)
        strength = (contrast**2 * precision).sum(axis=2)
        vote = ((colours - (cloth.mean + table.mean) / 2) * precision * contrast).sum(axis=2)
        vote = np.clip(vote / np.maximum(strength, 1e-6), -0.5, 0.5)
        vote = cv2.GaussianBlur(vote, (0, 0), _VOTE_BLUR)
        enough = 2 * p.rim_window
        movable = (np.where(inside, depth, height) <= p.rim_reach) & (strength > p.rim_contrast)
        movable &= (cloth.number > enough) & (table.number > enough)
        moved = np.zeros_like(mask)
        moved[part] = np.where(movable, vote > 0, inside)
        mask = largest_part(tidied(moved, p.opening))
    return mask


def _side(colours: FloatImage, distance: FloatImage, parameters: OutlineParameters) -> _Side:
    """Colours of the strip from `rim_gap` to `rim_gap + rim_ring` px off the outline, around every pixel."""
    ring = (distance > parameters.rim_gap) & (distance <= parameters.rim_gap + parameters.rim_ring)
    weight = ring.astype(np.float32)
    size = 2 * round(parameters.rim_window) - 1
    number = _box_sum(weight, size)
    weighted = colours * weight[:, :, None]
    known = np.maximum(number, 1)[:, :, None]
    mean = np.divide(_box_sum(weighted, size), known, dtype=np.float32)
    variance = _box_sum(weighted * colours, size) / known - mean**2
    return _Side(number, mean, np.maximum(variance, 0, dtype=np.float32))


def _box_sum(values: FloatImage, size: int) -> FloatImage:
    """Sum of the values over a square window, which ends at the border of the picture."""
    total = cv2.boxFilter(values, -1, (size, size), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(total, np.float32)


def _distance(mask: Mask) -> FloatImage:
    """Distance (px) of the mask's pixels to its edge; the border of the picture is none."""
    padded = cv2.copyMakeBorder(mask.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1], np.float32)
