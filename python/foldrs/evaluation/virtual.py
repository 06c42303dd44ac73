"""Synthetic scenes: templates folded virtually at random, outlines without photographs.

The protocol of the method's first evaluation: a template is matched with a fold of itself, so whatever goes
wrong is the matching's fault, not the template's, the cloth's or the picture's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.errors import ParameterError
from foldrs.evaluation.scenes import Scene, TrueLandmark
from foldrs.parameters import GraspParameters
from foldrs.synth import Garment, SynthParameters
from foldrs.synth.fold_lines import draw_fold
from foldrs.template import Template

Points = NDArray[np.float64]

PX_PER_CM = 4.0
"""Scale of the outlines: a garment of 60 cm fills half of a common picture."""


def virtual_scenes(templates: Sequence[Template], count: int, seed: int) -> list[tuple[Scene, Template]]:
    """Fold templates in turn, `count` folds in all, each in its own random place, turn and face.

    Scene k depends on `seed`, k and the templates alone.

    Raises
    ------
    ParameterError
        If there is no template, the count is not positive, or a template cannot be folded.
    """
    if not templates or count < 1:
        raise ParameterError("the synthetic protocol needs a template and a positive number of folds")
    chosen = [(k, templates[k % len(templates)]) for k in range(count)]
    digits = max(3, len(str(count)))
    return [
        (_folded(template, f"{template.name}-{k + 1:0{digits}d}", seed, k), template)
        for k, template in chosen
    ]


def _folded(template: Template, name: str, seed: int, number: int) -> Scene:
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    garment = Garment(
        template.garment_type, template.outline, template.landmarks, template.symmetry, template.name
    )
    fold = draw_fold(garment, rng, SynthParameters(flap_turn_deg=0.0))
    axis = fold.turn.axis
    layers = _core.fold_layers(template.outline, axis)
    pose = _random_pose(rng)
    return Scene(
        name=name,
        garment_type=template.garment_type,
        garment=template.name,
        scenario=fold.scenario,
        px_per_cm=PX_PER_CM,
        outline_garment=template.outline * PX_PER_CM,
        axis_garment=axis * PX_PER_CM,
        outline_image=_apply(pose, layers.outline),
        unfolded_image=_apply(pose, template.outline),
        landmarks=_landmarks(template, layers, axis, pose),
        axis_image=_apply(pose, axis),
    )


def _landmarks(
    template: Template, layers: _core.FoldedLayers, axis: Points, pose: Points
) -> dict[str, TrueLandmark]:
    """Where the landmarks come to lie, and which of them can be reached (section 3.2)."""
    marks, reach = template.landmark_array, GraspParameters()
    _, _, arc = _core.nearest_on_outline(template.outline, marks)
    now = np.where(layers.is_turned(arc)[:, None], _core.reflect(marks, axis), marks)
    _, off_outline, _ = _core.nearest_on_outline(layers.outline, now)
    on_outline = off_outline <= reach.on_outline
    accessible = on_outline & (layers.distance_to_double_layer(now) > reach.clearance)
    image = _apply(pose, now)
    return {
        name: TrueLandmark(marks[k] * PX_PER_CM, image[k], bool(on_outline[k]), bool(accessible[k]))
        for k, name in enumerate(template.landmarks)
    }


def _random_pose(rng: np.random.Generator) -> Points:
    """Draw a map (2, 3) from template cm to px: any turn, either face up."""
    angle, face = rng.uniform(0, 2 * np.pi), rng.choice([-1.0, 1.0])
    c, s = PX_PER_CM * np.cos(angle), PX_PER_CM * np.sin(angle)
    x, y = rng.uniform(200, 400, 2)
    return np.array([[c, -s * face, x], [s, c * face, y]])


def _apply(pose: Points, points: Points) -> Points:
    return np.ascontiguousarray(points @ pose[:, :2].T + pose[:, 2])
