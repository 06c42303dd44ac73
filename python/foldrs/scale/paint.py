"""Taking a marker or sheet out of the picture, so that it is not taken for cloth."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from foldrs.image import Mask, RgbImage

Points = npt.NDArray[np.float64]

RIM_SIDE = 320
"""px: longer side of the picture that the width painted over around a thing is meant for, and in which the
table is continued: what is painted has no detail."""

_RADIUS = 4.0
"""px of it: how far around a pixel is looked for the table's colour."""


def painted_over(rgb: RgbImage, covered: Mask) -> RgbImage:
    """Continue the table over some pixels from what lies around them.

    Parameters
    ----------
    rgb : (h, w, 3) uint8
    covered : (h, w) bool
        What is to be painted over.

    Returns
    -------
    (h, w, 3) uint8
        A new picture.
    """
    height, width = covered.shape
    factor = min(1.0, RIM_SIDE / max(height, width))
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    small = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
    hole = cv2.resize(covered.astype(np.uint8) * 255, size, interpolation=cv2.INTER_AREA) > 0
    table = cv2.inpaint(small, hole.astype(np.uint8), _RADIUS, cv2.INPAINT_TELEA)
    painted = rgb.copy()
    painted[covered] = cv2.resize(table, (width, height), interpolation=cv2.INTER_LINEAR)[covered]
    return np.asarray(painted, np.uint8)


def filled_quads(quads: list[Points], shape: tuple[int, int], grown_by: float = 0.0) -> Mask:
    """Pixels within quadrilaterals, (4, 2) px each, enlarged about their middles by a share of their size."""
    mask = np.zeros(shape, np.uint8)
    for quad in quads:
        middle = quad.mean(axis=0)
        corners = middle + (quad - middle) * (1 + grown_by)
        cv2.fillConvexPoly(mask, np.round(corners).astype(np.int32).reshape(-1, 1, 2), 1)
    return mask > 0


def widened(mask: Mask, pixels: float) -> Mask:
    """`mask` and what lies within some px of it."""
    r = max(1, round(pixels))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * r + 1, 2 * r + 1))
    return cv2.dilate(mask.astype(np.uint8), disc) > 0
