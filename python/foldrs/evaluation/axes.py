"""The true fold axis on a template, and how far an estimated axis is from it (section 4.1).

The true axis is carried onto the template by the landmarks: each end keeps its share of the way, along the
outline, from one landmark to the next.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs.evaluation.geometry import angle_between, area, hull_share, similarity
from foldrs.evaluation.kinds import Kind
from foldrs.evaluation.landmarked import LandmarkedOutline
from foldrs.evaluation.scenes import Scene
from foldrs.template import Template

Points = NDArray[np.float64]

_COMPARED = 100
"""Points of the outlines compared for EucDist."""


def axis_error(scene: Scene, template: Mapping[str, Any], kind: Kind) -> tuple[float, float]:
    """Errors dA and dtheta of the axis on a template of the kind, for the symmetry kindest to it.

    A template without axis misses the true one by any measure.
    """
    if template["axis"] is None:
        return math.inf, 90.0
    axis, outline = (np.asarray(template[field], dtype=np.float64) for field in ("axis", "outline"))
    whole = area(outline)
    return min(
        (hull_share(axis, true_axis, whole), angle_between(axis, true_axis))
        for true_axis in true_axes(scene, outline, template["landmarks"], kind)
    )


def template_distance(scene: Scene, templates: Sequence[Template], kind: Kind) -> float:
    """EucDist: mean distance (cm) of the garment's outline from that of the nearest template, unfolded.

    The template is laid over the garment by the similarity that fits best; points correspond that lie at the
    same share of the way between two landmarks.
    """
    garment = _true_garment(scene, kind)
    points = garment.spread(_COMPARED)
    places = garment.locate(points)
    distances = []
    for template in templates:
        marks = np.array([template.landmarks[name] for name in kind.landmarks])
        outline = LandmarkedOutline(template.outline, marks)
        for relabelling in kind.relabellings:
            partners = outline.at_relabelled(places, relabelling)
            for reflecting in (False, True):
                laid = similarity(partners, points, reflecting=reflecting)
                off = partners @ laid[:, :2].T + laid[:, 2] - points
                distances.append(float(np.linalg.norm(off, axis=1).mean()))
    return min(distances) / scene.px_per_cm


def _true_garment(scene: Scene, kind: Kind) -> LandmarkedOutline:
    marks = np.array([scene.landmarks[name].garment for name in kind.landmarks])
    return LandmarkedOutline(scene.outline_garment, marks)


def true_axes(scene: Scene, outline: Points, landmarks: Mapping[str, Any], kind: Kind) -> Iterator[Points]:
    """Yield the true axis on a template, once for every symmetry; nothing if there is no fold."""
    if scene.axis_garment is None:
        return
    places = _true_garment(scene, kind).locate(scene.axis_garment)
    onto = LandmarkedOutline(
        outline, np.array([landmarks[name] for name in kind.landmarks], dtype=np.float64)
    )
    for relabelling in kind.relabellings:
        yield onto.at_relabelled(places, relabelling)
