//! All parameters of the matching, grouped by stage, with units and the reason for each default.
//!
//! "Share" is a number between 0 and 1; angles are in radians unless a name says degrees. Stages expect what
//! [`Parameters::check`] accepts.

mod check;

pub use crate::alignment::AlignmentParameters;
pub use crate::shape_context::ShapeContextParameters;
pub use check::ParameterError;

/// Parameters of all stages of the crate; [`Default`] gives the values every stage documents.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct Parameters {
    /// Stage 0: sides of the outline.
    pub side: SideParameters,
    /// Stage 1: partial matching.
    pub partial_match: PartialMatchParameters,
    /// Stage 2: hypotheses.
    pub hypothesis: HypothesisParameters,
    /// Stage 4: shape contexts.
    pub shape_context: ShapeContextParameters,
    /// Stage 4: alignment.
    pub alignment: AlignmentParameters,
    /// Joint fit.
    pub fit: FitParameters,
    /// Evidence from the picture.
    pub rim: RimParameters,
    /// Evidence from the picture: what the layer on top covers.
    pub region: RegionParameters,
}

/// Points below which an outline resampled to them keeps nothing of its shape.
pub(crate) const LEAST_POINTS: usize = 20;

/// Sides of the simplified outline (section 2.1).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct SideParameters {
    /// Tolerances of the Douglas-Peucker simplification, as shares of the square root of the outline's area. The axis
    /// is one side at 1 to 2 % in 99 % of virtual folds of real outlines; sides of all tolerances are candidates.
    pub tolerances: Vec<f64>,
    /// Sides shorter than this share of the square root of the area are no candidates: so short a fold hardly
    /// changes the garment.
    pub shortest: f64,
    /// Two sides whose ends lie this near to one line, as a share of the square root of the area, may be one crease
    /// (a fold over two legs).
    pub in_line: f64,
}

impl Default for SideParameters {
    fn default() -> Self {
        Self {
            tolerances: vec![0.02],
            shortest: 0.08,
            in_line: 0.03,
        }
    }
}

/// Partial matching (section 2.1.1).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct PartialMatchParameters {
    /// Points on the seen outline; the template gets as many as the same spacing gives. 100 resolves a sleeve's cuff.
    pub points: usize,
    /// Points between the corner and the third point of a chord angle; 5 in all of its authors' experiments.
    pub delta: usize,
    /// Shortest piece, in points. Must exceed `delta` for a piece to hold an angle at all; below some 12 points
    /// nearly anything matches.
    pub shortest: usize,
    /// Longest piece, as a share of the shorter outline's points.
    pub longest: f64,
    /// Difference of chord angles, in radians, at which the likeness of two pieces has fallen to 1/e.
    pub likeness: f64,
    /// Length of a piece, in points, at which its length counts 1 - 1/e of the most.
    pub length: f64,
    /// Matches of smaller affinity are dropped.
    pub affinity: f64,
    /// At most this many matches a face and scale, the best first.
    pub most: usize,
    /// Sizes of the garment tried, relative to the template's, when the scale is known.
    pub sizes: Vec<f64>,
    /// Ratios of scale tried when the scale is unknown. The seen area is that of the garment less what is hidden
    /// twice, between all and half of it, so the true size is 1 to 1.42 times that of an equal area.
    pub scales: Vec<f64>,
}

impl Default for PartialMatchParameters {
    fn default() -> Self {
        Self {
            points: 100,
            delta: 5,
            shortest: 14,
            longest: 0.8,
            likeness: 0.5,
            length: 20.0,
            affinity: 0.05,
            most: 200,
            sizes: vec![0.85, 1.0],
            scales: vec![1.02, 1.14, 1.27, 1.40],
        }
    }
}

/// Hypotheses about the fold axis (section 2.1.2).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct HypothesisParameters {
    /// A piece's affine map is used if the spread of its points across their main direction is at least this share
    /// of that along it; a straighter piece leaves the affine map undetermined and gets a similarity.
    pub affine_spread: f64,
    /// Largest factor by which a map may stretch or shrink beyond the expected scale; others are dropped.
    pub stretch: f64,
    /// Bins over the half circle of axis directions, for the aggregation.
    pub angle_bins: usize,
    /// Width of the bins over the axis's distance from the template's centre, as a share of the square root of its
    /// area.
    pub distance_bin: f64,
    /// At most this many hypotheses a template are tested, the most confident first.
    pub most: usize,
}

impl Default for HypothesisParameters {
    fn default() -> Self {
        Self {
            affine_spread: 0.15,
            stretch: 1.6,
            angle_bins: 36,
            distance_bin: 0.03,
            most: 200,
        }
    }
}

