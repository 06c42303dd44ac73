"""How every place of the cloth looks, for the evidence of regions (beyond the paper).

A flap shows the cloth's other face, or its pattern the other way round. Places are told apart by colour, by
how busy the cloth is, and by which way its pattern runs; each gets one of a few looks (k-means).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.parameters import PictureParameters

Channels = NDArray[np.float32]
"""(h, w, c)."""


@dataclass(frozen=True, eq=False)
class Looks:
    """One of a few looks a pixel."""

    look: NDArray[np.uint8]
    """(h, w): the look of every pixel of the cloth's box; without meaning outside the cloth."""
    scale: float
    """Its pixels a pixel of the photograph."""
    origin: tuple[float, float]
    """Where in the photograph its first pixel lies, px."""


def looks_of(rgb: NDArray[np.uint8], outline: NDArray[np.float64], parameters: PictureParameters) -> Looks:
    """Give every place of the cloth one of a few looks.

    Parameters
    ----------
    rgb : (h, w, 3) uint8 array
        The photograph.
    outline : (n, 2) array
        The seen outline, px.
    parameters : PictureParameters
        Size of the cloth the looks are told at, and how many.

    Returns
    -------
    Looks
        Of a cloth of hardly any pixels all of one look.
    """
    low = np.clip(np.floor(outline.min(axis=0)), 0, np.array(rgb.shape[1::-1]) - 1).astype(int)
    high = np.ceil(outline.max(axis=0)).astype(int) + 1
    box = rgb[low[1] : high[1], low[0] : high[0]]
    side = np.sqrt(abs(cv2.contourArea(outline.astype(np.float32))))
    scale = min(1.0, parameters.cloth / max(float(side), 1.0))
    size = tuple(max(1, round(length * scale)) for length in box.shape[1::-1])
    small = np.asarray(cv2.resize(box, size, interpolation=cv2.INTER_AREA), np.uint8)
    cloth = np.zeros(small.shape[:2], np.uint8)
    cv2.fillPoly(cloth, [np.rint((outline - low) * scale).astype(np.int32)], 1)

    unit = float(side) * scale * parameters.look_blur
    inner = cv2.distanceTransform(cloth, cv2.DIST_L2, 5) > unit
    if np.count_nonzero(inner) < parameters.fewest_seen:
        look = np.zeros(cloth.shape, np.uint8)
    else:
        look = _clusters(_features(small, cloth, unit, parameters.no_slope), inner, parameters)
    return Looks(look, scale, (float(low[0]), float(low[1])))


def _features(rgb: NDArray[np.uint8], cloth: NDArray[np.uint8], blur: float, no_slope: float) -> Channels:
    """Colour, how busy it is, and which way the pattern runs, smoothed within the cloth: (h, w, 8)."""
    weight = cloth.astype(np.float32)

    def smooth(channels: Channels) -> Channels:
        total = cv2.GaussianBlur(channels * weight[:, :, None], (0, 0), blur)
        whole = np.maximum(cv2.GaussianBlur(weight, (0, 0), blur), 1e-3)
        return np.asarray(total / whole[:, :, None], np.float32)

    lab = np.asarray(cv2.cvtColor(rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2Lab), np.float32)
    # The table must not count at the cloth's rim.
    lab = np.where(weight[:, :, None] > 0, lab, smooth(lab))
    busy = np.abs(lab - smooth(lab))
    lightness = cv2.GaussianBlur(lab[:, :, 0], (0, 0), 1.0)
    x, y = (cv2.Sobel(lightness, cv2.CV_32F, *along, scale=1 / 8) for along in ((1, 0), (0, 1)))
    # Twice the angle of the slope: opposite slopes are one direction. Noise has none.
    steep = np.hypot(x, y) + np.float32(no_slope)
    runs = np.stack([(x * x - y * y) / steep, 2 * x * y / steep], axis=-1)
    return smooth(np.concatenate([lab, busy, runs], axis=-1))


def _clusters(
    features: Channels, inner: NDArray[np.bool_], parameters: PictureParameters
) -> NDArray[np.uint8]:
    """Cluster the features of the inner cloth, and give every pixel the nearest cluster."""
    seen = features[inner]
    features = (features - seen.mean(axis=0)) / (
        seen.std(axis=0) + np.array(parameters.means_nothing, np.float32)
    )
    seen = features[inner]
    sample = np.ascontiguousarray(seen[:: max(1, len(seen) // parameters.look_samples)])
    # Begun with slices across the main direction, not with chance: the same picture has the same looks.
    # (Products of so few columns are summed without BLAS, whose threads take longer to wake.)
    _, axes = np.linalg.eigh(np.einsum("ni,nj->ij", sample, sample))
    along = np.einsum("ni,i->n", sample, axes[:, -1])
    rank = along.argsort(kind="stable").argsort(kind="stable")
    slices = (rank * parameters.looks // len(sample)).astype(np.int32)[:, None]
    until = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 20, 1e-3)
    _, _, centres = cv2.kmeans(sample, parameters.looks, slices, until, 1, cv2.KMEANS_USE_INITIAL_LABELS)
    # The nearest centre: |f - c|2 less |f|2, which is the same for all.
    distance = (centres**2).sum(axis=1) - 2 * np.einsum("hwi,ki->hwk", features, centres)
    return np.asarray(distance.argmin(axis=-1), np.uint8)
