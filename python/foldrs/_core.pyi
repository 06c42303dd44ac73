"""The compiled module: thin bindings of the Rust crate.

Outlines are (n, 2) float64 arrays of points in order, closed implicitly, in any units. An axis is a (2, 2)
array of two points; its left is the side towards which the direction x turns to y.
"""

from collections.abc import Mapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_Points = NDArray[np.float64]
_Edges = NDArray[np.float32]
_Looks = tuple[NDArray[np.uint8], float, tuple[float, float]]
_Picture = tuple[_Edges, float, _Edges | None, _Looks | None]

__all__ = [
    "Candidate",
    "Explanation",
    "FlexibleTemplate",
    "FoldedLayers",
    "FoldedStack",
    "JointExplanation",
    "JointFits",
    "Seen",
    "Stop",
    "__version__",
    "align",
    "alignment_costs",
    "axis_difference",
    "carried",
    "check_outline",
    "default_parameters",
    "fit_jointly",
    "fit_known",
    "fold_layers",
    "fold_stack",
    "inner_distances",
    "matching_costs",
    "mirrorings",
    "nearest_on_outline",
    "outline_iou",
    "partial_matches",
    "piece_difference",
    "points_at",
    "reflect",
    "resample",
    "set_threads",
    "shape_contexts",
    "sides",
    "signed_area",
    "simplify",
]

__version__: str

def set_threads(threads: int | None = None) -> int:
    """Set the size of the thread pool unless it is in use already; return the size it has."""

@final
class Stop:
    """Ends the long calls of the threads that heed it; a signal ends only what Python's main thread is at."""

    def __new__(cls) -> Stop: ...
    def heed(self) -> None:
        """Make the calling thread's long calls heed this; of several the last one counts."""

    def request(self) -> None:
        """Make long calls, running and to come, raise KeyboardInterrupt in every thread that heeds this."""

def default_parameters() -> dict[str, Any]:
    """Parameters of the crate's stages with their defaults, grouped by stage."""

def check_outline(points: _Points) -> None:
    """Raise InvalidOutlineError unless the points are a simple polygon with an area."""

def signed_area(points: _Points) -> float:
    """Area, positive if the points run from the x axis towards the y axis."""

def nearest_on_outline(points: _Points, query: _Points) -> tuple[_Points, _Points, _Points]:
    """Return for k query points the (k, 2) nearest points of the outline, their distances and arc lengths."""

def carried(points: _Points, outline: _Points, moved: _Points) -> _Points:
    """Carry points (k, 2) of an outline to another with as many corners, to like shares of its edges.

    Raises
    ------
    InvalidOutlineError
        If either has fewer than three corners, or one that is not finite.
    ValueError
        If they have not as many corners, or an array is of another shape than (n, 2).
    """

def points_at(points: _Points, arc: _Points) -> _Points:
    """Points (k, 2) of the outline at k arc lengths from its first vertex.

    Raises
    ------
    InvalidOutlineError
        If the points are no outline: fewer than three, not finite, or without an area.
    ValueError
        If they are of another shape than (n, 2).
    """

def resample(points: _Points, n: int) -> _Points:
    """Return n points at equal arc length, the first at the first vertex.

    Raises
    ------
    InvalidOutlineError
        If the points are no outline: fewer than three, not finite, or without an area.
    ValueError
        If they are of another shape than (n, 2), or n is less than three.
    """

def simplify(points: _Points, tolerance: float) -> _Points:
    """Corners of the Douglas-Peucker simplification of a closed outline."""

def sides(points: _Points, tolerance: float) -> list[_Points]:
    """Sides (2, 2) of the simplified outline, each the straight line through the points it stands for."""

def reflect(points: _Points, axis: _Points) -> _Points:
    """Mirror image of points over the axis's line.

    Raises
    ------
    ValueError
        If the axis has no direction, or the points are not of shape (n, 2).
    """

def axis_difference(a: _Points, b: _Points) -> float:
    """Area of the convex hull of the four end points of two axes."""

def outline_iou(a: _Points, b: _Points) -> float:
    """Intersection over union of two outlines."""

@final
class FoldedLayers:
    """An outline folded over an axis, layer by layer."""

    @property
    def kept(self) -> list[_Points]:
        """The pieces that stayed in place."""
    @property
    def flap(self) -> list[_Points]:
        """The pieces that were turned over, where they lie now."""
    @property
    def creases(self) -> list[_Points]:
        """The creased chords (2, 2), in the order of the axis."""
    @property
    def outline(self) -> _Points:
        """Outline of the union of all layers."""
    @property
    def holes(self) -> int:
        """Number of holes the outline encloses."""
    @property
    def double_layer(self) -> list[_Points]:
        """Rings (even-odd) of the region where two layers lie over each other."""
    def distance_to_double_layer(self, points: _Points) -> _Points:
        """Distance of every point from the double layer; 0 within it, inf if there is none."""
    def is_turned(self, arc: _Points) -> NDArray[np.bool_]:
        """Whether points of the unfolded outline, by arc length (modulo its length), are on the flap."""

