"""All parameters of the method, in one place, grouped by stage.

Every value is a plain number with its unit and the reason for its default. Lengths of the cloth are in
centimetres, of the picture in pixels (px); "share" is a number between 0 and 1.

Examples
--------
>>> from dataclasses import replace
>>> from foldrs.parameters import GraspParameters, Parameters
>>> careful = Parameters(grasp=GraspParameters(clearance=3.0))
>>> careful.grasp.clearance, careful.fitting == Parameters().fitting
(3.0, True)
>>> replace(careful, grasp=GraspParameters()) == Parameters()
True
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class CandidateParameters:
    """Stage 0 where it is not clear what the table is: all that may be the garment, and which of it is.

    The weights were told by a regression over candidates in real photographs and in rendered rooms, and
    rounded. Coarse px, deviations and colours are those of :class:`OutlineParameters`.
    """

    usual_gradient: float = 1.5
    """Change of colour from pixel to pixel that is no barrier, in medians of the picture's: grain, weave."""
    lowest_barrier: float = 5.0
    """Least change of colour on every way from the border for something to be enclosed, CIELAB units."""
    opening: float = 2.0
    """Radius up to which threads are taken off what is enclosed, coarse px: rims of things the border cuts,
    not sleeves."""
    table_colours: int = 6
    """Colours of the picture that may each be the table's."""
    least_table: float = 0.05
    """Share of the picture that a part of one colour must have to be taken for a table."""
    least_deviation: float = 2.5
    """Least deviation from a table at which things on it are looked for."""
    deviations: int = 10
    """Thresholds of the deviation looked at, up to `surprise_limit`."""
    least_object: float = 0.008
    """Share of the picture below which a candidate is a speck."""
    ring_reach: float = 14.0
    """Distance from a candidate up to which the table around it is looked at, coarse px."""
    strip: tuple[float, float] = (1.5, 7.0)
    """Depths between which a candidate's own colours are looked at, coarse px: beyond the blur of its rim."""
    even_deviation: float = 3.0
    """Deviation up to which what is around a candidate looks like one table."""
    clear_weight: float = 2.5
    """Weight of the logarithm of a candidate's clearness."""
    even_weight: float = 11.0
    """Weight of the evenness of the table around it."""
    cut_off_weight: float = 40.0
    """Weight of the share of its rim on the border of the picture."""
    centre_weight: float = 6.0
    """Weight of the square of its distance from the picture's middle, in half sides."""
    size_weight: float = 0.7
    """Weight of the square of the logarithm of its size over the usual one."""
    usual_share: float = 0.14
    """Usual share of the picture that a garment takes."""
    least_clearness: float = 3.0
    """Clearness below which nothing stands out: shadows."""
    least_evenness: float = 0.7
    """Evenness of the table around below which it is no table, but several things."""
    least_cut_off: float = 0.02
    """Share of its rim on the border up to which a candidate is whole."""
    whole_table_share: float = 0.3
    """Share of the picture from which a candidate may be a table seen whole; garments are mostly smaller."""
    no_table: float = 0.75
    """Overlap with a quadrilateral below which something is no table, whole or cut off by the border."""
    table_likeness: float = 0.88
    """Overlap with a quadrilateral from which what bears something is rather a table than a garment."""
    table_weight: float = 35.0
    """Difference in likeness that each whole of that overlap counts as."""
    least_borne: float = 0.05
    """Share of a table that a thing upon it covers at least: a motif on a towel is smaller."""
    most_borne: float = 0.75
    """Share of a table that a thing upon it covers at most: more is the same thing, seen less well."""
    most_print: float = 0.5
    """Share of a garment that a print upon it covers at most."""
    bearer: float = 4.0
    """How much less a garment may look like a thing on a table than the print on it does."""
    most_cut_off: float = 0.25
    """Share of its rim on the border up to which what bears a print may be a garment cut off."""
    rival: float = 3.0
    """How much less another thing may look like one on a table and be meant as well."""
    same_table: float = 5.0
    """Difference of colour up to which two objects lie on the same table, CIELAB units."""
    table_reach: float = 26.0
    """Distance from the one taken up to which the table around it is learnt for the cut, coarse px."""


