"""Cloth and table separated by their colours and the strength of the edge between (GrabCut)."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from ..image import Mask
from ..parameters import OutlineParameters
from .masks import window
from .table import Surprise

_COMPONENTS = 5  # of a colour mixture; fixed by OpenCV
_RANGE = 100.0  # 99 % of the differences are spread over this part of the 8 bits GrabCut works with
_MOST_GAIN = 6.0  # but noise is not blown up


def cut(seen: Surprise, mask: Mask, parameters: OutlineParameters) -> Mask:
    """Improve a first mask by a graph cut over colours relative to the table.

    OpenCV's GrabCut starts its mixtures with random seeds that any other thread may move on; here they
    are started by splitting, so the same picture always gives the same mask.

    Parameters
    ----------
    seen : Surprise
        How far every pixel is from the table. What looks just like it outside the first guess stays table,
        or a print of its colour would let the cloth spread over it.
    mask : (h, w) bool
        First guess, not empty.
    parameters : OutlineParameters
    """
    part = window(mask, parameters.cut_margin)
    inside = mask[part]
    if inside.all():
        return mask
    near = seen.difference[part]
    gain = min(_MOST_GAIN, _RANGE / max(1.0, float(np.percentile(np.abs(near), 99))))
    colours = np.ascontiguousarray(np.clip(near * gain + 128, 0, 255).astype(np.uint8))
    labels = np.where(inside, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[~inside & (seen.deviation[part] < parameters.table_like)] = cv2.GC_BGD
    table, cloth = (colour_mixture(_thinned(colours[side], parameters)) for side in (~inside, inside))
    whole = (0, 0, colours.shape[1], colours.shape[0])  # not looked at when evaluating
    cv2.grabCut(colours, labels, whole, table, cloth, parameters.cut_rounds, cv2.GC_EVAL)
    improved = np.zeros_like(mask)
    improved[part] = labels == cv2.GC_PR_FGD
    return improved


def colour_mixture(colours: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Gaussian mixture of colours by binary splitting (Orchard & Bouman 1991), in OpenCV's layout.

    Parameters
    ----------
    colours : (n, 3) float64
        n >= 1.

    Returns
    -------
    (1, 65) float64
        Five weights, five means, five covariances.
    """
    groups = split_colours(colours, _COMPONENTS)
    weights, means = np.zeros(_COMPONENTS), np.zeros((_COMPONENTS, 3))
    covariances = np.tile(np.eye(3), (_COMPONENTS, 1, 1))
    for k, group in enumerate(groups):
        weights[k] = len(group) / len(colours)
        means[k] = group.mean(axis=0)
        covariances[k] = _scatter(group) / len(group) + 0.5 * np.eye(3)
    return np.concatenate([weights, means.ravel(), covariances.ravel()])[None]


def split_colours(colours: npt.NDArray[np.float64], number: int) -> list[npt.NDArray[np.float64]]:
    """Split colours, (n, 3), into at most `number` groups: always the widest, across its widest direction."""
    groups = [colours]
    while len(groups) < number:
        scatters = [np.linalg.eigh(_scatter(group)) for group in groups]
        widest = int(np.argmax([values[-1] for values, _ in scatters]))
        if scatters[widest][0][-1] <= 0:
            break
        axis = scatters[widest][1][:, -1]
        group = groups.pop(widest)
        above = (group - group.mean(axis=0)) @ axis > 0
        if not 0 < np.count_nonzero(above) < len(group):
            groups.append(group)
            break
        groups += [group[~above], group[above]]
    return groups


def _scatter(colours: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Scatter matrix (3, 3): the covariance times the number of colours."""
    centred = colours - colours.mean(axis=0)
    scatter: npt.NDArray[np.float64] = centred.T @ centred
    return scatter


def _thinned(colours: npt.NDArray[np.uint8], parameters: OutlineParameters) -> npt.NDArray[np.float64]:
    """Evenly chosen colours, enough to start a mixture with."""
    step = max(1, len(colours) // parameters.mixture_samples)
    return colours[::step].astype(np.float64)
