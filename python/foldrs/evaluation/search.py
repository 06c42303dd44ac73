"""Whether the joint fit's search misses what it looks for.

A wrong answer has one of two causes: the truth was found and lost to something that explains the outline
better (ranking), or it was never found (search). The second shows where a fit that starts from the truth ends
with a better evidence than anything that the search has found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.camera import ViewFromAbove
from foldrs.errors import ParameterError
from foldrs.evaluation.axes import true_axes
from foldrs.evaluation.kinds import Kind
from foldrs.evaluation.scenes import Scene
from foldrs.joint_fit import flexible_template
from foldrs.parameters import Parameters
from foldrs.result import FitResult
from foldrs.template import Template

Points = NDArray[np.float64]

SAME_NATS = 0.5
"""Explanations whose evidence differs by less count as one: their iterations ended a little apart."""


def missed_nats(
    scene: Scene,
    result: FitResult,
    templates: Sequence[Template],
    kind: Kind,
    px_per_cm: float | None,
    parameters: Parameters | None = None,
) -> float:
    """How much better (nats) a start from the truth ends than what the search found; less than 0 if worse.

    Parameters
    ----------
    scene : Scene
        Folded once.
    result : FitResult
        What :func:`foldrs.fit` made of its true outline by the joint fit, with the scene's plane or without.
    templates : sequence of Template
        Those of the scene's kind that competed.
    kind : Kind
        Landmarks and symmetries of the scene's kind.
    px_per_cm : float or None
        The scale, if it was known; without meaning where the result was found in the view from above, which
        has its own.
    parameters : Parameters, optional

    Raises
    ------
    ParameterError
        If the scene does not tell where its crease lies in the image.
    """
    if scene.axis_image is None or scene.folds != 1:
        raise ParameterError(f"{scene.name}: the search is measured on scenes folded once, with axis_image")
    outline, crease = scene.outline_image, scene.axis_image
    if scene.plane is not None and result.from_above is not None:
        # Evidence is comparable only between fits to one outline: here the one seen from above.
        view = ViewFromAbove.of(scene.plane, result.outline_image)
        outline, crease = result.from_above.result.outline_image, view.from_image(crease)
        px_per_cm = result.from_above.px_per_cm
    crease = _cloth_on_left(crease, outline)
    matching = asdict((parameters or Parameters()).matching)
    seen = _core.Seen(np.ascontiguousarray(outline), matching)
    surprises = [
        fit.surprise
        for template in templates
        for fit in _core.fit_known(
            seen,
            flexible_template(template, matching),
            list(_true_folds(scene, crease, template, kind)),
            px_per_cm,
        )
    ]
    return result.matching_cost - min(surprises, default=np.inf)


def _true_folds(
    scene: Scene, crease: Points, template: Template, kind: Kind
) -> Iterator[tuple[Points, Points, bool]]:
    """Yield the true fold of a template, once for every symmetry, either part being the flap, on either face.

    Which part was turned over and which face is seen the outline does not tell.
    """
    for axis in true_axes(scene, template.outline, template.landmarks, kind):
        for directed in (axis, axis[::-1]):
            for mirrored in (False, True):
                yield np.ascontiguousarray(directed), crease, mirrored


def _cloth_on_left(crease: Points, outline: Points) -> Points:
    """Direct a crease so that the folded garment lies on its left (from x towards y)."""
    along, to_cloth = crease[1] - crease[0], outline.mean(axis=0) - crease[0]
    left = along[0] * to_cloth[1] - along[1] * to_cloth[0] > 0
    return np.ascontiguousarray(crease if left else crease[::-1])
