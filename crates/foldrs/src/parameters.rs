//! All parameters of the matching, grouped by stage, with units and the reason for each default.
//!
//! "Share" is a number between 0 and 1; angles are in radians unless a name says degrees.

pub use crate::alignment::AlignmentParameters;
pub use crate::shape_context::ShapeContextParameters;

/// Parameters of all stages of the crate; [`Default`] gives the values every stage documents.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
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
}

/// Sides of the simplified outline (section 2.1).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SideParameters {
    /// Tolerances of the Douglas-Peucker simplification, as shares of the square root of the outline's area. The axis
    /// is one side at 1 to 2 % in 99 % of virtual folds of real outlines; sides of all tolerances are candidates.
    pub tolerances: Vec<f64>,
    /// Sides shorter than this share of the square root of the area are no candidates: so short a fold hardly
    /// changes the garment.
    pub shortest: f64,
}

impl Default for SideParameters {
    fn default() -> Self {
        Self {
            tolerances: vec![0.02],
            shortest: 0.08,
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
            affinity: 0.15,
            most: 80,
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
    /// Components whose summed confidence is below this share of the best component's are dropped.
    pub confidence: f64,
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
            confidence: 0.01,
            most: 80,
        }
    }
}
