"""The measures of one scene (section 4.1), of a prediction in its JSON form.

==================== ========================================================================================
type                 the garment's kind was recognised
segmentation         overlap (intersection over union) of the segmented and the true outline
dA, dtheta           error of the axis on the template, see :mod:`~foldrs.evaluation.axes`; right if dA < 0.1
CLRm, CLRf           right after the matching stage (original template), after the fitting stage (fitted one)
top 3                the best of the first three alternatives is right
NMM                  a right hypothesis was among the alternatives, but a wrong one was verified
MCD                  decrease of the matching cost from the original to the fitted template (eq. 5), %
landmarks            error of the landmarks that truly lie on the outline
pair                 the first grasp pair is truly accessible, both points within the grasp margin; asked for
                     only where two landmarks or more are accessible
missed               a fit from the truth ends better than anything that was found; only if asked for
unfolded             overlap of the predicted and the true unfolded outline in the picture; which part was
                     turned over cannot be told, so its mirror image over the crease is as good
folds                the number of folds is right
creases              scenes folded twice: which of the creases seen a predicted axis meets (dA < 0.1)
EucDist              distance of the template's outline from the garment's, before folding
==================== ========================================================================================

Of all symmetries of the kind the one kindest to the prediction counts. Scenes pictured at an angle are
measured in the view from above, see :mod:`~foldrs.evaluation.rectified`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs.evaluation.axes import axis_error
from foldrs.evaluation.geometry import (
    area,
    cut_to,
    hull_share,
    iou,
    iou_by_rigid_motion,
    mirrored,
)
from foldrs.evaluation.kinds import Kind, Relabelling
from foldrs.evaluation.rectified import prediction_from_above, scene_from_above
from foldrs.evaluation.scenes import Scene

Points = NDArray[np.float64]

RIGHT = 0.1
"""Largest dA of a right localisation (section 4.1)."""
GRASP_MARGIN_CM = 5.0
"""How far a grasp point may be off (section 4.1)."""
FIRST_ALTERNATIVES = 3
"""Alternatives a planner would look at."""


@dataclass(frozen=True)
class SceneMeasures:
    """The measures of one scene; None or empty where one does not apply."""

    scene: str
    garment_type: str
    garment: str
    scenario: str
    folds: int
    """True number of folds."""
    px_per_cm: float
    error: str = ""
    """Why there is no prediction; every rate counts it as a failure."""
    predicted_type: str = ""
    folds_found: int | None = None
    """Number of folds of the prediction."""
    type_right: bool = False
    segmentation_iou: float = 0.0
    template_distance_cm: float | None = None
    """EucDist."""
    axis_error_matched: float | None = None
    """dA on the original template."""
    axis_error: float | None = None
    """dA on the fitted template."""
    axis_angle: float | None = None
    """dtheta on the fitted template, degrees."""
    right_matched: bool | None = None
    right: bool | None = None
    right_in_first: bool | None = None
    mismatch: bool | None = None
    """NMM: wrong though a right hypothesis was tested."""
    cost_decrease: float | None = None
    """MCD, %."""
    landmarks_px: tuple[float, ...] = ()
    """Error of every landmark that truly lies on the outline."""
    pair_due: bool = True
    pair_right: bool | None = None
    pair_said: float | None = None
    """Probability told for the first grasp pair; None if there is no pair, or none is told."""
    unfolded_iou: float = 0.0
    creases_met: tuple[bool, ...] = ()
    chances: tuple[tuple[float, bool], ...] = ()
    """Of every alternative its probability, and whether it is the right one, the first with a right axis."""
    missed_nats: float | None = None
    """How much better a start from the truth ends than what the search found, see
    :mod:`~foldrs.evaluation.search`; None unless asked for."""
    seconds: float | None = None

    @property
    def landmarks_cm(self) -> tuple[float, ...]:
        """Error of every landmark that truly lies on the outline, cm."""
        return tuple(error / self.px_per_cm for error in self.landmarks_px)


def failed(scene: Scene, reason: str) -> SceneMeasures:
    """Return the measures of a scene without prediction: a failure in every rate."""
    asked = False if scene.folds == 1 else None
    return SceneMeasures(
        scene=scene.name,
        garment_type=scene.garment_type,
        garment=scene.garment,
        scenario=scene.scenario,
        folds=scene.folds,
        px_per_cm=scene.px_per_cm,
        error=reason,
        right_matched=asked,
        right=asked,
        right_in_first=asked,
        pair_right=asked,
        mismatch=asked,
    )


def measure(scene: Scene, prediction: Mapping[str, Any], kind: Kind) -> SceneMeasures:
    """Measure a prediction against the truth.

    Parameters
    ----------
    scene : Scene
        The truth.
    prediction : mapping
        The result's JSON form, :meth:`foldrs.FitResult.to_dict`: what is measured is what was written.
    kind : Kind
        Landmarks and symmetries of the scene's kind.

    Raises
    ------
    CalibrationError
        The scene was pictured at an angle, and the prediction lies beyond the table's horizon.
    """
    if scene.plane is not None:
        prediction = prediction_from_above(scene, prediction)
        scene = scene_from_above(scene)
    row = replace(
        failed(scene, ""),
        predicted_type=prediction["garment_type"],
        type_right=prediction["garment_type"] == scene.garment_type,
        folds_found=len(prediction["folds"]),
        segmentation_iou=iou(_points(prediction["outline_image"]), scene.outline_image),
        cost_decrease=_cost_decrease(prediction),
        pair_said=next((pair.get("probability") for pair in prediction["grasp_pairs"]), None),
        seconds=prediction.get("seconds"),
    )
    if scene.folds == 2:
        return _measure_twice(row, scene, prediction) if row.type_right else row
    if scene.folds == 0:
        return _measure_flat(row, scene, prediction, kind) if row.type_right else row
    row = _measure_alternatives(row, scene, prediction, kind)
    if not row.type_right:
        return row
    matched, _ = axis_error(scene, prediction["original_template"], kind)
    fitted, angle = axis_error(scene, prediction["template"], kind)
    unfolded = _points(prediction["unfolded_outline_image"])
    shapes = [unfolded]
    if prediction["fold"] is not None:
        shapes.append(mirrored(unfolded, _points(prediction["fold"]["axis_image"])))
    row = replace(
        row,
        axis_error_matched=matched,
        axis_error=fitted,
        axis_angle=angle,
        right_matched=matched < RIGHT,
        right=fitted < RIGHT,
        unfolded_iou=max(iou(shape, scene.unfolded_image) for shape in shapes),
    )
    return _measure_landmarks(row, scene, prediction, kind)


def _measure_alternatives(
    row: SceneMeasures, scene: Scene, prediction: Mapping[str, Any], kind: Kind
) -> SceneMeasures:
    """Whether the first few alternatives hold a right one, and whether any but the chosen one is right."""
    told = prediction.get("alternatives", [])
    right = [
        one["garment_type"] == scene.garment_type and axis_error(scene, one["template"], kind)[0] < RIGHT
        for one in [prediction, *told[1:]]
    ]
    said = [float(one["probability"]) for one in told if "probability" in one]
    the_right_one = [ok and not any(right[:k]) for k, ok in enumerate(right)]
    return replace(
        row,
        right_in_first=any(right[:FIRST_ALTERNATIVES]),
        mismatch=any(right[1:]) and not right[0],
        chances=tuple(zip(said, the_right_one, strict=False)),
    )


def _measure_landmarks(
    row: SceneMeasures, scene: Scene, prediction: Mapping[str, Any], kind: Kind
) -> SceneMeasures:
    """Landmark errors under the symmetry that makes their mean least, and the grasp pair under the same."""
    on_outline = [k for k, name in enumerate(kind.landmarks) if scene.landmarks[name].on_outline]
    due = sum(mark.accessible for mark in scene.landmarks.values()) >= 2
    if not on_outline:
        return replace(row, pair_due=due)
    true = np.array([scene.landmarks[kind.landmarks[k]].image for k in on_outline])
    found = _points([prediction["landmarks"][name]["image"] for name in kind.landmarks])

    def errors(relabelling: Relabelling) -> Points:
        called = [relabelling[k] for k in on_outline]
        return np.asarray(np.linalg.norm(found[called] - true, axis=1), dtype=np.float64)

    best = min(kind.relabellings, key=lambda relabelling: float(errors(relabelling).mean()))
    return replace(
        row,
        landmarks_px=tuple(errors(best).tolist()),
        pair_due=due,
        pair_right=_pair_right(scene, prediction, kind, best),
    )


def _pair_right(scene: Scene, prediction: Mapping[str, Any], kind: Kind, relabelling: Relabelling) -> bool:
    """Whether both points of the first grasp pair are truly accessible and near enough to grasp."""
    if not prediction["grasp_pairs"]:
        return False
    pair = prediction["grasp_pairs"][0]
    true_name = {kind.landmarks[new]: kind.landmarks[k] for k, new in enumerate(relabelling)}
    for name, point in zip(pair["landmarks"], pair["image"], strict=True):
        if name not in true_name:
            return False
        mark = scene.landmarks[true_name[name]]
        off_cm = float(np.linalg.norm(np.asarray(point) - mark.image)) / scene.px_per_cm
        if not mark.accessible or off_cm > GRASP_MARGIN_CM:
            return False
    return True


def _measure_flat(
    row: SceneMeasures, scene: Scene, prediction: Mapping[str, Any], kind: Kind
) -> SceneMeasures:
    """Scenes in which nothing is folded: the garment as it lies."""
    unfolded = _points(prediction["unfolded_outline_image"])
    return _measure_landmarks(
        replace(row, unfolded_iou=iou(unfolded, scene.unfolded_image)), scene, prediction, kind
    )


def _measure_twice(row: SceneMeasures, scene: Scene, prediction: Mapping[str, Any]) -> SceneMeasures:
    """Scenes folded twice: what was unfolded, however it lies, and which of the creases seen were found."""
    whole = area(scene.unfolded_image)
    axes = [_points(fold["axis_image"]) for fold in prediction["folds"]]

    def met(crease: Points) -> bool:
        beside = (cut_to(axis, crease) for axis in axes)
        return any(piece is not None and hull_share(piece, crease, whole) < RIGHT for piece in beside)

    return replace(
        row,
        unfolded_iou=iou_by_rigid_motion(_points(prediction["unfolded_outline_image"]), scene.unfolded_image),
        creases_met=tuple(met(crease) for crease in scene.creases),
    )


def _cost_decrease(prediction: Mapping[str, Any]) -> float | None:
    before, after = prediction["original_matching_cost"], prediction["matching_cost"]
    return 100 * (before - after) / before if before > 0 else None


def _points(values: object) -> Points:
    return np.asarray(values, dtype=np.float64)
