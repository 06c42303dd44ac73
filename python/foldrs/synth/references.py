"""Printed markers and a sheet of A4 lying on the table of a scene, beside the cloth."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.camera._matrices import inverse
from foldrs.errors import ParameterError
from foldrs.synth.camera import TableCamera
from foldrs.synth.garment import Points
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.pose import seen_by
from foldrs.synth.raster import FINE
from foldrs.synth.textures import Picture

MARKERS = 4
"""Markers laid out, if there is room for so many."""

_PLACES = 3000
"""Places tried for all of them."""

_GAP_CM = 2.0
"""Least distance from the cloth and from the border of the picture."""

_CELL = 20
"""px of a marker's own picture a cell of it."""

_BORDER = 2
"""Cells of white around a marker: 8 cells are the black square."""

_A4_CM = (29.7, 21.0)

_WHITE = 235.0
"""Brightness of paper before it is lit."""


def lay_references(
    picture: Picture,
    cloth: NDArray[np.bool_],
    camera: TableCamera,
    rng: np.random.Generator,
    parameters: SynthParameters,
) -> None:
    """Draw what ``marker_cm`` and ``sheet`` ask for into the picture of the table.

    Parameters
    ----------
    picture : ndarray of shape (height, width, 3)
        The table as the camera sees it; drawn into.
    cloth : ndarray of shape (height, width), bool
        Where cloth will lie.
    camera : TableCamera
    rng : numpy.random.Generator
        Source of the places.
    parameters : SynthParameters

    Raises
    ------
    ParameterError
        There is no room beside the cloth.
    """
    free = ~cloth
    papers = [(_A4_CM, np.full((2, 2), _WHITE, np.float32))] if parameters.sheet else []
    if parameters.marker_cm:
        side = parameters.marker_cm * (1 + 2 * _BORDER / 8)
        papers += [((side, side), _marker(number)) for number in range(MARKERS)]
    for k, (size, paper) in enumerate(papers):
        corners = _place(free, camera, size, rng, parameters)
        if corners is None:
            if k == 0:
                raise ParameterError(
                    "There is no room on the table for a marker or sheet: lower px_per_cm or marker_cm, or "
                    "enlarge image_size."
                )
            break
        cover = _draw(picture, paper, corners)
        free &= ~cover


def _marker(number: int) -> Picture:
    """Draw a marker with white around it."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    black_and_white = cv2.aruco.generateImageMarker(dictionary, number, 8 * _CELL)
    framed = np.pad(black_and_white, _BORDER * _CELL, constant_values=255)
    return np.asarray(20 + framed.astype(np.float32) * ((_WHITE - 20) / 255), dtype=np.float32)


def _place(
    free: NDArray[np.bool_],
    camera: TableCamera,
    size: tuple[float, float],
    rng: np.random.Generator,
    parameters: SynthParameters,
) -> Points | None:
    """Draw a place for a paper (width, height, cm); return its corners, px, clockwise, or None."""
    height, width = free.shape
    bordered = np.pad(free, 1).astype(np.uint8)
    room = cv2.distanceTransform(bordered, cv2.DIST_L2, 3)[1:-1, 1:-1]
    to_table = inverse(camera.table_to_image)
    shape = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(size) / 2
    gap = _GAP_CM * parameters.px_per_cm
    for _ in range(_PLACES):
        place = rng.uniform((0, 0), (width - 1, height - 1))
        turn = rng.uniform(0.0, 2 * np.pi)
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        corners = seen_by(camera.table_to_image, seen_by(to_table, place[None]) + shape @ rotation.T)
        reach = float(np.linalg.norm(corners - place, axis=1).max())
        if room[int(place[1]), int(place[0])] > reach + gap:
            return corners
    return None


def _draw(picture: Picture, paper: Picture, corners: Points) -> NDArray[np.bool_]:
    """Draw a paper with its corners at some px, finely; return the pixels it covers."""
    height, width = paper.shape
    low = np.floor(corners.min(axis=0)).astype(int) - 1
    high = np.ceil(corners.max(axis=0)).astype(int) + 2
    columns, rows = ((high - low) * FINE).tolist()
    own = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32) - np.float32(0.5)
    fine = (corners - low + 0.5) * FINE - 0.5
    way = cv2.getPerspectiveTransform(own, fine.astype(np.float32))
    drawn = cv2.warpPerspective(paper, way, (columns, rows), borderMode=cv2.BORDER_REPLICATE)
    cover = np.zeros((rows, columns), np.uint8)
    cv2.fillConvexPoly(cover, np.round(fine * 16).astype(np.int32).reshape(-1, 1, 2), 255, shift=4)
    size = (columns // FINE, rows // FINE)
    share = cv2.resize(cover, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    colour = cv2.resize(drawn, size, interpolation=cv2.INTER_AREA)
    part = (slice(low[1], high[1]), slice(low[0], high[0]))
    picture[part] += share[:, :, None] * (colour[:, :, None] - picture[part])
    covered = np.zeros(picture.shape[:2], np.bool_)
    covered[part] = share > 0
    return covered