/// Joint fit of corners and crease (beyond the paper). Lengths are in template units (cm for the built-in templates)
/// unless they say otherwise.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct FitParameters {
    /// Points of the seen outline to be explained.
    pub samples: usize,
    /// Nodes of the signed distance field along its longer side.
    pub nodes: usize,
    /// Tolerance of the template's simplification, as a share of the square root of its area: finer detail moves along.
    pub simplify: f64,
    /// Spread of a corner about the template's, as a share of the square root of the template's area. Real garments of
    /// a kind differ from their mean by 8 % (3 to 6 cm) a corner.
    pub shape: f64,
    /// Spread of the difference between two neighbouring corners' displacements, as a share of their edge's length ...
    pub edge: f64,
    /// ... and this share of the square root of the area besides: short edges bend less than long ones.
    pub edge_floor: f64,
    /// Spread of the difference between the garment's two halves, as a share of the square root of its area
    /// (1.5 to 3 cm with the bulges of edges, which have a spread of their own).
    pub asymmetry: f64,
    /// Spread of the logarithm of the garment's size about the template's where the scale is known.
    pub growth: f64,
    /// The same where the scale is unknown.
    pub free_growth: f64,
    /// How many times as large (in length) as what is seen a template may be, or as small, where the scale is known: five
    /// folds make a garment look about a sixth of its size, and none is larger or smaller than its template by more than
    /// the rest.
    pub most_larger: f64,
    /// Spread of how much larger a camera at an angle draws a garment's near side than its far side, over its size, where
    /// the scale is unknown: a garment of 60 cm, seen from 2 m at 10 degrees. With a scale, or a plane that tells it,
    /// the outline is one seen from straight above.
    pub view: f64,
    /// Area of the garment over the area seen, where the scale is unknown: one fold hides between nothing and half.
    pub hidden: f64,
    /// Spread of the pose's turn, in radians: any.
    pub turn: f64,
    /// Spread of the pose's offset: anywhere on the table.
    pub offset: f64,
    /// Spread of the crease's shift from its side: a few millimetres.
    pub shift: f64,
    /// Spread of the crease's turn from its side, in radians.
    pub skew: f64,
    /// The same two of the crease of a fold that others follow: they leave less of it to be seen.
    pub earlier_shift: f64,
    /// In radians.
    pub earlier_skew: f64,
    /// Share of first folds that lie along the garment's mirror axis, at some distance from it ...
    pub along: f64,
    /// ... at right angles to it ...
    pub across: f64,
    /// ... and on it, so that the halves cover each other. All others lie in any direction: a little less than half
    /// of all, which is a guess; shares of 0.15 to 0.3 in halves do alike.
    pub halves: f64,
    /// How far such a fold is turned from that, in radians: garments are folded by hand, to some three degrees.
    pub way_turn: f64,
    /// How far a fold in halves lies beside the mirror axis, as a share of the square root of the template's area: 2 to 3 cm.
    pub way_shift: f64,
    /// So many of the best fits of all templates are tried in these ways: several times those that are told.
    pub ways_tried: usize,
    /// Nats a first fold must gain over the template unfolded, beyond what its freedom costs: where nothing is folded, a
    /// fold near a hem still takes up what the template's shape does not explain.
    pub first_fold: f64,
    /// Nats each further fold must gain: most of that has then been taken up.
    pub further_fold: f64,
    /// Power of the share of the cloth a fold turns over that its prior density grows with: who folds a garment turns
    /// over much of it, while a corner or cuff that a fold seems to turn in mostly lies so by itself.
    pub flap: f64,
    /// Share of the cloth below which what folds turn over leaves the garment flat, where their number is to be found: of
    /// garments laid out flat one in fifteen has a corner turned in or a hem bent by so much.
    pub least_turned: f64,
    /// Distance of the seen outline from the model's edges to be expected: wavy hems, soft cloth.
    pub noise: f64,
    /// Spread of how far an edge bulges in its middle, as a share of the geometric mean of its length and the square root
    /// of the area: hems and collars are curved, long seams not as much more. At twice as much trousers folded leg over
    /// leg are as likely upside down.
    pub bow: f64,
    /// Distances beyond this multiple of the noise count less and less.
    pub tail: f64,
    /// Length along the outline over which distances go together: so much outline is one observation.
    pub correlation: f64,
    /// Distance that a piece of outline running the opposite way of the model's edge counts as.
    pub against: f64,
    /// Difference of directions (1 - cosine) that costs nothing: edges bend.
    pub bend: f64,
    /// Depth within the seen outline, in noises, from which on an edge of the model with bare table beside it counts as not
    /// seen: hems that wave are off by less, and a gap between two legs that is not there by more.
    pub bare: f64,
    /// A chord is creased if at least this share of it lies on the crease's side.
    pub covered: f64,
    /// Noise of the first iterations, as a multiple of the noise: far from the solution nearest points mislead.
    pub coarse_noise: f64,
    /// Iterations with the coarse noise.
    pub coarse_iterations: usize,
    /// At most this many iterations with the true noise.
    pub iterations: usize,
    /// Noise of the last iterations, which draw the corners onto the outline.
    pub polish_noise: f64,
    /// Iterations with that noise.
    pub polish_iterations: usize,
    /// So many of the best fits are drawn onto the outline.
    pub polished: usize,
    /// So many garments are drawn from what is as likely as each of these fits, to tell how probably a landmark is within
    /// reach: that probability is then known to 6 %.
    pub draws: usize,
    /// Variance of the draws, as a multiple of the fit's: evidence is surer than it should be by so much.
    pub draw_variance: f64,
    /// Longest step of a corner in one iteration.
    pub longest_step: f64,
    /// Directions tried for the template unfolded.
    pub directions: usize,
    /// At most this many claims a template are tried, the most confident first.
    pub starts: usize,
    /// Starts a template that are fitted to the end, the most promising first.
    pub refined: usize,
    /// So many of the best fits of all templates are started once more from near where they ended: some end better.
    pub retried: usize,
    /// Of starts that come to lie nearer to each other than this at every corner, only the best is fitted to the end.
    pub alike: f64,
}

