"""Printed markers of known size: ArUco and AprilTag."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from foldrs.camera.pinhole import Camera
from foldrs.errors import ParameterError, ScaleReferenceError
from foldrs.image import Mask, RgbImage
from foldrs.parameters import ScaleParameters
from foldrs.scale.paint import RIM_SIDE, filled_quads, widened
from foldrs.scale.reference import FoundReference
from foldrs.scale.solve import in_frame_of, plane_of_rectangles

Points = npt.NDArray[np.float64]

DICTIONARIES = {
    "aruco-4x4": "DICT_4X4_250",
    "aruco-5x5": "DICT_5X5_250",
    "aruco-6x6": "DICT_6X6_250",
    "aruco-7x7": "DICT_7X7_250",
    "aruco-original": "DICT_ARUCO_ORIGINAL",
    "apriltag-16h5": "DICT_APRILTAG_16h5",
    "apriltag-25h9": "DICT_APRILTAG_25h9",
    "apriltag-36h10": "DICT_APRILTAG_36h10",
    "apriltag-36h11": "DICT_APRILTAG_36h11",
}
"""Families of markers, and OpenCV's names for them."""

_RARELY_CHANCE = tuple(name for name in DICTIONARIES if name not in ("apriltag-16h5", "aruco-original"))
"""Families looked for if none is named: patterns of cloth are easily taken for the others."""

_COMMON_SIDE = 640
"""px: longer side of the picture that lengths in px are meant for."""


@dataclass(frozen=True)
class Marker:
    """One printed marker or several, of one size and family, lying flat on the table.

    How they lie to each other need not be known. The table's frame is that of the marker with the smallest
    number: origin in its middle, x to its right and y to its top, so that z comes out of the table.

    Parameters
    ----------
    size_cm : float
        Side of the black square, cm.
    family : str, optional
        One of `DICTIONARIES`; without it most are tried.

    Raises
    ------
    ParameterError
        The size is not positive, or there is no such family.
    """

    size_cm: float
    family: str | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.size_cm) and self.size_cm > 0):
            raise ParameterError(f"The marker's size must be a positive number of cm, not {self.size_cm}.")
        if self.family is not None and self.family not in DICTIONARIES:
            raise ParameterError(
                f"There is no family of markers {self.family!r}: choose one of {', '.join(DICTIONARIES)}."
            )

    def find(self, rgb: RgbImage, camera: Camera | None, parameters: ScaleParameters) -> FoundReference:
        """Find the markers in a photograph, and the table they lie on.

        Raises
        ------
        ScaleReferenceError
            There is none, there are some of several families, or they do not fit one size and plane.
        """
        height, width = rgb.shape[:2]
        numbers, corners = self._detected(rgb)
        solved = plane_of_rectangles(
            corners, [(self.size_cm, self.size_cm)] * len(corners), (width, height), camera, parameters
        )
        limit = parameters.worst_corner * max(1.0, max(width, height) / _COMMON_SIDE)
        if solved.worst > limit:
            raise ScaleReferenceError(
                f"The markers do not lie on one plane, or are not all of {self.size_cm:g} cm (a corner is "
                f"{solved.worst:.1f} px off): lay them flat, and print them in one size."
            )
        first = solved.plane.to_table(corners[int(np.argmin(numbers))])
        plane = in_frame_of(solved.plane, first.mean(axis=0), first[1] - first[0], up=True)
        return FoundReference(plane, tuple(corners), self._covered(rgb, corners, parameters))

    def _detected(self, rgb: RgbImage) -> tuple[list[int], list[Points]]:
        """Numbers and corners of the markers, of the one family that is there."""
        grey = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8)
        families = _RARELY_CHANCE if self.family is None else (self.family,)
        found = {name: seen for name in families if (seen := _of_family(grey, name, self.family is not None))}
        if not found:
            what = "No marker" if self.family is None else f"No marker of the family {self.family}"
            raise ScaleReferenceError(
                f"{what} is seen in the picture: lay one flat on the table, whole, with white around it, "
                "at least 15 px large."
            )
        if len(found) > 1:
            raise ScaleReferenceError(
                f"Markers of several families are seen ({', '.join(found)}): name the one that is meant."
            )
        (markers,) = found.values()
        return [number for number, _ in markers], [corners for _, corners in markers]

    def _covered(self, rgb: RgbImage, corners: list[Points], parameters: ScaleParameters) -> Mask:
        """Pixels of the markers, the white around them and the paper they are printed on."""
        shape = rgb.shape[:2]
        lab = cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
        whole = np.zeros(shape, np.bool_)
        for quad in corners:
            black = filled_quads([quad], shape)
            own = filled_quads([quad], shape, 2 * parameters.quiet_zone)
            ring = filled_quads([quad], shape, parameters.quiet_zone) & ~widened(black, 1)
            whole |= own
            if not ring.any():
                continue
            white = np.median(lab[ring], axis=0)
            alike = (np.linalg.norm(lab - white, axis=2) < parameters.paper_likeness) | own
            _, labels = cv2.connectedComponents(alike.astype(np.uint8), connectivity=4)
            middle = tuple(np.round(quad.mean(axis=0)).astype(int)[::-1])
            paper = np.equal(labels, labels[middle])
            px_per_cm = math.sqrt(np.count_nonzero(black)) / self.size_cm
            # A table as white as the paper would be taken for it: then the white around must do.
            small = np.count_nonzero(paper) <= parameters.most_paper * px_per_cm**2
            if small and _solidity(paper) >= parameters.paper_solidity:
                whole |= paper
        return widened(whole, parameters.rim * max(shape) / RIM_SIDE)


def _solidity(mask: Mask) -> float:
    """Share of its convex hull that a mask, not empty, fills."""
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    largest = max(contours, key=cv2.contourArea)
    return cv2.contourArea(largest) / max(cv2.contourArea(cv2.convexHull(largest)), 1.0)


def _of_family(grey: npt.NDArray[np.uint8], family: str, tolerant: bool) -> list[tuple[int, Points]]:
    """Markers of a family: their numbers, and their corners clockwise from their own top left one, px."""
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    if not tolerant:
        settings.errorCorrectionRate = 0.0
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARIES[family]))
    corners, numbers, _ = cv2.aruco.ArucoDetector(dictionary, settings).detectMarkers(grey)
    if numbers is None:
        return []
    pairs = zip(np.ravel(numbers), corners, strict=True)
    return [(int(number), np.asarray(quad, dtype=np.float64).reshape(4, 2)) for number, quad in pairs]
