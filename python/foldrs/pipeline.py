"""The method, from a photograph to grasp points: :func:`fit` is its table of contents."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs import _core
from foldrs._stopwatch import Stopwatch
from foldrs.alternatives import distinct, with_probabilities
from foldrs.camera import Camera, Pose, TablePlane
from foldrs.errors import NoHypothesisError, ParameterError
from foldrs.explanation import Explanation
from foldrs.fitting import fit_iteratively
from foldrs.joint_fit import Folds, fit_jointly
from foldrs.model import FoldedModel
from foldrs.outline import find_outline
from foldrs.parameters import GraspParameters, Parameters
from foldrs.picture import seen_inside, with_heights
from foldrs.result import FitResult, FittedTemplate
from foldrs.scale import Reference
from foldrs.stages import FittingPass, fitting_passes
from foldrs.survey import survey
from foldrs.template import Template, builtin_templates, load_template

Source: TypeAlias = str | os.PathLike[str] | ArrayLike
Method: TypeAlias = Literal["best", "paper"]
MOST_FOLDS = 4
"""More folds than this leave too little of a garment's outline to tell them by."""

TemplateLike: TypeAlias = Template | str | os.PathLike[str]


def fit(
    source: Source,
    *,
    garment_type: str | None = None,
    templates: Sequence[TemplateLike] | None = None,
    px_per_cm: float | None = None,
    folds: Folds = 1,
    method: Method = "best",
    mask: Source | None = None,
    table: TablePlane | Reference | None = None,
    camera: Camera | None = None,
    depth: Source | None = None,
    robot_base: Pose | None = None,
    parameters: Parameters | None = None,
) -> FitResult:
    """Explain one folded garment: which it is, where it is folded, where its landmarks are.

    Parameters
    ----------
    source : path, image array, boolean mask or (n, 2) points
        A photograph, a mask of the garment, or its outline.
    garment_type : str, optional
        Match templates of this kind only; without it all compete and the best one names the kind.
    templates : sequence of Template or path, optional
        Use these instead of the built-in ones.
    px_per_cm : float, optional
        Known scale, px a template unit. Without it the scale is found.
    folds : int or "auto"
        How many folds to undo; "auto": as many as explain more than their freedom costs, none for a garment
        that lies flat. The published method undoes one.
    method : {"best", "paper"}
        The published method, or whatever is most accurate.
    mask : path or (h, w) array, optional
        The garment's mask; the photograph is not segmented then.
    table : TablePlane, Marker or Sheet, optional
        The plane of the table, or what of known size lies on it and tells the plane: a
        :class:`foldrs.scale.Marker` or :class:`foldrs.scale.Sheet`. The scale is known then, the camera may
        look at an angle, and the result is told in cm on the table as well. Without it the picture is taken
        to be one from straight above.
    camera : Camera, optional
        Intrinsic parameters of the camera, for markers, sheets and depth images; a `TablePlane` has its own.
    depth : path or (h, w) array, optional
        Distance along the camera's axis, pixel on pixel with the photograph: whole numbers are mm, floats m.
        With a `camera` it tells the table's plane too.
    robot_base : Pose, optional
        The table's frame in that of the robot's base; the result is told there as well, in metres.
    parameters : Parameters, optional
        Parameters of all stages.

    Returns
    -------
    FitResult

    Raises
    ------
    FoldrsError
        One of `foldrs.errors`, which says what was wrong with the input.

    Examples
    --------
    A towel, 4 px a centimetre, one corner of which is turned over:

    >>> seen = [[0, 0], [200, 0], [200, 160], [100, 260], [0, 260]]
    >>> result = fit(seen, garment_type="towel", px_per_cm=4)
    >>> result.accepted
    True
    >>> sorted(result.fold.axis_image.round().tolist())
    [[100.0, 260.0], [200.0, 160.0]]
    >>> sum(mark.accessible for mark in result.landmarks.values())
    3
    """
    clock = Stopwatch()
    parameters = parameters or Parameters()
    check_scale(px_per_cm)
    check_method(method)
    check_folds(folds, method)
    chosen = choose_templates(templates, garment_type, method)

    ground = survey(
        source,
        mask,
        px_per_cm=px_per_cm,
        table=table,
        camera=camera,
        depth=depth,
        robot_base=robot_base,
        parameters=parameters,
    )
    clock.lap("view")
    found = find_outline(ground.source, mask=ground.mask, parameters=parameters.outline)
    sight = ground.sight(found)
    px_per_cm = sight.px_per_cm or px_per_cm
    clock.lap("outline")
    seen = _core.Seen(sight.points, asdict(parameters.matching))

    stages: tuple[FittingPass, ...] = ()
    if method == "paper":
        fits = fit_iteratively(seen, chosen, px_per_cm, parameters.fitting, parameters.alternatives, clock)
        explanations = [one.explanation for one in fits]
        stages = fitting_passes(fits[0], seen) if fits else ()
        temperature = parameters.alternatives.temperature
        grasp = replace(parameters.grasp, snap_corner=parameters.fitting.snap_corner)
    else:
        picture = None if sight.rgb is None else seen_inside(sight.rgb, sight.points, parameters.picture)
        if picture is not None and sight.heights is not None:
            edges = with_heights(picture.edges, sight.heights, parameters.depth.step_blur)
            picture = replace(picture, edges=edges)
        clock.lap("picture")
        explanations = fit_jointly(seen, chosen, px_per_cm, picture, folds, parameters)
        clock.lap("matching")
        temperature = parameters.alternatives.nats
        grasp = parameters.grasp
    best = distinct(explanations, chosen, temperature, parameters.alternatives)
    if not best:
        raise NoHypothesisError(
            "no fold of any template could be compared with the outline: "
            "check the scale (px_per_cm) and that the templates are of the garment's kind"
        )
    clock.lap("alternatives")

    result = result_of(
        best,
        sight.points,
        grasp,
        image=Path(source).name if isinstance(source, (str, os.PathLike)) else "",
        temperature=temperature,
        candidate_creases=tuple(seen.sides),
        stages=stages,
    )
    result = sight.in_photograph(result)
    clock.lap("model")
    return replace(result, seconds=clock.seconds, timings=dict(clock.stages))