def fold_layers(outline: _Points, axis: _Points) -> FoldedLayers:
    """Turn over what hangs on the left of the chords that the axis segment covers (section 2.1.2).

    Raises
    ------
    ValueError
        If the axis has no direction, or does not fold the outline.
    """

def partial_matches(
    seen_points: _Points, template_points: _Points, parameters: Mapping[str, Any]
) -> list[tuple[int, int, int, float, float]]:
    """Match pieces of two closed outlines by chord angles, the best first (section 2.1.1).

    Parameters
    ----------
    seen_points, template_points
        Points (m, 2) and (n, 2) at the same equal spacing, any units.
    parameters
        All parameters, as `default_parameters` gives them; the group ``partial_match`` is used, but not its
        ``points``: the points are taken as they are.

    Returns
    -------
    list of (start, template_start, length, difference, affinity)
        The pieces are the `length` points from `start` on, modulo m, and from `template_start` on, modulo n;
        the difference is in square radians (see `piece_difference`), the affinity in [0, 1).

    Raises
    ------
    ValueError
        If an outline has fewer than three points or one that is not finite, or a parameter is unknown.
    """

def piece_difference(
    seen_points: _Points,
    start: int,
    template_points: _Points,
    template_start: int,
    length: int,
    delta: int = 5,
) -> float:
    """Mean squared difference of the chord angles of two pieces of `length` points, in square radians.

    Points i and j = i + k of a piece, k > `delta`, have two chord angles (section 2.1.1): at j, from the
    chord to i to the chord to j - delta; and at i, from the chord to j to the chord to i + delta.

    Raises
    ------
    ValueError
        If a start is no point of its outline, or a piece of that length holds no angle or is no piece.
    """

def inner_distances(points: _Points) -> _Points:
    """Lengths (n, n) of the shortest paths inside an outline between its vertices (section 2.1.2).

    Raises
    ------
    ValueError
        If there are fewer than three points, or one is not finite.
    """

def shape_contexts(points: _Points, n_dist: int = 5, n_theta: int = 12) -> _Points:
    """Inner-distance shape contexts of an outline's n points, one histogram a row (section 2.1.2).

    Returns
    -------
    (n, n_dist * n_theta) array
        Shares of the other points by logarithm of their inner distance and direction of the path's first leg
        from the tangent; column ``distance * n_theta + direction``. Every row sums to 1.

    Raises
    ------
    ValueError
        If there are fewer than three points, one is not finite, or a number of bins is 0.
    """

def matching_costs(points_a: _Points, points_b: _Points, n_dist: int = 5, n_theta: int = 12) -> _Points:
    """Chi-squared distances (n, m) between the shape contexts of two outlines, from 0 to 2 (section 2.1.2).

    Raises
    ------
    ValueError
        As `shape_contexts`.
    """

def alignment_costs(cost: _Points, starts: Sequence[int], skip_penalty: float = 0.6) -> _Points:
    """Costs (k,) a row of the cheapest order-preserving matchings of two closed outlines, for k given starts.

    Parameters
    ----------
    cost
        Costs (n, m) of matching point i with point j, in single precision.
    starts
        Columns at which the second outline is cut open; the first is cut at row 0.
    skip_penalty
        Cost of leaving a point of either outline unmatched.

    Raises
    ------
    ValueError
        If there are no costs, one is negative or not finite, the penalty is so, or a start is no column.
    """

def align(cost: _Points, skip_penalty: float = 0.6) -> tuple[float, NDArray[np.int64]]:
    """Return the cheapest matching over all starts: its cost a row, and the matched pairs (k, 2).

    Pairs are of row and column; rows increase, columns increase cyclically. See `alignment_costs` for the
    arguments and errors.
    """

