#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod alignment;
pub mod crease;
pub mod error;
pub mod fit;
pub mod fold;
pub mod hypothesis;
pub mod inner_distance;
pub mod interrupt;
pub mod landmark;
pub mod matching;
pub mod model;
pub mod outline;
pub mod parameters;
pub mod partial_match;
pub mod prelude;
pub mod registration;
pub mod shape_context;
pub mod stack;

mod parallel;
mod wide;

// The outlines of the integration tests, for the tests of what is not public.
#[cfg(test)]
extern crate self as foldrs;
#[cfg(test)]
#[path = "../tests/common/mod.rs"]
mod common;

pub use error::{FoldError, OutlineError};
pub use fold::{fold, Folded, Layer};
pub use matching::{match_folded, Candidate, Matching, Seen};
pub use outline::Outline;
pub use parameters::Parameters;

/// A point of the plane, in image px or template units as the function says.
pub type Point = nalgebra::Point2<f64>;

/// A displacement in the plane.
pub type Vector = nalgebra::Vector2<f64>;

/// A directed segment, from its first point to its second; a fold axis or a crease.
pub type Segment = [Point; 2];
