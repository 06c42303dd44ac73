"""All that may be the garment in a picture, where it is not clear what the table is.

Three ways of telling things from what they lie on, at several thresholds each: what deviates from the colours
along the border, what deviates from any one colour that much of the picture has (a table may be anywhere in
it), and what the border does not reach without a change of colour (`enclosed`). Nearly always the garment is
among them; which one it is, is told by `choice`.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from ..image import Mask
from ..parameters import CandidateParameters, OutlineParameters
from .cut import split_colours
from .enclosed import enclosed_objects
from .masks import disc, filled, largest_part, overlap, parts, tidied, without_tails
from .table import FloatImage, squared_length, surprise, table_along_border

__all__ = ["candidates"]

_THIN_OUT = 16  # every sixteenth pixel tells the few colours of a picture as well as all of them
_SAME = 0.93  # overlap (IoU) of what is one candidate


def candidates(lab: FloatImage, parameters: OutlineParameters) -> list[Mask]:
    """List all that may be the garment: one part each, without holes.

    Parameters
    ----------
    lab : (h, w, 3) float32
        CIELAB, coarse px.
    parameters : OutlineParameters
    """
    kept: list[tuple[Mask, int]] = []
    for mask in _all(lab, parameters):
        area = int(np.count_nonzero(mask))
        if not any(_are_one(mask, area, *other) for other in kept):
            kept.append((mask, area))
    return [mask for mask, _ in kept]


def _are_one(one: Mask, one_area: int, other: Mask, other_area: int) -> bool:
    """Whether two candidates of these areas (px) are one."""
    alike = min(one_area, other_area) > _SAME * max(one_area, other_area)
    return alike and overlap(one, other) > _SAME


def _all(lab: FloatImage, parameters: OutlineParameters) -> Iterator[Mask]:
    p, c = parameters, parameters.candidates
    for table in (table_along_border(lab.shape[:2], p), *_of_one_colour(lab, c)):
        deviation = surprise(lab, table, p).deviation
        for threshold in np.geomspace(c.least_deviation, p.surprise_limit, c.deviations):
            for part in parts(tidied(deviation > threshold, p.opening), c.least_object):
                whole = without_tails(filled(part), p)
                if np.count_nonzero(whole) <= p.most_share * whole.size:
                    yield whole
    yield from enclosed_objects(lab, p)


def _of_one_colour(lab: FloatImage, parameters: CandidateParameters) -> Iterator[Mask]:
    """Large connected parts of the picture that have one colour each."""
    c = parameters
    groups = split_colours(lab.reshape(-1, 3)[::_THIN_OUT].astype(np.float64), c.table_colours)
    colours = [group.mean(axis=0).astype(np.float32) for group in groups]
    nearest = np.argmin([squared_length(lab - colour) for colour in colours], axis=0)
    for k in range(len(colours)):
        of_colour = np.equal(nearest, k).astype(np.uint8)
        part = largest_part(cv2.morphologyEx(of_colour, cv2.MORPH_OPEN, disc(1)) > 0)
        if part.mean() >= c.least_table:
            yield part
