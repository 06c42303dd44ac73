//! What every stage promises on any input, checked on bytes that a fuzzer makes up.
//!
//! Each function reads its input from bytes and panics if the stage breaks a promise. `make fuzz` runs them under
//! libFuzzer; `cargo test` replays the inputs kept in `fuzz/corpus`, which needs neither libFuzzer nor this crate.
#![forbid(unsafe_code)]

mod bytes;
mod geometry;
mod matching;

pub use geometry::{fold, inner_distance, outline};
pub use matching::{alignment, explain, template};