@dataclass(frozen=True)
class OutlineParameters:
    """Stage 0: from the photograph to the outline (section 2.1).

    "Coarse px" are pixels of the picture shrunk to `coarse_side`, "fine px" of the one shrunk to `fine_side`,
    so that a photograph of any size is treated alike. Colour differences are CIELAB units.
    """

    max_pixels: int = 120_000_000
    """Most pixels a picture may have, told from its header before it is decoded: more than most cameras have.
    So many take about 2 GB of memory; a small file can claim far more."""
    coarse_side: int = 320
    """Longer side of the picture in which the cloth is told from the table, px: sleeves stay 8 px wide."""
    fine_side: int = 640
    """Longer side of the picture in which the outline is placed, px: finer adds time, not accuracy."""
    smoothing: float = 0.8
    """Blur before colours are compared, coarse px: takes off noise and weave."""
    frame_share: float = 0.06
    """Width of the frame along the border taken for table at first, share of the shorter side."""
    table_degree: int = 2
    """Degree of the polynomial for the table's colour: enough for vignetting and light from one side."""
    table_noise: float = 0.7
    """Least spread of the table's colour, colour difference: what JPEG leaves of a plain table."""
    table_margin: float = 8.0
    """Distance from the cloth at which the table is taken as free of its shadow, coarse px."""
    surprise_limit: float = 40.0
    """Deviation from the table, in its spreads, beyond which more makes no difference: strong prints on pale
    cloth must not set the threshold."""
    least_surprise: float = 5.0
    """Median deviation of the cloth, in the table's spreads, below which there is no garment."""
    clear_surprise: float = 12.0
    """The same for what stands out only among the table's own strongest colours (joints, grain)."""
    table_like: float = 2.0
    """Deviation, in the table's spreads, up to which a pixel outside the first guess is table for certain."""
    opening: float = 1.0
    """Radius up to which gaps are closed and threads removed, px: more would fill the gap at a sleeve."""
    tail_radius: float = 0.05
    """Half the width up to which something long is no part of a garment, in roots of the object's area:
    joints and edges of the table, straps. It takes nothing of 2159 masks of garments, 0.065 of one."""
    tail_length: float = 4.0
    """Length from which it is none, in those half widths: corners of 23 degrees or more are shorter."""
    merge_gap: float = 5.0
    """Gap between parts still taken for one garment (print of the table's colour), coarse px."""
    part_share: float = 0.1
    """Parts below this share of the largest are specks and are dropped."""
    like_size_share: float = 0.5
    """A second object of this share of the largest makes it unclear which is meant."""
    candidates: CandidateParameters = field(default_factory=CandidateParameters)
    """Where it is not clear what the table is."""
    cut_rounds: int = 3
    """Rounds of relearning colours and cutting (GrabCut): two leave pale cloth around a print out."""
    cut_margin: float = 12.0
    """Table around the cloth from which its colour (and that of the shadow) is learnt, coarse px."""
    mixture_samples: int = 2500
    """Pixels from which a colour mixture is started: more changes nothing."""
    rim_reach: float = 4.0
    """Distance the outline may move towards the rim, coarse px in the first pass, then fine px."""
    rim_gap: float = 3.0
    """Strip along the outline kept out of the colours at the rim (blur, contact shadow), px as above."""
    rim_ring: float = 6.0
    """Width of the strips from which the colours at the rim are learnt, px as above."""
    rim_window: float = 7.5
    """Half side of the window in which the colours at the rim are learnt, px as above."""
    rim_contrast: float = 4.0
    """Squared contrast of both sides over their variance below which the outline is left where it is."""
    rim_rounds: int = 2
    """Moves towards the rim in each pass: after two they are below a pixel."""
    least_pixels: int = 600
    """Pixels below which the shape of a garment cannot be told: about 25 x 25."""
    least_share: float = 0.004
    """Share of the photograph below which an object is taken for a speck on an empty table."""
    most_share: float = 0.95
    """Share of the picture beyond which there is no table to tell the cloth from."""
    cut_off_share: float = 0.08
    """Share of the outline on the picture's border beyond which the garment counts as cut off: a sleeve's end
    is 3 to 5 %, a garment's side 15 % or more."""


