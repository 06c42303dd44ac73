"""What every object of known size has in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from foldrs.camera.pinhole import Camera
from foldrs.camera.plane import TablePlane
from foldrs.image import Mask, RgbImage
from foldrs.parameters import ScaleParameters

Points = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FoundReference:
    """An object of known size, found."""

    plane: TablePlane
    """The table it lies on."""
    corners: tuple[Points, ...]
    """(4, 2) px each: the rectangles of known size, in the order of their own corners."""
    covered: Mask
    """(h, w) bool: all of its pixels, its paper included; none of them is garment."""


class Reference(Protocol):
    """An object of known size lying on the table."""

    def find(self, rgb: RgbImage, camera: Camera | None, parameters: ScaleParameters) -> FoundReference:
        """Find it in a photograph, taken by a camera that may be known.

        Raises
        ------
        ScaleReferenceError
            It is not there, or it is unclear which of several is meant.
        """
        ...