impl Default for FitParameters {
    fn default() -> Self {
        Self {
            samples: 100,
            nodes: 64,
            simplify: 0.01,
            shape: 0.1,
            edge: 0.25,
            edge_floor: 0.02,
            asymmetry: 0.04,
            growth: 0.15,
            free_growth: 0.25,
            most_larger: 10.0,
            view: 0.05,
            hidden: 1.3,
            turn: 2.0,
            offset: 50.0,
            shift: 0.5,
            skew: 0.03,
            earlier_shift: 1.0,
            earlier_skew: 0.1,
            along: 0.15,
            across: 0.2,
            halves: 0.2,
            way_turn: 0.06,
            way_shift: 0.05,
            ways_tried: 30,
            first_fold: 16.0,
            further_fold: 6.0,
            flap: 2.0,
            least_turned: 0.08,
            noise: 0.6,
            bow: 0.01,
            tail: 3.0,
            correlation: 5.0,
            against: 6.0,
            bend: 0.15,
            bare: 4.0,
            covered: crate::fold::COVERED,
            coarse_noise: 3.0,
            coarse_iterations: 5,
            iterations: 12,
            polish_noise: 0.3,
            polish_iterations: 6,
            polished: 20,
            draws: 64,
            draw_variance: 3.0,
            longest_step: 6.0,
            directions: 12,
            starts: 900,
            refined: 40,
            retried: 12,
            alike: 1.5,
        }
    }
}

/// Evidence from the picture (beyond the paper). Lengths are in template units (cm for the built-in templates).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct RimParameters {
    /// Rims this near to the seen outline or the crease say nothing: those edges are there anyway.
    pub inside: f64,
    /// Distance of two places looked at along a rim.
    pub spacing: f64,
    /// How far beside the predicted rim its edge is looked for: straight predicted rims miss curved real ones.
    pub reach: f64,
    /// Length along a rim over which edges go together: so much rim is one observation.
    pub correlation: f64,
    /// Share of a true rim that shows as an edge.
    pub shown: f64,
    /// How strongly the edges of a rim that shows rank above chance edges (the density of their rank r is
    /// k r^(k-1)).
    pub sharpness: f64,
    /// Odds that edges along a predicted rim are something else's (a seam, a pocket): they bound the evidence.
    pub mislead: f64,
    /// Weight of the edges against the outline; 0 leaves them out.
    pub weight: f64,
}

impl Default for RimParameters {
    fn default() -> Self {
        Self {
            inside: 1.5,
            spacing: 1.0,
            reach: 1.2,
            correlation: 4.0,
            shown: 0.6,
            sharpness: 5.0,
            mislead: 0.05,
            weight: 0.6,
        }
    }
}

/// Evidence from the picture: what the layer on top covers looks different (beyond the paper). Lengths are in template
/// units (cm for the built-in templates).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct RegionParameters {
    /// Places this near to the seen outline say nothing: light and blur change there anyway.
    pub inside: f64,
    /// Side of a patch of cloth that is one observation: folds in the cloth and prints are about so wide.
    pub patch: f64,
    /// Quantile of what straight cuts tell by chance that a region must exceed.
    pub chance: f64,
    /// Share of the cloth below which a region, or the rest, is too small to tell.
    pub least: f64,
    /// Spread of a rim about where the picture shows it.
    pub placement: f64,
    /// So many directions in which the outline leaves the rims open are searched.
    pub directions: usize,
    /// Spread of the rims along a direction below which the outline tells enough.
    pub open: f64,
    /// Step of the search, as a distance of the rims; the last ones are a quarter of it.
    pub step: f64,
    /// How far the search goes, in spreads.
    pub range: f64,
    /// How many of the best fits are searched about.
    pub placed: usize,
}

impl Default for RegionParameters {
    fn default() -> Self {
        Self {
            inside: 1.5,
            patch: 4.0,
            chance: 0.9,
            least: 0.02,
            placement: 0.7,
            directions: 3,
            open: 0.5,
            step: 0.75,
            range: 2.5,
            placed: 20,
        }
    }
}
