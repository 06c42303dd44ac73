"""A template drafted from the outline of one flat garment: :func:`draft_template` lists the steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs._mending import simple_outline
from foldrs._template_fields import field_error, parse_point, parse_word
from foldrs.drafting.corners import corners_of, refined, salient_corners, symmetrised
from foldrs.drafting.halves import Halves, Places, halves, mirrored
from foldrs.drafting.matching import matched
from foldrs.drafting.pairs import generic_names, grasp_pairs, mirror_pairs
from foldrs.drafting.parameters import DraftParameters
from foldrs.drafting.places import apart, joined, marked_places, snapped
from foldrs.drafting.symmetry import MirrorAxis, mirror_axis
from foldrs.drafting.upright import as_given, map_to_upright
from foldrs.errors import ParameterError
from foldrs.explanation import apply
from foldrs.outline import as_outline
from foldrs.template import Template

Points = NDArray[np.float64]

SKIP = "-"
"""In a list of names: this corner is no landmark."""

DECIMALS = 2
"""Of the coordinates of a template, in centimetres: a tenth of a millimetre."""


@dataclass(frozen=True, eq=False)
class Draft:
    """A template, and how it came about."""

    template: Template
    outline: Points
    """(n, 2) the outline it was made of."""
    mirror: MirrorAxis
    """The mirror axis, in the frame of the outline given."""
    symmetric: bool
    """Whether the garment has one: otherwise there are no mirror pairs and it is upright as given."""
    reasons: tuple[str, ...]
    """Why each grasp pair is proposed, in their order."""
    to_template: Points
    """(2, 3) map from the frame of the outline to template units."""
    cut: Halves
    """The outline there, by its halves."""
    places: Places
    """(n,) where on it the template's corners lie."""
    marks: Mapping[str, float]
    """Where on it the landmarks lie."""
    named: bool
    """Whether the landmarks were named, and not by number."""


def draft_template(
    outline: ArrayLike,
    garment_type: str,
    *,
    landmarks: Sequence[str] | Mapping[str, ArrayLike] = (),
    symmetric: bool = False,
    px_per_cm: float | None = None,
    size_cm: float | None = None,
    name: str = "",
    parameters: DraftParameters | None = None,
) -> Draft:
    """Draft a template of the outline of a flat garment.

    The outline is turned upright about its mirror axis, and simplified to straight sides; the corners that
    stand out become landmarks, paired with their mirror images, and grasp pairs are proposed.

    Parameters
    ----------
    outline : (n, 2) array_like
        The unfolded garment's outline, in px or any unit, y down, its upper end up.
    garment_type : str
        The kind.
    landmarks : sequence of str, or mapping of str to (2,) array_like
        Names for the corners, from the top down the left side and up the right one, ``-`` for one that is no
        landmark: as many corners are looked for. Or the landmarks themselves, in the frame of the outline;
        they are moved to a corner or onto the outline. By default corners get names like ``corner_left_1``.
    symmetric : bool
        Make the template its own mirror image: the mean of both halves.
    px_per_cm, size_cm : float, optional
        The scale, or the longer side of the upright garment in cm; by default a size is assumed.
    name : str, optional
        Name of the template; the kind by default.
    parameters : DraftParameters, optional

    Raises
    ------
    InvalidOutlineError
        If the points are no outline.
    ParameterError
        If both scale and size are given or one is not positive, if the garment is to be symmetric and is not,
        or if it has no corners for that many names.
    TemplateError
        If names are given twice or a landmark lies off the outline; its `field` says which.
    """
    p = parameters or DraftParameters()
    points = simple_outline(as_outline(outline))
    mirror = mirror_axis(points, p)
    has_axis = mirror.deviation <= p.asymmetric
    if symmetric and not has_axis:
        raise ParameterError(
            f"the garment is not its own mirror image ({mirror.deviation:.0%} of the area differ, "
            f"{p.asymmetric:.0%} may): leave symmetric out, or lay it out more evenly"
        )
    if not has_axis:
        mirror = as_given(points, mirror.deviation)
    to_upright = map_to_upright(points, mirror, px_per_cm, size_cm, p)
    cut = halves(apply(to_upright, points))
    cut = matched(cut, p) if has_axis else cut
    places = corners_of(cut, p.outline_tolerance, has_axis, p)
    if isinstance(landmarks, Mapping):
        names = list(landmarks)
        spots = [apply(to_upright, parse_point(at, f"landmarks.{n}")[None])[0] for n, at in landmarks.items()]
        marked = marked_places(cut, names, np.array(spots).reshape(-1, 2), places, p)
    else:
        marked = snapped(salient_corners(cut, len(landmarks), has_axis, p), places, p.same_corner)
        names = list(landmarks) or generic_names(marked)
    # Landmarks are corners of the template, and so are their mirror images.
    places = joined(places, marked)
    if has_axis:
        places = joined(places, mirrored(marked))
    if symmetric:
        cut = cut.mean(p.samples)
        corners = symmetrised(refined(cut, places, p), places)
    else:
        # What only one of the halves has, their mean may not show.
        places = joined(places, corners_of(cut, p.outline_tolerance, False, p), gap=p.same_corner)
        corners = refined(cut, places, p)
    chosen = {
        n: int(apart(places, place).argmin()) for n, place in zip(names, marked, strict=True) if n != SKIP
    }
    _refuse_repeated(names)
    symmetry = mirror_pairs(list(chosen), places[list(chosen.values())], p) if has_axis else ()
    proposed = grasp_pairs({n: corners[k] for n, k in chosen.items()}, symmetry)
    template = Template(
        name=name or garment_type,
        garment_type=parse_word(garment_type, "type"),
        units="cm",
        outline=corners.round(DECIMALS),
        landmarks={n: corners[k].round(DECIMALS) for n, k in chosen.items()},
        symmetry=symmetry,
        grasp_pairs=tuple(pair for pair, _ in proposed),
    )
    reasons = tuple(why for _, why in proposed)
    marks = {n: float(places[k]) for n, k in chosen.items()}
    named = len(landmarks) > 0
    return Draft(template, points, mirror, has_axis, reasons, to_upright, cut, places, marks, named)


def _refuse_repeated(names: Sequence[str]) -> None:
    for n in names:
        if n != SKIP and list(names).count(n) > 1:
            raise field_error(f"landmarks.{n}", "given twice; names must be unique")