@final
class Seen:
    """A seen outline prepared for matching; all that depends on it alone is computed once."""

    def __new__(cls, points: _Points, parameters: Mapping[str, Any]) -> Seen:
        """Prepare a seen outline.

        Parameters
        ----------
        points
            The outline (n, 2) in any unit, for instance px.
        parameters
            All parameters, as `default_parameters` gives them; what is done with the outline goes by them.

        Raises
        ------
        InvalidOutlineError
            If the points are no outline: fewer than three, not finite, or without an area.
        ParameterError
            If a parameter is unknown or out of its range.
        ValueError
            If they are of another shape than (n, 2).
        """
    @property
    def points(self) -> _Points:
        """The equally spaced points that are aligned, wound positively."""
    @property
    def sides(self) -> list[_Points]:
        """The candidate creases (2, 2)."""
    def matches(
        self, templates: Sequence[_Points], scale: float | None = None, cheapest_only: bool = False
    ) -> tuple[list[Candidate], list[float]]:
        """Match against templates: all folds tested, cheapest first, and the cost of every template unfolded.

        `scale` is the number of seen units a template unit, if known. With `cheapest_only` only the cheapest
        fold of every template is returned, much sooner.

        Raises
        ------
        InvalidOutlineError
            If a template is no outline: fewer than three points, not finite, or without an area.
        ParameterError
            If the scale is not positive.
        ValueError
            If one is of another shape than (n, 2).
        KeyboardInterrupt
            If a `Stop` that the thread heeds was requested. In Python's main thread also whatever a signal's
            handler raises.
        """
    def explain(self, template: _Points, candidate: Candidate) -> Explanation | None:
        """Lay a fold of a template over the seen outline; None where that cannot be done.

        Raises
        ------
        InvalidOutlineError
            If the template is no outline: fewer than three points, not finite, or without an area.
        ValueError
            If it is of another shape than (n, 2).
        """

@final
class Candidate:
    """A fold of a template compared with the seen outline."""

    @property
    def template(self) -> int:
        """Index of the template."""
    @property
    def axis(self) -> _Points:
        """The axis (2, 2) on the template."""
    @property
    def cost(self) -> float:
        """Matching cost."""
    @property
    def confidence(self) -> float:
        """Summed confidence Cs of the hypotheses that claimed it."""
    @property
    def side(self) -> int:
        """Index of the side that claimed it."""
    @property
    def mirrored(self) -> bool:
        """Whether the mirrored outline matched better."""

@final
class Explanation:
    """A fold of a template laid over the seen outline."""

    @property
    def folded(self) -> _Points:
        """Equally spaced points of the folded template, template units."""
    @property
    def layer(self) -> NDArray[np.uint8]:
        """Layer of every folded point: 0 kept, 1 flap, 2 crease."""
    @property
    def arc(self) -> _Points:
        """Arc length of every folded point on the unfolded template."""
    @property
    def partner(self) -> NDArray[np.int64]:
        """Index of every folded point's partner among the seen points; -1 for none."""
    @property
    def to_seen(self) -> _Points:
        """The (2, 3) similarity of the folded template onto the seen outline; reflects for the other face."""
    @property
    def crease(self) -> _Points:
        """The crease (2, 2) on the seen outline."""
    @property
    def cost(self) -> float:
        """Matching cost."""

@final
class FlexibleTemplate:
    """A template prepared for the joint fit: its corners with a prior on how far they move."""

    def __new__(
        cls,
        outline: _Points,
        mirror_from: _Points,
        mirror_to: _Points,
        parameters: Mapping[str, Any],
        spread: Sequence[float] | None = None,
    ) -> FlexibleTemplate:
        """Prepare a template; points of `mirror_from` are mirror images of those of `mirror_to`.

        `spread` says, one value a vertex, how far each may lie from its place; else `shape` does.
        """

def mirrorings(outline: _Points, mirror_from: _Points, mirror_to: _Points) -> list[tuple[float, bool]]:
    """How nearly pairs of a template's points mirror each other over the axis that fits all of them best.

    Returns
    -------
    list of (float, bool)
        Of every pair the distance of either from the other's mirror image, and whether that is so little that
        the joint fit holds corners there alike.

    Raises
    ------
    InvalidOutlineError
        If `outline` is none.
    ValueError
        If an array is of another shape than (n, 2), or a point has no partner.
    """

