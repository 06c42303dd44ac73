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


@dataclass(frozen=True, eq=False)
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
    (x, y), powers = _places(lab.shape[:2]), _powers(parameters.table_degree)
    row, column = np.divmod(np.flatnonzero(table)[::_SAMPLE_STEP], lab.shape[1])
    terms = np.stack([x[column] ** i * y[row] ** j for i, j in powers]).astype(float)
    colours = np.ascontiguousarray(lab[row, column].T, float)
    weights = np.ones(row.size)
    ridge = 1e-3 * np.eye(len(powers))
    for _ in range(_ROUNDS):
        weighted = terms * weights
        coefficients = np.linalg.solve(_products(weighted, terms) + ridge, _products(weighted, colours))
        residuals = colours - np.einsum("tc,tn->cn", coefficients, terms)
        squared = (residuals**2).sum(axis=0)
        scale = np.median(squared) + parameters.table_noise**2
        weights = (1 + squared / (4 * scale)) ** -2.0
    spread = _products(residuals * weights, residuals) / weights.sum()
    spread += parameters.table_noise**2 * np.eye(3)
    difference = lab.copy()
    for (i, j), colour in zip(powers, coefficients.astype(np.float32), strict=True):
        difference -= (x**i)[:, None] * colour * (y**j)[:, None, None]
    whitening = np.linalg.cholesky(np.linalg.inv(spread)).astype(np.float32)
    whitened = cv2.transform(difference, whitening.T)
    return Surprise(difference, np.sqrt(squared_length(whitened)))


def squared_length(colours: FloatImage) -> FloatImage:
    """Sum of the squares of a picture's channels, (h, w)."""
    return np.asarray(
        cv2.transform(colours * colours, np.ones((1, colours.shape[2]), np.float32)), np.float32
    )


def table_around(lab: FloatImage, mask: Mask, parameters: OutlineParameters) -> Surprise:
    """Compare a picture with the table seen close around an object.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB, coarse px.
    mask : (h, w) bool
        The object.
    parameters : OutlineParameters
    """
    wide, narrow = (
        cv2.dilate(mask.astype(np.uint8), disc(by)) > 0
        for by in (parameters.candidates.table_reach, parameters.rim_gap)
    )
    return surprise(lab, wide & ~narrow, parameters)


def tell_cloth(lab: FloatImage, parameters: OutlineParameters) -> tuple[Mask, Surprise]:
    """First guess of the cloth: what deviates from the table along the border, then from all of the table.

    Returns
    -------
    mask : (h, w) bool
        All that stands out, in one or more parts; may be empty.
    surprise : Surprise
        Distance from the table as finally learnt.
    """
    table = table_along_border(lab.shape[:2], parameters)
    seen = surprise(lab, table, parameters)
    cloth = _standing_out(seen.deviation, parameters)
    near = cv2.dilate(largest_part(cloth).astype(np.uint8), disc(parameters.table_margin)) > 0
    # Where cloth fills most of the picture the frame remains the better witness of the table.
    if np.count_nonzero(~near) > np.count_nonzero(table) / 2:
        seen = surprise(lab, ~near, parameters)
        cloth = _standing_out(seen.deviation, parameters)
    return cloth, seen


def table_along_border(shape: tuple[int, ...], parameters: OutlineParameters) -> Mask:
    """Mark the frame along the border of a picture, (h, w): table, if that fills the picture."""
    frame = max(2, round(parameters.frame_share * min(shape)))
    table = np.ones(shape, np.bool_)
    table[frame:-frame, frame:-frame] = False
    return table


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


def _products(some: npt.NDArray[np.float64], others: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Products of every row with every other one, summed up.

    Not by BLAS, which brings its threads for so many pixels: they take longer to wake than this takes, and
    keep the cores from other images.
    """
    products: npt.NDArray[np.float64] = np.einsum("in,jn->ij", some, others)
    return products


def _places(shape: tuple[int, ...]) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Place all columns and all rows from -1 to 1."""
    x, y = (np.linspace(-1, 1, n).astype(np.float32) for n in (shape[1], shape[0]))
    return x, y


def _powers(degree: int) -> list[tuple[int, int]]:
    """List the terms x^i y^j, i + j <= degree."""
    return [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
