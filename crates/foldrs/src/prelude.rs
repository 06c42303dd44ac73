//! What most programs need: `use foldrs::prelude::*;`
//!
//! From an outline to the fold: [`Seen`] prepares it, [`match_folded`] names the likely folds, [`explain`] lays one of
//! them over the outline; or [`claim_axes`] and [`explain_jointly`] fit template and crease together.

pub use crate::error::{FoldError, OutlineError};
pub use crate::fit::{explain_jointly, FlexibleTemplate, FoldCount, JointExplanation, JointFits};
pub use crate::fold::{fold, Folded, Layer};
pub use crate::matching::{claim_axes, explain, match_folded, Candidate, Claim, Explanation, Matching, Seen};
pub use crate::outline::Outline;
pub use crate::parameters::Parameters;
pub use crate::{Point, Segment, Vector};
