"""Figures as PNG files, from several threads at once."""

from __future__ import annotations

import io
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np

from foldrs.whole_files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# matplotlib promises nothing to threads, so figures are drawn one at a time; encoding and writing overlap.
_drawing = threading.Lock()


def save_figure(draw: Callable[[], Figure], path: Path) -> None:
    """Write a figure as a PNG file of its own size in px, whole or not at all.

    Parameters
    ----------
    draw : callable
        Makes the figure; is called while no other one is drawn.
    path : Path
        The file to write.

    Raises
    ------
    OSError
        The file cannot be written. What `draw` raises passes through.
    """
    pixels = io.BytesIO()
    with _drawing:
        figure = draw()
        figure.savefig(pixels, format="raw", dpi=figure.dpi)
        width, height = figure.canvas.get_width_height()
    rgba = np.frombuffer(pixels.getvalue(), np.uint8).reshape(height, width, 4)
    _, png = cv2.imencode(".png", rgba[:, :, 2::-1])
    write_whole(path, png.tobytes())