@dataclass(frozen=True)
class SideParameters:
    """Stage 0: sides of the simplified outline, the candidate creases (section 2.1)."""

    tolerances: tuple[float, ...] = (0.02,)
    """Douglas-Peucker tolerances, as shares of the square root of the outline's area. The axis is one side at
    1 to 2 % in 99 % of virtual folds of real outlines; the sides of all tolerances are candidates."""
    shortest: float = 0.08
    """Sides shorter than this share of the square root of the area are no candidates: so short a fold hardly
    changes the garment."""
    in_line: float = 0.03
    """Two sides whose ends lie this near to one line, as a share of the square root of the area, may be one
    crease (a fold over two legs)."""


@dataclass(frozen=True)
class PartialMatchParameters:
    """Stage 1: partial matching by chord angles (section 2.1.1)."""

    points: int = 100
    """Points on the seen outline; the template gets as many as the same spacing gives. 100 resolve a cuff."""
    delta: int = 5
    """Points between a corner and the third point of its chord angle, as in all its authors' experiments."""
    shortest: int = 14
    """Points of the shortest piece: must exceed `delta`; below some 12 nearly anything matches."""
    longest: float = 0.8
    """Longest piece, as a share of the shorter outline's points."""
    likeness: float = 0.5
    """Radians: difference of chord angles at which the likeness of two pieces has fallen to 1/e."""
    length: float = 20.0
    """Points at which a piece's length counts 1 - 1/e of the most."""
    affinity: float = 0.05
    """Matches of smaller affinity As are dropped."""
    most: int = 200
    """At most this many matches a face and scale, the best first."""
    sizes: tuple[float, ...] = (0.85, 1.0)
    """Sizes of the garment tried, relative to the template's, when the scale is known."""
    scales: tuple[float, ...] = (1.02, 1.14, 1.27, 1.4)
    """Ratios tried when the scale is unknown: one fold hides at most half of the area, so the garment is 1 to
    1.42 times as large as an equal area says."""


@dataclass(frozen=True)
class HypothesisParameters:
    """Stage 2: hypotheses about the fold axis and their aggregation (section 2.1.2)."""

    affine_spread: float = 0.15
    """Share of a piece's extent that it must spread across its main direction for an affine map; a straighter
    piece leaves the affine map undetermined and gets a similarity."""
    stretch: float = 1.6
    """Largest factor by which a map may stretch or shrink beyond the expected scale."""
    angle_bins: int = 36
    """Bins over the half circle of axis directions: 5 degrees, the spread of one axis's claims."""
    distance_bin: float = 0.03
    """Width of the bins over the axis's distance from the template's centre, as a share of the square root of
    its area: some 1.5 cm."""
    most: int = 200
    """At most this many hypotheses a template are tested, the most confident first."""


@dataclass(frozen=True)
class ShapeContextParameters:
    """Stage 4: inner-distance shape contexts (Ling & Jacobs 2007)."""

    n_points: int = 100
    """Points on every outline compared."""
    n_dist: int = 5
    """Bins over the logarithm of the distance."""
    n_theta: int = 12
    """Bins over the direction of the shortest path's first leg."""


@dataclass(frozen=True)
class AlignmentParameters:
    """Stage 4: cyclic alignment (Ling & Jacobs 2007)."""

    skip_penalty: float = 0.6
    """Cost of leaving a point unmatched: theirs of 0.3, for chi-squared without the factor 1/2."""
    starts: int = 8
    """Places tried for the first point's partner; then the neighbours of the best. They use 4 to 8."""


