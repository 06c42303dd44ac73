"""The view from above: the garment as a camera straight above would see it, in which lengths are alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from foldrs import _core
from foldrs.camera._matrices import inverse
from foldrs.camera.plane import TablePlane

Points = npt.NDArray[np.float64]

_MARGIN = 0.25
"""Table shown around the garment, as a share of its larger side: for whoever looks at the picture."""

_GRID_PX = 8
"""Spacing of the grid on which the way into the photograph is computed; it bends over much more."""


@dataclass(frozen=True, eq=False)
class ViewFromAbove:
    """A window onto the table, seen from straight above.

    It is turned as the photograph is and never mirrored, and the garment covers as many pixels of it as of
    the photograph: parameters in px keep their meaning.
    """

    plane: TablePlane
    px_per_cm: float
    matrix: Points
    """(2, 2) from table cm to px of the view: a turn, perhaps a mirror image, and the scale."""
    offset: Points
    """(2,) px."""
    size: tuple[int, int]
    """Width and height, px."""

    @classmethod
    def of(cls, plane: TablePlane, outline: Points) -> ViewFromAbove:
        """Look at an outline of the photograph, (n, 2) px.

        Raises
        ------
        CalibrationError
            The outline does not lie on the table.
        """
        table = plane.to_table(outline)
        px_per_cm = math.sqrt(abs(_core.signed_area(outline) / _core.signed_area(table)))
        left, _, right = np.linalg.svd(plane.table_axes(table.mean(axis=0)))
        matrix = px_per_cm * (left @ right)
        seen = table @ matrix.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        margin = math.ceil(_MARGIN * float((high - low).max()))
        width, height = (math.ceil(length) + 2 * margin + 1 for length in high - low)
        return cls(plane, px_per_cm, np.asarray(matrix), margin - low, (width, height))

    def from_image(self, points: Points) -> Points:
        """Carry (n, 2) px of the photograph into the view."""
        return np.asarray(self.plane.to_table(points) @ self.matrix.T + self.offset, dtype=np.float64)

    def to_table(self, points: Points) -> Points:
        """Carry (n, 2) px of the view to the table, cm."""
        return np.asarray((points - self.offset) @ inverse(self.matrix).T, dtype=np.float64)

    def to_image(self, points: Points) -> Points:
        """Carry (n, 2) px of the view into the photograph."""
        return self.plane.to_image(self.to_table(points))

    def picture(self, image: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Look at the photograph, or what else lies pixel on pixel with it, through the window.

        Parameters
        ----------
        image : (h, w) or (h, w, 3) array
            uint8 or float32. Beyond its border the outermost pixels go on.
        """
        width, height = self.size
        x, y = (np.arange(-1, -(-n // _GRID_PX) + 1) * _GRID_PX + (_GRID_PX - 1) / 2 for n in (width, height))
        grid = np.stack(np.meshgrid(x, y), axis=-1)
        way = self.to_image(grid.reshape(-1, 2)).reshape(grid.shape).astype(np.float32)
        fine = cv2.resize(way, (len(x) * _GRID_PX, len(y) * _GRID_PX), interpolation=cv2.INTER_LINEAR)
        fine = fine[_GRID_PX : _GRID_PX + height, _GRID_PX : _GRID_PX + width]
        seen = cv2.remap(image, fine[..., 0], fine[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(seen)
