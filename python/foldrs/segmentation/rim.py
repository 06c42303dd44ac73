"""The outline moved onto the rim of the cloth, where the colours of its two sides meet.

A graph cut over colours of the whole garment places the outline within a few pixels; soft shadows draw it
outwards. Close to the rim the two sides are compared anew, each with its own mean and spread there: a
shadow widens the spread of the table's side in lightness, so that hue decides.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from ..image import Mask
from ..parameters import OutlineParameters
from .masks import largest_part, tidied, window
from .table import FloatImage

_LEAST_VARIANCE = 4.0  # of a side's colour, CIELAB units squared: noise that a small strip may not show
_VOTE_BLUR = 0.8  # px; neighbours vote together, which keeps the outline smooth
_VOTE_REACH = (
    5.0  # px; no vote counts from farther off: the blur is three wide to each side, and to its corners
)


class _Side(NamedTuple):
    """Colours beside the outline, as seen from some pixels: their number (k,), mean and variance (k, 3)."""

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
        away = np.where(inside, depth, height)
        near = np.flatnonzero(away <= p.rim_reach + _VOTE_REACH)  # only these move, or vote on those that do
        cloth, table = _side(colours, depth, near, p), _side(colours, height, near, p)
        contrast = cloth.mean - table.mean
        precision = np.reciprocal(cloth.variance + table.variance + _LEAST_VARIANCE, dtype=np.float32)
        strength = _total(contrast * contrast * precision)
        own = np.subtract(colours.reshape(-1, 3)[near], (cloth.mean + table.mean) / 2, dtype=np.float32)
        votes = _total(own * precision * contrast)
        vote = np.zeros(inside.size, np.float32)
        vote[near] = np.clip(votes / np.maximum(strength, 1e-6), -0.5, 0.5)
        blurred = cv2.GaussianBlur(vote.reshape(inside.shape), (0, 0), _VOTE_BLUR)
        enough = 2 * p.rim_window
        clear = (strength > p.rim_contrast) & (cloth.number > enough) & (table.number > enough)
        movable = np.zeros(inside.size, np.bool_)
        movable[near] = clear
        moved = np.where(movable.reshape(inside.shape) & (away <= p.rim_reach), blurred > 0, inside)
        mask = np.zeros_like(mask)
        mask[part] = largest_part(tidied(moved, p.opening))
    return mask


def _side(
    colours: FloatImage, distance: FloatImage, near: npt.NDArray[np.intp], parameters: OutlineParameters
) -> _Side:
    """Colours of the strip from `rim_gap` to `rim_gap + rim_ring` px off the outline, around those `near`."""
    ring = (distance > parameters.rim_gap) & (distance <= parameters.rim_gap + parameters.rim_ring)
    weight = ring.astype(np.float32)
    size = 2 * round(parameters.rim_window) - 1
    number = _box_sum(weight, size).ravel()[near]
    weighted = colours * weight[:, :, None]
    known = np.maximum(number, 1)[:, None]
    mean = np.divide(_box_sum(weighted, size).reshape(-1, 3)[near], known, dtype=np.float32)
    variance = _box_sum(weighted * colours, size).reshape(-1, 3)[near] / known - mean**2
    return _Side(number, mean, np.maximum(variance, 0, dtype=np.float32))


def _total(channels: FloatImage) -> FloatImage:
    """Sum over the channels, (k, 3), of every pixel."""
    total: FloatImage = channels[:, 0] + channels[:, 1] + channels[:, 2]
    return total


def _box_sum(values: FloatImage, size: int) -> FloatImage:
    """Sum of the values over a square window, which ends at the border of the picture."""
    total = cv2.boxFilter(values, -1, (size, size), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(total, np.float32)


def _distance(mask: Mask) -> FloatImage:
    """Distance (px) of the mask's pixels to its edge; the border of the picture is none."""
    padded = cv2.copyMakeBorder(mask.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1], np.float32)