@dataclass(frozen=True)
class JointFitParameters:
    """Joint fit of corners and crease (beyond the paper).

    Lengths are in template units (cm for the built-in templates) unless they say otherwise; "of the size"
    means as a share of the square root of the template's area.
    """

    samples: int = 100
    """Points of the seen outline to be explained."""
    nodes: int = 64
    """Nodes of the signed distance field along its longer side."""
    simplify: float = 0.01
    """Tolerance of the template's simplification, of the size: finer detail moves along."""
    shape: float = 0.1
    """Spread of a corner about the template's, of the size. Real garments of a kind differ from their mean by
    8 % (3 to 6 cm) a corner."""
    edge: float = 0.25
    """Spread of the difference between neighbouring corners' displacements, as a share of their edge ..."""
    edge_floor: float = 0.02
    """... and this besides, of the size: short edges bend less than long ones."""
    asymmetry: float = 0.04
    """Spread of the difference between the garment's halves, of the size (1.5 to 3 cm)."""
    growth: float = 0.15
    """Spread of the logarithm of the garment's size about the template's, where the scale is known."""
    free_growth: float = 0.25
    """The same where the scale is unknown."""
    most_larger: float = 10.0
    """How many times as large (in length) as what is seen a template may be, or as small, where the scale is
    known: five folds make a garment look about a sixth of its size, and none is larger or smaller than its
    template by more than the rest."""
    view: float = 0.05
    """Spread of how much larger a camera at an angle draws a garment's near side than its far side, over its
    size, where the scale is unknown: a garment of 60 cm, seen from 2 m at 10 degrees. With a scale, or a
    plane that tells it, the outline is one seen from straight above."""
    hidden: float = 1.3
    """Area of the garment over the area seen, where the scale is unknown: one fold hides between nothing and
    half."""
    turn: float = 2.0
    """Radians: spread of the pose's turn; any."""
    offset: float = 50.0
    """Spread of the pose's offset: anywhere on the table."""
    shift: float = 0.5
    """Spread of the crease's shift from its side: a few millimetres."""
    skew: float = 0.03
    """Radians: spread of the crease's turn from its side."""
    earlier_shift: float = 1.0
    """As `shift`, of the crease of a fold that others follow: they leave less of it to be seen."""
    earlier_skew: float = 0.1
    """Radians: as `skew`, likewise."""
    along: float = 0.15
    """Share of first folds that lie along the garment's mirror axis, at some distance from it ..."""
    across: float = 0.2
    """... at right angles to it ..."""
    halves: float = 0.2
    """... and on it, so that the halves cover each other. All others lie in any direction: a little less than
    half of all, which is a guess; shares of 0.15 to 0.3 in halves do alike."""
    way_turn: float = 0.06
    """Radians: how far such a fold is turned from that; folded by hand, some three degrees."""
    way_shift: float = 0.05
    """How far a fold in halves lies beside the mirror axis, of the size: 2 to 3 cm."""
    ways_tried: int = 30
    """So many of the best fits of all templates are tried in these ways: several times those told."""
    first_fold: float = 16.0
    """Nats a first fold must gain over the template unfolded, beyond what its freedom costs: where nothing is
    folded, a fold near a hem still takes up what the template's shape does not explain. Nine in ten
    outlines of flat garments gain less, nine in ten folded ones more."""
    further_fold: float = 6.0
    """Nats each further fold must gain: most of that has then been taken up. Of folds that turn the same part
    over twice the picture shows no more than of one."""
    flap: float = 2.0
    """Power of the share of the cloth a fold turns over that its prior density grows with: who folds a
    garment turns over much of it, while a corner or cuff that a fold seems to turn in mostly lies so by
    itself."""
    least_turned: float = 0.08
    """Share of the cloth below which what folds turn over leaves the garment flat, where their number is to
    be found: of garments laid out flat one in fifteen has a corner turned in or a hem bent by so much."""
    noise: float = 0.6
    """Expected distance of the seen outline from the model's edges: wavy hems, soft cloth."""
    bow: float = 0.01
    """Spread of how far an edge bulges in its middle, as a share of the geometric mean of its length and the
    size: hems and collars are curved, long seams not as much more. At twice as much trousers folded leg over
    leg are as likely upside down."""
    tail: float = 3.0
    """Distances beyond this multiple of the noise count less and less."""
    correlation: float = 5.0
    """Length along the outline over which distances go together: so much outline is one observation."""
    against: float = 6.0
    """Distance that a piece of outline running the opposite way of the model's edge counts as."""
    bend: float = 0.15
    """Difference of directions (1 - cosine) that costs nothing: edges bend."""
    bare: float = 4.0
    """Depth within the seen outline, in noises, from which on an edge of the model with bare table beside it
    counts as not seen: hems that wave are off by less, a gap between legs that is not there by more."""
    covered: float = 0.5
    """A chord is creased if at least this share of it lies on the crease's side."""
    coarse_noise: float = 3.0
    """Noise of the first iterations, as a multiple: far from the solution nearest points mislead."""
    coarse_iterations: int = 5
    """Iterations with the coarse noise."""
    iterations: int = 12
    """At most this many iterations with the true noise."""
    polish_noise: float = 0.3
    """Noise of the last iterations, which draw the corners onto the outline."""
    polish_iterations: int = 6
    """Iterations with that noise."""
    polished: int = 20
    """So many of the best fits are drawn onto the outline."""
    draws: int = 64
    """So many garments are drawn from what is as likely as each of these fits, to tell how probably a
    landmark is within reach: that probability is then known to 6 %."""
    draw_variance: float = 3.0
    """Variance of the draws, as a multiple of the fit's: evidence is surer than it should be by so much (see
    `AlternativeParameters.nats`); docs/reliability.md tells what probabilities of reach are worth with it."""
    longest_step: float = 6.0
    """Longest step of a corner in one iteration."""
    directions: int = 12
    """Directions tried for the template unfolded."""
    starts: int = 900
    """At most this many claims a template are tried, the most confident first."""
    refined: int = 40
    """Starts a template that are fitted to the end, the most promising first."""
    retried: int = 12
    """So many of the best fits of all templates are started once more from near where they ended: some end
    better."""
    alike: float = 1.5
    """Of starts that come to lie nearer to each other than this at every corner, only the best is fitted to
    the end: copies of one explanation would leave no room for others. Template units (cm)."""