@final
class JointExplanation:
    """A template fitted jointly with its creases."""

    @property
    def template(self) -> int:
        """Index of the template."""
    @property
    def outline(self) -> _Points:
        """Corners of the fitted template, template units, in the order of the template given."""
    @property
    def axes(self) -> list[_Points]:
        """Fold axes (2, 2) on the fitted template, first made first; the flap is on their left."""
    @property
    def creases(self) -> list[_Points]:
        """Creases (2, 2) on the seen outline, likewise, in the frame of the part that no fold turns over."""
    @property
    def to_seen(self) -> _Points:
        """The (2, 3) similarity of the fitted template onto the seen outline; reflects for the other face."""
    @property
    def flap_on_top(self) -> float:
        """Nats by which the flap is more likely on top than below, by the picture; 0 without one."""
    @property
    def picture_gain(self) -> float:
        """Nats of the evidence that come from the picture; 0 without one."""
    @property
    def surprise(self) -> float:
        """Minus log evidence in nats; comparable between templates."""
    @property
    def draws(self) -> int:
        """How many garments were drawn from what is as likely; none of all but the best explanations."""
    def reach_drawn(self, points: _Points, most: int) -> tuple[_Points, _Points, _Points]:
        """How a gripper reaches k points of the fitted outline, in up to so many of the garments drawn.

        Of an explanation without draws it is the fitted garment itself; what does not fold is left out.

        Returns
        -------
        places : (d, k, 2)
            Where the points lie on every folded garment, in the seen outline's units, as the distances are.
        off_outline, to_double_layer : (d, k)
            Distances from the folded garment's outline, and from where two layers or more lie over each
            other; infinite if they do so nowhere.

        Raises
        ------
        ValueError
            If the points are of another shape than (k, 2).
        """

@final
class JointFits:
    """The joint fits for every number of folds tried."""

    @property
    def most(self) -> int:
        """The largest number of folds tried."""
    @property
    def enough(self) -> int:
        """The number of folds that explain the outline best; none where they turn over next to nothing."""
    def surprise(self, folds: int) -> float:
        """Minus log evidence in nats of the best explanation by so many folds; infinite if there is none."""
    def explanations(self, folds: int) -> list[JointExplanation]:
        """Return the explanations by so many folds, the best evidence first."""

def fit_jointly(
    seen: Seen,
    outlines: Sequence[_Points],
    templates: Sequence[FlexibleTemplate],
    folds: int,
    up_to: bool = False,
    scale: float | None = None,
    picture: _Picture | None = None,
) -> JointFits:
    """Fit templates (given as outlines and prepared) jointly with their creases; the best evidence first.

    The fits start from what partial matching claims about the axis. `folds` is the number of folds, or the
    largest number if `up_to`: then further ones are tried while they explain more. `scale` is the number of
    seen units a template unit, if known. `picture` is what was seen inside the outline, in its frame:
    structure tensors (h, w, 3) of the colours, their pixels a seen unit, the same of the heights if they
    are known, and the looks of the cloth with their pixels a seen unit and the place of the first.

    Raises
    ------
    InvalidOutlineError
        If one of the outlines is none: fewer than three points, not finite, or without an area.
    ParameterError
        If the scale is not positive.
    ValueError
        If there are more outlines than templates or fewer, an outline is of another shape than (n, 2), or of
        the picture the tensors are not of one shape (h, w, 3), a scale is not positive and finite, or the
        place of the first look is not finite.
    KeyboardInterrupt
        If a `Stop` that the thread heeds was requested. In Python's main thread also whatever a signal's
        handler raises.
    """

def fit_known(
    seen: Seen,
    template: FlexibleTemplate,
    folds: Sequence[tuple[_Points, _Points, bool]],
    scale: float | None = None,
) -> list[JointExplanation]:
    """Fit a template jointly with its crease from folds known beforehand; the best evidence first.

    Every fold is an axis on the template, the kept part on its left, the crease on the seen outline, the
    cloth on its left (from x towards y), and whether the garment shows its other face. If one of them ends
    better than what `fit_jointly` found, the search has missed it.
    """

@final
class FoldedStack:
    """An outline folded several times, layer by layer."""

    @property
    def layers(self) -> list[_Points]:
        """Rims (n, 2) of the layers where they lie now, the lowest first."""
    @property
    def turned(self) -> list[list[bool]]:
        """For every layer whether each fold, first made first, turned it over."""
    @property
    def outline(self) -> _Points:
        """Outline of the union of all layers."""
    @property
    def double_layer(self) -> list[_Points]:
        """Rings (even-odd) of the region where two layers or more lie over each other."""
    def creases(self, fold: int) -> list[_Points]:
        """Where the creases (2, 2) of a fold lie now, in the pieces that later folds left of them."""
    def distance_to_double_layer(self, points: _Points) -> _Points:
        """Distance of every point from the double layer; 0 within it, inf if there is none."""
    def place(self, points: _Points, arc: _Points) -> _Points:
        """Where points of the unfolded outline (k, 2), given with their arc lengths (k,), come to lie."""

def fold_stack(
    outline: _Points, axes: Sequence[_Points], on_top: Sequence[bool] | None = None
) -> FoldedStack:
    """Fold an outline over axes that have the flap on their left, the first made first.

    All axes are in the frame of the part that no fold turns over. `on_top` tells of every fold whether its
    flap comes to lie on top of the kept part; true where it is silent.

    Raises
    ------
    ValueError
        If an axis has no direction, or creases nothing.
    """
