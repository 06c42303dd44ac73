"""One template of several garments of a kind: mean proportions, and how far they differ."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from foldrs.drafting.corners import refined, size_of, symmetrised
from foldrs.drafting.draft import DECIMALS, Draft
from foldrs.drafting.halves import Places
from foldrs.drafting.matching import partners_of
from foldrs.drafting.pairs import grasp_pairs
from foldrs.drafting.parameters import DraftParameters
from foldrs.drafting.places import apart
from foldrs.errors import ParameterError
from foldrs.parameters import JointFitParameters
from foldrs.registration import local_similarities
from foldrs.template import Template

Points = NDArray[np.float64]

_ROUNDS = 5  # of laying the garments upon their mean; it stands still after two


def mean_template(drafts: Sequence[Draft], *, parameters: DraftParameters | None = None) -> Template:
    """Make one template of the drafts of several garments of a kind.

    The corners of the first are found on all others: by landmarks of the same names where names were given,
    else by matching the outlines. The garments are laid upon each other by similarities; the means are the
    template, and the spreads of the landmarks about them go into its ``spread``, drawn towards the usual
    spread the more the fewer the garments.

    Parameters
    ----------
    drafts : sequence of Draft
        Two or more. Left and right are interchangeable where all have a mirror axis: then the template is
        symmetric.
    parameters : DraftParameters, optional

    Raises
    ------
    ParameterError
        If there are fewer than two, or they are of several kinds or landmarks named differently.
    """
    p = parameters or DraftParameters()
    first = drafts[0] if drafts else None
    if first is None or len(drafts) < 2:
        raise ParameterError("a mean needs two garments or more")
    kinds = sorted({draft.template.garment_type for draft in drafts})
    if len(kinds) > 1:
        raise ParameterError(f"the garments are of several kinds, {', '.join(kinds)}: give one kind")
    if len({frozenset(draft.marks) if draft.named else None for draft in drafts}) > 1:
        raise ParameterError("the garments have landmarks of different names: give all of them the same")
    symmetric = all(draft.symmetric for draft in drafts)
    shapes = [refined(first.cut, first.places, p)]
    shapes += [refined(one.cut, _carried(first, one, p), p) for one in drafts[1:]]
    if symmetric:
        shapes = [symmetrised(shape, first.places) for shape in shapes]
    mean, laid = _laid_upon_each_other(shapes)
    squares = sum(((shape - mean) ** 2).sum(axis=1) / 2 for shape in laid)
    usual = JointFitParameters().shape * size_of(mean)
    weight = p.usual_garments
    spread = np.sqrt((squares + weight * usual**2) / (len(drafts) - 1 + weight))
    return _template(first, mean, spread, symmetric)


def _template(first: Draft, corners: Points, spread: NDArray[np.float64], symmetric: bool) -> Template:
    """Return the template of mean corners, with the landmarks of the first garment."""
    index = {name: int(apart(first.places, place).argmin()) for name, place in first.marks.items()}
    symmetry = first.template.symmetry if symmetric else ()
    kind = first.template.garment_type
    return Template(
        name=kind,
        garment_type=kind,
        units=first.template.units,
        outline=corners.round(DECIMALS),
        landmarks={name: corners[k].round(DECIMALS) for name, k in index.items()},
        symmetry=symmetry,
        grasp_pairs=tuple(
            pair for pair, _ in grasp_pairs({name: corners[k] for name, k in index.items()}, symmetry)
        ),
        spread={name: round(float(spread[k]), DECIMALS) for name, k in index.items()},
    )


def _carried(first: Draft, other: Draft, p: DraftParameters) -> Places:
    """Find the corners of one garment on another: their places, ascending around the outline."""
    if first.named:
        names = list(first.marks)
        one = np.array([first.marks[name] for name in names])
        two = np.array([other.marks[name] for name in names])
    else:
        one, two = partners_of(first.cut, other.cut, p)
    ahead = np.mod(two - one + 1.0, 2.0) - 1.0
    lead = np.interp(first.places, *_by_place(one, ahead), period=2.0)
    places = first.places + lead
    # Corners keep their order; where matching is unsure two may come to lie at one place.
    places = np.maximum.accumulate(places)
    return np.asarray(np.mod(places, 2.0), dtype=np.float64)


def _by_place(places: Places, values: NDArray[np.float64]) -> tuple[Places, NDArray[np.float64]]:
    order = np.argsort(places, kind="stable")
    return places[order], values[order]


def _laid_upon_each_other(shapes: Sequence[Points]) -> tuple[Points, list[Points]]:
    """Return the mean shape, of the mean size, and the shapes laid upon it by similarities."""
    size = math.exp(float(np.mean([math.log(size_of(shape)) for shape in shapes])))
    mean = shapes[0]
    laid = list(shapes)
    every = np.ones((1, len(mean)))
    place = np.zeros(len(mean), dtype=np.intp)
    for _ in range(_ROUNDS):
        mean = mean * (size / size_of(mean))
        laid = [local_similarities(every, shape, mean).apply(shape, place) for shape in shapes]
        mean = np.mean(laid, axis=0)
    return mean, laid