@dataclass(frozen=True)
class RimParameters:
    """Evidence from the picture: the rim of the layer on top (beyond the paper).

    Lengths are in template units (cm).
    """

    inside: float = 1.5
    """Rims this near to the seen outline say nothing: those edges are there anyway."""
    spacing: float = 1.0
    """Distance of two places looked at along a rim."""
    reach: float = 1.2
    """How far beside the predicted rim its edge is looked for: straight predicted rims miss curved real
    ones."""
    correlation: float = 4.0
    """Length along a rim over which edges go together: so much rim is one observation."""
    shown: float = 0.6
    """Share of a true rim that shows as an edge."""
    sharpness: float = 5.0
    """How strongly the edges of a rim rank above chance edges: the density of their rank r is k r^(k-1)."""
    mislead: float = 0.05
    """Odds that edges along a predicted rim are something else's (a seam, a pocket): they bound the
    evidence."""
    weight: float = 0.6
    """Weight of the edges against the outline; 0 leaves them out. Chance edges come in runs, which makes them
    surer of themselves than they should be."""


@dataclass(frozen=True)
class RegionParameters:
    """Evidence from the picture: what the layer on top covers looks different (beyond the paper).

    Lengths are in template units (cm).
    """

    inside: float = 1.5
    """Places this near to the seen outline say nothing: light and blur change there anyway."""
    patch: float = 4.0
    """Side of a patch of cloth that is one observation, as along rims: wrinkles and prints are about so wide.
    At 2 light and shadow are believed too much; 3 and 5 rank nearly as many right."""
    chance: float = 0.9
    """Quantile of what straight cuts tell by chance that a region must exceed. 0.5 to 0.95 rank as many
    right; hems and prints along a side ask for much."""
    least: float = 0.02
    """Share of the cloth below which a region, or the rest, is too small to tell."""
    placement: float = 0.7
    """Spread of a rim about where the picture shows it: the smoothing of the looks."""
    directions: int = 3
    """So many directions in which the outline leaves the rims open are searched; 5 find nothing more."""
    open: float = 0.5
    """Spread of the rims along a direction below which the outline tells enough."""
    step: float = 0.75
    """Step of the search, as a distance of the rims; the last ones are a quarter of it."""
    range: float = 2.5
    """How far the search goes, in spreads."""
    placed: int = 20
    """How many of the best fits are searched about; 12 miss some, 40 find nothing more."""


