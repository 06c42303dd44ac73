//! What can be wrong with the input of a stage.

use thiserror::Error;

/// Why a list of points is no outline.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OutlineError {
    /// Fewer than three points.
    #[error("an outline needs at least three points, not {0}")]
    TooFewPoints(usize),
    /// A coordinate is NaN or infinite.
    #[error("point {0} of the outline is not finite")]
    NotFinite(usize),
    /// So large or so small that areas and moments of it are no numbers any more.
    #[error("the outline measures {0:e}: scale its coordinates, they must lie between 1e-50 and 1e50")]
    OutOfRange(f64),
    /// All points on one line or on one spot, or what it encloses one way round cancels what it does the other.
    #[error("the outline encloses no area: its points lie on one line, or it crosses itself or runs back over itself")]
    NoArea,
    /// Two edges that are not neighbours meet.
    #[error("edges {0} and {1} of the outline cross: an outline must not cross itself")]
    Crossing(usize, usize),
}

/// Why an outline cannot be folded over an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FoldError {
    /// The axis has no length or is not finite.
    #[error("the fold axis has no direction: its two points must be finite and apart")]
    NoDirection,
    /// The axis covers no chord of the outline: nothing is turned over.
    #[error("the fold axis does not cross the outline")]
    NoCrease,
    /// What would be turned over has no area.
    #[error("the fold axis only touches the outline: the flap has no area")]
    EmptyFlap,
    /// The crossings of the axis with the outline do not alternate: the outline crosses itself.
    #[error("the outline crosses itself where the fold axis meets it")]
    Tangled,
    /// A stack has a most number of folds.
    #[error("a stack has at most {0} folds")]
    TooManyFolds(usize),
}