def result_of(
    explanations: Sequence[Explanation],
    outline: NDArray[np.float64],
    grasp: GraspParameters,
    *,
    image: str,
    temperature: float,
    candidate_creases: tuple[NDArray[np.float64], ...] = (),
    stages: tuple[FittingPass, ...] = (),
) -> FitResult:
    """Build the result from distinct explanations, the chosen one first."""
    best = explanations[0]
    px_per_unit = math.sqrt(abs(float(np.linalg.det(best.to_image[:, :2]))))
    model = FoldedModel(best, px_per_unit, grasp, outline)
    return FitResult(
        garment_type=best.template.garment_type,
        accepted=best.accepted,
        matching_cost=best.cost,
        original_matching_cost=best.original_cost,
        outline_image=outline,
        folds=best.folds,
        original_template=FittedTemplate(
            best.template.outline, dict(best.template.landmarks), best.original_axis
        ),
        template=best.fitted,
        unfolded_outline_image=model.unfolded_outline,
        landmarks=model.landmarks,
        grasp_pairs=model.grasp_pairs,
        unfolding=model.unfolding,
        unfolding_plan=model.unfolding_plan,
        alternatives=with_probabilities(explanations, temperature),
        image=image,
        candidate_creases=candidate_creases,
        stages=stages,
    )


def choose_templates(
    templates: Sequence[TemplateLike] | None, garment_type: str | None, method: Method = "best"
) -> list[Template]:
    """Choose the templates that compete: the given or built-in ones, of one kind if a kind is given.

    The published method has one template a kind: of the built-in ones that of mean proportions, named like
    the kind. It chooses by cost, and would choose a kind for having more templates.
    """
    if templates is None:
        builtin = builtin_templates(garment_type)
        return [one for one in builtin if method == "best" or one.name == one.garment_type]
    loaded = [t if isinstance(t, Template) else load_template(t) for t in templates]
    chosen = [t for t in loaded if garment_type is None or t.garment_type == garment_type]
    if not chosen:
        kinds = ", ".join(sorted({t.garment_type for t in loaded})) or "none at all"
        raise ParameterError(f"no template of kind {garment_type!r} is among those given ({kinds})")
    return chosen


def check_scale(px_per_cm: float | None) -> None:
    """Raise ParameterError unless the scale is unknown or positive and finite."""
    if px_per_cm is not None and not (math.isfinite(px_per_cm) and px_per_cm > 0):
        raise ParameterError(f"px_per_cm must be a positive number of pixels a centimetre, not {px_per_cm}")


def check_folds(folds: Folds, method: Method) -> None:
    """Raise ParameterError unless so many folds can be undone by the method."""
    if folds == "auto" or (isinstance(folds, int) and 0 <= folds <= MOST_FOLDS):
        if method == "paper" and folds != 1:
            raise ParameterError(f"the published method undoes one fold, not {folds}: use method 'best'")
        return
    raise ParameterError(f"folds must be a whole number from 0 to {MOST_FOLDS} or 'auto', not {folds!r}")


def check_method(method: str) -> None:
    """Raise ParameterError unless there is such a method."""
    if method not in get_args(Method):
        raise ParameterError(f"there is no method {method!r}: choose one of {', '.join(get_args(Method))}")