@dataclass(frozen=True)
class MatchingParameters:
    """Stages 1 to 4 and the joint fit, as the crate takes them."""

    side: SideParameters = field(default_factory=SideParameters)
    partial_match: PartialMatchParameters = field(default_factory=PartialMatchParameters)
    hypothesis: HypothesisParameters = field(default_factory=HypothesisParameters)
    shape_context: ShapeContextParameters = field(default_factory=ShapeContextParameters)
    alignment: AlignmentParameters = field(default_factory=AlignmentParameters)
    fit: JointFitParameters = field(default_factory=JointFitParameters)
    rim: RimParameters = field(default_factory=RimParameters)
    region: RegionParameters = field(default_factory=RegionParameters)


@dataclass(frozen=True)
class FittingParameters:
    """Stage 5: the fitting stage (section 2.2)."""

    iterations: int = 5
    """Passes of matching and fitting, as in the paper."""
    starts: int = 1
    """At most this many distinct folds of a template are fitted, the cheapest first. One, as in the paper, is
    as often right as two or three; more give more alternatives."""
    starts_in_all: int = 8
    """At most this many folds of all templates are fitted, but always one a template: bounds the time."""
    neighbours: int = 15
    """Np, points of the folded outline (of 100) around each that its similarity is estimated from."""
    width: float = 0.25
    """Standard deviation of the Gaussian over the template's arc length, as a share of its perimeter. Wide:
    hidden parts are extrapolated from all that is seen; narrower, a wrong fold bends into place."""
    whole: float = 1e-4
    """Weight of every point in every local similarity: a neighbourhood without any moves with the whole."""
    points: int = 100
    """Points on the template's sides that lines are fitted to."""
    reach: float = 0.02
    """Distance along the template, as a share of its perimeter, to the next visible point up to which a point
    takes part in a line; others are extrapolated. Visible points lie some 0.01 apart."""
    tolerance: float = 0.01
    """Largest distance of inliers from a line, as a share of the square root of the area (0.5 cm)."""
    fewest: int = 4
    """Points that a line needs; a side with fewer keeps its registered corners."""
    trials: int = 50
    """At most this many pairs of points are tried a line."""
    certainty: float = 0.99
    """Probability of having tried a pair of inliers at which no more are tried."""
    seed: int = 0
    """Seed of the pairs tried: the same input gives the same output."""
    least_angle: float = 15.0
    """Degrees: sides that meet at a smaller angle are nearly parallel; their corner stays as registered."""
    largest_shift: float = 0.1
    """A corner moves at most this far from where it was registered, as a share of the square root of the
    area: two nearly parallel lines may meet anywhere."""
    snap_corner: float = 7.0
    """Template units (cm): as `GraspParameters.snap_corner`, for garments placed by this stage: its corners,
    each from two straight lines, lie less true than those of the joint fit."""


