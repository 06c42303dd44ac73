"""What the table looks like: a smooth colour over the picture, and a spread around it.

The smooth part takes up vignetting and light from one side, the spread grain and texture; what neither
explains is cloth, or its shadow.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..image import Mask
from ..parameters import OutlineParameters
from .masks import disc, largest_part, tidied

FloatImage = npt.NDArray[np.float32]

_SAMPLE_STEP = 7  # every seventh pixel determines the few coefficients as well as all of them
_ROUNDS = 6  # of reweighting; it settles in four or five


@dataclass(frozen=True)
class Surprise:
    """How far every pixel is from the table.

    Attributes
    ----------
    difference : (h, w, 3) float32
        Colour minus the table's colour there.
    deviation : (h, w) float32
        The same in spreads of the table's colour (Mahalanobis distance).
    """

    difference: FloatImage
    deviation: FloatImage


def surprise(lab: FloatImage, table: Mask, parameters: OutlineParameters) -> Surprise:
    """Compare a picture with the table seen at the pixels `table`, of which a minority may be wrong.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB.
    table : (h, w) bool
        Where (mostly) table is seen.
    parameters : OutlineParameters
    """
    terms = _polynomial_terms(lab.shape[:2], parameters.table_degree)
    sample = np.flatnonzero(table)[::_SAMPLE_STEP]
    known_terms, known_colours = terms[sample].astype(float), lab.reshape(-1, 3)[sample].astype(float)
    weights = np.ones(sample.size)
    ridge = 1e-3 * np.eye(terms.shape[1])
    for _ in range(_ROUNDS):
        weighted = known_terms * weights[:, None]
        coefficients = np.linalg.solve(weighted.T @ known_terms + ridge, weighted.T @ known_colours)
        residuals = known_colours - known_terms @ coefficients
        squared = (residuals**2).sum(axis=1)
        scale = np.median(squared) + parameters.table_noise**2
        weights = (1 + squared / (4 * scale)) ** -2.0
    spread = (residuals * weights[:, None]).T @ residuals / weights.sum()
    spread += parameters.table_noise**2 * np.eye(3)
    difference = lab.reshape(-1, 3) - terms @ coefficients.astype(np.float32)
    whitened = difference @ np.linalg.cholesky(np.linalg.inv(spread)).astype(np.float32)
    deviation = np.sqrt(np.einsum("ij,ij->i", whitened, whitened))
    return Surprise(difference.reshape(lab.shape), deviation.reshape(lab.shape[:2]))


def tell_cloth(lab: FloatImage, parameters: OutlineParameters) -> tuple[Mask, Surprise]:
    """First guess of the cloth: what deviates from the table along the border, then from all of the table.

    Returns
    -------
    mask : (h, w) bool
        All that stands out, in one or more parts; may be empty.
    surprise : Surprise
        Distance from the table as finally learnt.
    """
    frame = max(2, round(parameters.frame_share * min(lab.shape[:2])))
    table = np.ones(lab.shape[:2], np.bool_)
    table[frame:-frame, frame:-frame] = False
    seen = surprise(lab, table, parameters)
    cloth = _standing_out(seen.deviation, parameters)
    near = cv2.dilate(largest_part(cloth).astype(np.uint8), disc(parameters.table_margin)) > 0
    # Where cloth fills most of the picture the frame remains the better witness of the table.
    if np.count_nonzero(~near) > np.count_nonzero(table) / 2:
        seen = surprise(lab, ~near, parameters)
        cloth = _standing_out(seen.deviation, parameters)
    return cloth, seen


def _standing_out(deviation: FloatImage, parameters: OutlineParameters) -> Mask:
    """Otsu's threshold, on a logarithmic scale, or pale cloth would be lost beside dark print.

    A small garment on a table with joints or a strong grain: the threshold falls within
    the table's own colours. What stands out among those is then looked for, and must do so clearly.
    """
    limit = parameters.surprise_limit
    grey = (np.log1p(np.minimum(deviation, limit)) * (255 / np.log1p(limit))).astype(np.uint8)
    bright = grey > _otsu(grey)
    cloth = tidied(bright, parameters.opening)
    if _median(deviation, cloth) >= parameters.least_surprise:
        return cloth
    inner = tidied(bright & (grey > _otsu(grey[bright])), parameters.opening)
    return inner if _median(deviation, inner) >= parameters.clear_surprise else cloth


def _otsu(grey: npt.NDArray[np.uint8]) -> float:
    threshold, _ = cv2.threshold(grey.reshape(-1, 1), 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return float(threshold)


def _median(deviation: FloatImage, where: Mask) -> float:
    return float(np.median(deviation[where])) if where.any() else 0.0


def _polynomial_terms(shape: tuple[int, ...], degree: int) -> FloatImage:
    """Terms x^i y^j, i + j <= degree, of every pixel: (h w, terms), x and y from -1 to 1."""
    y, x = np.mgrid[-1 : 1 : shape[0] * 1j, -1 : 1 : shape[1] * 1j].astype(np.float32)
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    return np.stack([(x**i * y**j).ravel() for i, j in powers], axis=1)
