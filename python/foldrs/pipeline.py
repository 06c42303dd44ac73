"""The method, from a photograph to grasp points: :func:`fit` is its table of contents."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from numbers import Real
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs import _core
from foldrs._parameter_checks import check_parameters
from foldrs._stopwatch import Stopwatch
from foldrs._template_fields import shown
from foldrs.alternatives import distinct, with_probabilities
from foldrs.camera import Camera, Pose, TablePlane
from foldrs.errors import NoHypothesisError, ParameterError
from foldrs.explanation import Explanation
from foldrs.fitting import IterativeFit, fit_iteratively
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
    templates: Sequence[TemplateLike] | TemplateLike | None = None,
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
        Use these, or this one, instead of the built-in ones.
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
    check_options(px_per_cm=px_per_cm, folds=folds, method=method, parameters=parameters)
    folds = plain_folds(folds)
    parameters = parameters or Parameters()
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

    fits: Sequence[IterativeFit] = ()
    if method == "paper":
        fits = fit_iteratively(seen, chosen, px_per_cm, parameters.fitting, parameters.alternatives, clock)
        explanations = [one.explanation for one in fits]
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
    stages = _stages_behind(best[0], explanations, fits, seen)
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


def _stages_behind(
    chosen: Explanation, explanations: Sequence[Explanation], fits: Sequence[IterativeFit], seen: _core.Seen
) -> tuple[FittingPass, ...]:
    """Return the passes of the fit that the chosen one of the explanations, one a fit, comes from, if any."""
    # The chosen one may have been weighted since, which leaves its folds the very objects they were.
    for fitted, one in zip(fits, explanations, strict=False):
        if one.folds is chosen.folds:
            return fitting_passes(fitted, seen)
    return ()


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
    alternatives = with_probabilities(explanations, temperature)
    among = [(e, a.probability) for e, a in zip(explanations, alternatives, strict=True)]
    model = FoldedModel(best, px_per_unit, grasp, outline, among)
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
        alternatives=alternatives,
        image=image,
        candidate_creases=candidate_creases,
        stages=stages,
    )


def choose_templates(
    templates: Sequence[TemplateLike] | TemplateLike | None,
    garment_type: str | None,
    method: Method = "best",
) -> list[Template]:
    """Choose the templates that compete: the given or built-in ones, of one kind if a kind is given.

    The published method has one template a kind: of the built-in ones that of mean proportions, named like
    the kind. It chooses by cost, and would choose a kind for having more templates.

    Raises
    ------
    ParameterError
        None is of that kind, or what is given is neither a template nor a path.
    TemplateError
        A file is no template, or no built-in one is of that kind.
    """
    if templates is None:
        builtin = builtin_templates(garment_type)
        return [one for one in builtin if method == "best" or one.name == one.garment_type]
    given = [templates] if isinstance(templates, (Template, str, os.PathLike)) else templates
    if not isinstance(given, Iterable) or isinstance(given, (Mapping, bytes)):
        raise ParameterError(f"templates must be a list of templates or paths, not {_named(given)}")
    loaded = [_as_template(one) for one in given]
    chosen = [t for t in loaded if garment_type is None or t.garment_type == garment_type]
    if not chosen:
        kinds = ", ".join(sorted({t.garment_type for t in loaded})) or "none at all"
        raise ParameterError(f"no template of kind {garment_type!r} is among those given ({kinds})")
    return chosen


def _as_template(given: TemplateLike) -> Template:
    """Return a template, given as one or as the path of its file."""
    if isinstance(given, Template):
        return given
    if isinstance(given, (str, os.PathLike)):
        return load_template(given)
    raise ParameterError(
        f"templates must be templates or paths, not {_named(given)}: Template.from_dict makes one of fields"
    )


def _named(value: object) -> str:
    """Return a value that is no template as an error message names it."""
    return f"{shown(value)} ({type(value).__name__})"


def check_options(
    *,
    px_per_cm: float | None = None,
    folds: Folds = 1,
    method: Method = "best",
    parameters: Parameters | None = None,
    **_: object,
) -> None:
    """Raise ParameterError unless these options of :func:`fit` can be worked with; others pass."""
    check_scale(px_per_cm)
    check_method(method)
    check_folds(folds, method)
    if parameters is not None:
        check_parameters(parameters)


def check_scale(px_per_cm: float | None) -> None:
    """Raise ParameterError unless the scale is unknown or positive and finite."""
    if px_per_cm is None:
        return
    # True is a number to Python, and no scale to anyone.
    is_number = isinstance(px_per_cm, Real) and not isinstance(px_per_cm, bool)
    if not (is_number and math.isfinite(px_per_cm) and px_per_cm > 0):
        raise ParameterError(
            f"px_per_cm must be a positive number of pixels a centimetre, not {shown(px_per_cm)}"
        )


def check_folds(folds: Folds, method: Method) -> None:
    """Raise ParameterError unless so many folds can be undone by the method."""
    number = plain_folds(folds)
    if method == "paper" and number != 1:
        raise ParameterError(f"the published method undoes one fold, not {number}: use method 'best'")


def plain_folds(folds: Folds) -> Folds:
    """Return the number of folds, a whole number of any type, as an int, or "auto" as it is.

    Raises
    ------
    ParameterError
        It is neither, or no number from 0 to `MOST_FOLDS`.
    """
    if isinstance(folds, str) and folds == "auto":
        return folds
    # True is a whole number to Python, and no number of folds to anyone.
    if not isinstance(folds, (bool, str)):
        try:
            number = operator.index(folds)
        except TypeError:
            number = -1
        if 0 <= number <= MOST_FOLDS:
            return number
    raise ParameterError(f"folds must be a whole number from 0 to {MOST_FOLDS} or 'auto', not {folds!r}")


def check_method(method: str) -> None:
    """Raise ParameterError unless there is such a method."""
    if method not in get_args(Method):
        raise ParameterError(f"there is no method {method!r}: choose one of {', '.join(get_args(Method))}")