@dataclass(frozen=True)
class GraspParameters:
    """Stage 6: accessible landmarks (section 3.2)."""

    clearance: float = 2.0
    """Template units (cm): no double layer this near to an accessible landmark. A finger's width."""
    margin: float = 5.0
    """Template units (cm): so far from a landmark a gripper may close and still hold the garment by it; the
    paper's margin."""
    likely: float = 0.3
    """Probability of being within reach from which on a landmark counts as accessible. With 0.5 the first
    grasp pair is right less often, by two or three in a hundred: some garments are told none."""
    as_good: float = 0.04
    """Of grasp pairs less probable than the best by no more than this the template's order decides: from 64
    draws a probability near 1 is not known better (two standard errors), and a natural pair unfolds the
    garment best. At 0 six in ten of the pairs told first are natural ones, at 0.02 to 0.05 eight, and nearly
    as many work."""
    ample: float = 6.0
    """Template units (cm): of the published method, which tells no probabilities, grasp pairs with no double
    layer this near to either landmark are preferred. Where a hidden layer ends is known to a few centimetres;
    4 to 8 are alike."""
    on_outline: float = 1.0
    """Template units (cm): how far from the folded outline a landmark may lie and still count as on it."""
    snap: float = 6.0
    """Template units (cm): a landmark on the model's outline is moved to the seen one if that is this near;
    straight edges overshoot rounded corners."""
    snap_corner: float = 2.0
    """Template units (cm): a corner of the seen outline this near is preferred; landmarks are corners."""
    corner_likeness: float = 45.0
    """Degrees: only a corner where the outline turns as the model's does, up to this."""
    corner_arm: float = 3.0
    """Template units (cm) before and behind a corner over which its turn is taken: a cuff is 8 cm wide."""
    corner_tolerance: float = 0.02
    """Tolerance of the simplification whose corners count, as a share of the square root of the area."""


@dataclass(frozen=True)
class PictureParameters:
    """Colour edges and looks of the picture, for the evidence of rims and regions."""

    longest: int = 640
    """px: pictures with a longer side are made smaller first; a rim is some pixels wide at that size."""
    blur: float = 1.0
    """px: Gaussian blur before the gradient; the width of a pixel, against noise."""
    cloth: float = 200.0
    """px: square root of the cloth's area at which its looks are told; larger cloth is made smaller. Stripes
    of half a centimetre are two pixels then."""
    look_blur: float = 0.015
    """Spread over which a place's look is told, as a share of that root: three quarters of a centimetre."""
    no_slope: float = 0.3
    """CIELAB units a pixel below which a slope has no direction: noise."""
    means_nothing: tuple[float, ...] = (2.0, 1.5, 1.5, 0.5, 0.4, 0.4, 0.3, 0.3)
    """Spreads that mean nothing, of lightness and two of colour, of how busy each is, and of the two parts of
    direction: light and noise of plain cloth."""
    looks: int = 6
    """How many looks are told apart: two faces, with their light and shadow. 4 are too few, 9 the same."""
    look_samples: int = 1500
    """Places from which the looks are learnt, at most twice as many: more changes nothing."""
    fewest_seen: int = 100
    """Places below which a cloth has but one look."""
    sure: float = 2.5
    """Nats by which one layer must be more likely on top than the other to be called so. Of such
    calls five in six were right on real garments, and as many on rendered ones."""


@dataclass(frozen=True)
class ScaleParameters:
    """Markers and sheets of known size lying on the table."""

    corner_noise: float = 0.3
    """px: spread of a corner found in the picture; sub-pixel methods reach 0.1 to 0.5."""
    focal: float = 1.1
    """Focal length expected of an unknown camera, longer sides of the picture: it sees 50 degrees."""
    focal_spread: float = 0.3
    """Spread of its logarithm: 37 to 65 degrees."""
    tilt_spread: float = 0.4
    """Radians: spread of the camera's tilt expected (23 degrees). One small marker says little about the
    tilt; then the view is taken for one from above rather than for a steep one."""
    worst_corner: float = 2.0
    """px: corners farther than this from where the plane has them belong to no marker of that size on it; of
    a picture of 640 px, larger ones in proportion."""
    most_tilt: float = 65.0
    """Degrees beyond which a sheet is not taken for one."""
    quiet_zone: float = 0.25
    """White around a marker that is taken for part of it, as a share of its side: two modules of most."""
    most_paper: float = 700.0
    """cm2: largest paper around a marker that is taken for part of it, a little more than A4."""
    paper_likeness: float = 12.0
    """Colour difference up to which what adjoins a marker's quiet zone is its paper."""
    paper_solidity: float = 0.9
    """Share of its convex hull that paper fills at least: torn-off paper does, a pale board of the table does
    not."""
    rim: float = 2.0
    """px, of a picture of 320 px, larger ones in proportion: what is painted over around a marker or sheet
    besides, its shadow."""
    whiteness: float = 18.0
    """Chroma (CIELAB) up to which a sheet is white; warm or cool light gives white paper up to 15."""
    brightness: float = 60.0
    """Least lightness (CIELAB) of a sheet of white paper; it must be lighter than the table around, too."""
    step: float = 5.0
    """Lightness by which a sheet stands out from what lies around it."""
    evenness: float = 6.0
    """Largest spread of a sheet's lightness: paper has no pattern."""
    least_side: float = 0.03
    """Shortest side of a sheet, as a share of the picture's longer side: its corners could not be told."""
    straight: float = 0.02
    """Largest mean distance of a sheet's rim from its straight sides, as a share of their length."""
    proportion: float = 0.025
    """Largest distance of a sheet's corner from where its proportions have it, the camera's tilt accounted
    for, as a share of its size."""


