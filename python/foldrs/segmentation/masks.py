"""Operations on masks that stages of the segmentation share. Masks are (h, w) bool, True for cloth."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import SeveralGarmentsError
from ..image import Mask
from ..parameters import OutlineParameters


def disc(radius: float) -> npt.NDArray[np.uint8]:
    """Make a disc of that radius (px), for morphology."""
    r = max(1, round(radius))
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * r + 1, 2 * r + 1)), np.uint8)


def closed(mask: Mask, radius: float) -> Mask:
    """`mask` with gaps up to twice `radius` closed; the picture's border closes nothing."""
    pad = max(1, round(radius)) + 1
    padded = cv2.copyMakeBorder(mask.astype(np.uint8), pad, pad, pad, pad, cv2.BORDER_CONSTANT, value=0)
    return cv2.morphologyEx(padded, cv2.MORPH_CLOSE, disc(radius))[pad:-pad, pad:-pad] > 0


def filled(mask: Mask) -> Mask:
    """`mask` without holes."""
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    full = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(full, contours, -1, 1, cv2.FILLED)
    return full > 0


def hull(mask: Mask) -> npt.NDArray[np.int32]:
    """Corners (n, 1, 2), x and y, of the convex hull of a mask that is not empty."""
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return np.asarray(cv2.convexHull(np.concatenate(contours)), np.int32)


def tidied(mask: Mask, radius: float) -> Mask:
    """`mask` with gaps of `radius` closed, holes filled and threads of `radius` removed."""
    whole = filled(closed(mask, radius)).astype(np.uint8)
    return cv2.morphologyEx(whole, cv2.MORPH_OPEN, disc(radius)) > 0


def without_tails(mask: Mask, parameters: OutlineParameters) -> Mask:
    """`mask` without what hangs on it long and thin: joints and edges of the table, ribbons, straps.

    What an opening takes away is a tail if it leads farther from the rest than a corner would. The width
    of tails is bounded in proportion to the size of the object.
    """
    p = parameters
    radius = p.tail_radius * float(np.sqrt(np.count_nonzero(mask)))
    if radius < 1:
        return mask
    body = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc(radius)) > 0
    if not body.any():
        return mask
    body = largest_part(body)
    labels = _parts(mask & ~body)[0].astype(np.intp)
    away = np.asarray(cv2.distanceTransform((~body).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
    reach = np.zeros(int(labels.max()) + 1, np.float32)
    np.maximum.at(reach, labels.ravel(), away.ravel())
    short = reach <= p.tail_length * radius
    short[0] = False  # the label of all else
    return np.logical_or(body, short[labels])


def largest_part(mask: Mask) -> Mask:
    """Keep the largest connected part of `mask`, if there is any."""
    labels, areas = _parts(mask)
    if areas.size == 0:
        return mask
    return np.equal(labels, 1 + int(np.argmax(areas)))


def part_over(mask: Mask, other: Mask) -> Mask:
    """Keep the connected part of `mask` that covers most of `other`; `other` itself if none does."""
    labels, areas = _parts(mask)
    covered = np.bincount(labels[other], minlength=len(areas) + 1)[1:]
    return np.equal(labels, 1 + int(np.argmax(covered))) if covered.any() else other


def single_object(mask: Mask, parameters: OutlineParameters, merge_gap: float) -> Mask:
    """Keep the one object of `mask`.

    Parameters
    ----------
    mask : (h, w) bool
    parameters : OutlineParameters
    merge_gap : float
        Parts no further apart than about this (px) are one object; print of the table's colour can split
        a garment.

    Raises
    ------
    SeveralGarmentsError
        A second object is nearly as large.
    """
    labels, areas = _parts(mask)
    if areas.size < 2:
        return mask
    if np.sort(areas)[-2] >= parameters.part_share * areas.max():
        large = np.concatenate([[False], areas >= parameters.part_share * areas.max()])
        labels, areas = _parts(filled(closed(large[labels], merge_gap)))
    refuse_like_sizes(areas, parameters)
    return np.equal(labels, 1 + int(np.argmax(areas)))


def refuse_like_sizes(areas: npt.ArrayLike, parameters: OutlineParameters) -> None:
    """Raise SeveralGarmentsError if the second of the areas (px) is nearly as large as the first."""
    ranked = np.sort(np.asarray(areas))[::-1]
    if ranked.size > 1 and ranked[1] >= parameters.like_size_share * ranked[0]:
        raise SeveralGarmentsError(
            f"There are several objects of like size ({ranked[0]:.0f} and {ranked[1]:.0f} pixels): "
            "leave one garment in the picture, or pass a mask of the one that is meant."
        )


def parts(mask: Mask, least_share: float) -> Iterator[Mask]:
    """Yield the connected parts of `mask` that are at least that share of the picture."""
    labels, areas = _parts(mask)
    for label in 1 + np.flatnonzero(areas >= least_share * mask.size):
        yield np.equal(labels, label)


def overlap(one: Mask, other: Mask) -> float:
    """Intersection over union; 0 of nothing."""
    return int(np.count_nonzero(one & other)) / max(1, int(np.count_nonzero(one | other)))


def likeness_to_quadrilateral(mask: Mask) -> float:
    """Overlap of a mask and the quadrilateral its hull simplifies to; 0 if that has other corners."""
    corners = hull(mask)
    length = cv2.arcLength(corners, closed=True)
    for tolerance in np.linspace(0.01, 0.15, 15):
        corners = np.asarray(cv2.approxPolyDP(corners, tolerance * length, closed=True), np.int32)
        if len(corners) <= 4:
            break
    if len(corners) != 4:
        return 0.0
    drawn = np.zeros(mask.shape, np.uint8)
    cv2.fillConvexPoly(drawn, corners, 1)
    return overlap(mask, drawn > 0)


def touches_border(mask: Mask) -> bool:
    """Whether any of `mask` lies on the picture's border."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def resized(mask: Mask, shape: tuple[int, int]) -> Mask:
    """`mask` brought to another size (h, w), its rim interpolated."""
    if mask.shape == shape:
        return mask
    grey = cv2.resize(mask.astype(np.uint8) * 255, (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR)
    return grey > 127


def window(mask: Mask, margin: float) -> tuple[slice, slice]:
    """Rows and columns of the box around a mask that is not empty, `margin` (px) wider on every side."""
    around = int(np.ceil(margin))
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return (
        slice(max(0, int(rows[0]) - around), int(rows[-1]) + around + 1),
        slice(max(0, int(columns[0]) - around), int(columns[-1]) + around + 1),
    )


def _parts(mask: Mask) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Labels of the connected parts (0 outside) and their areas (px) from label 1 on."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    return np.asarray(labels, np.int32), np.asarray(statistics[1:, cv2.CC_STAT_AREA], np.int32)
