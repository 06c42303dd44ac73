"""The ground truth of a scene, as a dictionary ready to be written as JSON.

The fields are those of folded-garment benchmarks: the garment frame is the unfolded garment in pixels of the
picture's scale, the image frame is the picture; (x, y), y down, an integer is the centre of a pixel.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from foldrs.synth.garment import Garment, Points
from foldrs.synth.layers import Fold, Layer, crease_pieces, layer_of
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.pose import Pose, seen_by
from foldrs.synth.raster import FINE, LayerMasks, Mask, outlines

_LARGEST_GAP_CM2 = 1.0
"""A hole, or a second piece, larger than this makes the seen outline ambiguous."""

_TOLERANCE_PX = 0.2
"""How far the outline written may leave the one drawn."""


def seen_outline(masks: LayerMasks, parameters: SynthParameters) -> Points | None:
    """Trace the cloth in the picture, px; None if it falls into pieces or has a hole."""
    largest, *others = outlines(masks.union())
    gap = _LARGEST_GAP_CM2 * (FINE * parameters.px_per_cm) ** 2
    if any(cv2.contourArea(other.astype(np.int32)) > gap for other in others):
        return None
    simple = cv2.approxPolyDP(largest.astype(np.int32).reshape(-1, 1, 2), _TOLERANCE_PX * FINE, closed=True)
    return masks.from_fine(np.asarray(simple, dtype=np.float64).reshape(-1, 2))


def describe(
    garment: Garment,
    folds: list[Fold],
    layers: list[Layer],
    pose: Pose,
    masks: LayerMasks,
    outline: Points,
    parameters: SynthParameters,
) -> dict[str, Any]:
    """Tell everything that is true of a scene.

    Parameters
    ----------
    garment : Garment
        The unfolded garment, cm.
    folds : list of Fold
        The folds, first made first; none of a flat garment.
    layers : list of Layer
        The layers of cloth, lowest first.
    pose : Pose
        How they lie in the picture.
    masks : LayerMasks
        Their areas in the picture.
    outline : ndarray of shape (n, 2)
        The seen outline, px.
    parameters : SynthParameters
        ``px_per_cm``, ``on_outline_cm`` and ``clear_cm``.
    """
    scale = parameters.px_per_cm
    truth: dict[str, Any] = {
        "type": garment.garment_type,
        "garment": garment.name,
        "px_per_cm": scale,
        **_first_fold(folds, pose, scale),
        "outline_garment": _written(garment.outline * scale),
        "unfolded_image": _written(pose.to_image(garment.outline)),
        "outline_image": _written(outline),
        "landmarks": _landmarks(garment, layers, pose, masks, outline, parameters),
    }
    if len(folds) > 1:
        second = folds[1]
        truth["second_fold"] = {
            "scenario": second.scenario,
            "axis_folded": _written(second.turn.axis * scale),
            "axis_image": _written(pose.to_image(second.turn.axis)),
            "flap_fraction": round(second.fraction, 4),
            "flap_under": second.under,
        }
    return truth


def seen_at_an_angle(truth: dict[str, Any], camera: Points) -> dict[str, Any]:
    """Tell the truth of a view from above for a camera that looks at an angle.

    Parameters
    ----------
    truth : dict
        What :func:`describe` tells.
    camera : ndarray of shape (3, 3)
        Homography from the view from above to the picture, px both.
    """

    def moved(points: Any) -> list[Any]:
        flat = np.asarray(points, dtype=np.float64)
        return _written(seen_by(camera, flat.reshape(-1, 2)).reshape(flat.shape))

    fields = ("axis_image", "unfolded_image", "outline_image")
    seen = truth | {field: moved(truth[field]) for field in fields if field in truth}
    seen["creases_image"] = [moved(crease) for crease in truth["creases_image"]]
    seen["landmarks"] = {
        name: mark | {"image": moved(mark["image"])} for name, mark in truth["landmarks"].items()
    }
    if "second_fold" in truth:
        second = truth["second_fold"]
        seen["second_fold"] = second | {"axis_image": moved(second["axis_image"])}
    return seen


def _first_fold(folds: list[Fold], pose: Pose, scale: float) -> dict[str, Any]:
    if not folds:
        return {"scenario": "flat", "axis_garment": None, "creases_image": []}
    first = folds[0]
    return {
        "scenario": first.scenario,
        "flap_fraction": round(first.fraction, 4),
        "flap_under": first.under,
        "axis_garment": _written(first.turn.axis * scale),
        "axis_image": _written(pose.to_image(first.turn.axis)),
        "creases_image": [_written(pose.to_image(piece)) for piece in crease_pieces(folds)],
    }


def _landmarks(
    garment: Garment,
    layers: list[Layer],
    pose: Pose,
    masks: LayerMasks,
    outline: Points,
    parameters: SynthParameters,
) -> dict[str, Any]:
    scale = parameters.px_per_cm
    ring = outline.astype(np.float32).reshape(-1, 1, 2)
    doubled = masks.doubled()
    found: dict[str, Any] = {}
    for name, point in garment.landmarks.items():
        layer = layer_of(layers, point)
        seen = pose.to_image(layer.place(point[None]))[0]
        off = abs(cv2.pointPolygonTest(ring, (float(seen[0]), float(seen[1])), True))
        on_outline = bool(off <= parameters.on_outline_cm * scale)
        covered = _any_within(doubled, masks.to_fine(seen), parameters.clear_cm * scale * FINE)
        found[name] = {
            "garment": _written(point * scale),
            "image": _written(seen),
            "on_flap": len(layer.turns) > 0,
            "on_outline": on_outline,
            "accessible": on_outline and not covered,
        }
    return found


def _any_within(mask: Mask, centre: Points, radius: float) -> bool:
    """Tell whether a mask has a set pixel within a distance of a point."""
    height, width = mask.shape
    x0, x1 = max(0, int(centre[0] - radius)), min(width, int(centre[0] + radius) + 2)
    y0, y1 = max(0, int(centre[1] - radius)), min(height, int(centre[1] + radius) + 2)
    y, x = np.nonzero(mask[y0:y1, x0:x1])
    return bool(((x + x0 - centre[0]) ** 2 + (y + y0 - centre[1]) ** 2 <= radius**2).any())


def _written(points: Points) -> list[Any]:
    """Return points as nested lists, to a hundredth of a pixel."""
    rounded: list[Any] = np.round(points, 2).tolist()
    return rounded