@dataclass(frozen=True)
class DepthParameters:
    """Depth images: cloth told from the table by its height."""

    side: int = 640
    """px: depth images with a longer side are made smaller; sensors resolve no more."""
    samples: int = 20000
    """Pixels that the table's plane is fitted to: more changes nothing."""
    tolerance: float = 0.006
    """Largest distance of the table's pixels from its plane, as a share of their depth: noise, and tables
    that are not quite flat."""
    trials: int = 200
    """Triples of pixels tried: with half of them table, one of them is table alone for certain."""
    seed: int = 0
    """Seed of the triples: the same input gives the same output."""
    least_table: float = 0.2
    """Share of the picture that must lie on one plane."""
    blur: float = 1.5
    """px: Gaussian blur of the heights, against the sensor's noise."""
    clear: float = 4.0
    """Height, in spreads of the table's, from which on a pixel stands out."""
    sure: float = 7.0
    """Median height of the cloth, in the same, from which on the depth is asked where the garment is. Below,
    the colours tell it better."""
    step_blur: float = 2.0
    """px: Gaussian blur of the heights, besides, before their steps count as rims: a layer is hardly thicker
    than the sensor's noise."""
    agreement: float = 0.93
    """Overlap (intersection over union) of the garment by height and by colour from which on the colours are
    followed, which show the rim more finely; below, the heights."""


@dataclass(frozen=True)
class AlternativeParameters:
    """How many explanations are told apart, and how sure each is."""

    most: int = 5
    """At most this many alternatives; further ones hardly ever hold the truth."""
    same_overlap: float = 0.9
    """Two explanations whose unfolded outlines overlap this much (intersection over union) and whose creases
    agree are one."""
    same_crease: float = 0.05
    """Area between two creases, as a share of the garment's area, up to which they agree."""
    temperature: float = 0.03
    """Difference of matching cost at which an explanation is 1/e times as probable."""
    most_folds: int = 3
    """At most this many folds are tried where their number is to be found."""
    nats: float = 3.0
    """The same for the joint fit's evidence. It counts every few centimetres of outline as an observation of
    its own, but where a template is wrong it is wrong all along an edge: over 360 folds of real outlines
    probabilities meet what happens if a difference of 3 nats counts as one."""


@dataclass(frozen=True)
class Parameters:
    """Parameters of all stages. ``Parameters()`` holds the defaults."""

    outline: OutlineParameters = field(default_factory=OutlineParameters)
    matching: MatchingParameters = field(default_factory=MatchingParameters)
    fitting: FittingParameters = field(default_factory=FittingParameters)
    picture: PictureParameters = field(default_factory=PictureParameters)
    grasp: GraspParameters = field(default_factory=GraspParameters)
    alternatives: AlternativeParameters = field(default_factory=AlternativeParameters)
    scale: ScaleParameters = field(default_factory=ScaleParameters)
    depth: DepthParameters = field(default_factory=DepthParameters)
