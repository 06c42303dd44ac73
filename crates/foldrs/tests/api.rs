//! What the crate promises of its public types, whatever they hold.

use foldrs::prelude::*;
use foldrs::{
    alignment, crease, fit, fold as folding, hypothesis, inner_distance, interrupt, model, outline,
};
use foldrs::{parameters, partial_match, registration, shape_context, stack};
use std::error::Error;
use std::fmt::Debug;

/// Compiles only for types that can be cloned, shown, sent to and shared between threads.
fn handy<T: Send + Sync + Clone + Debug + 'static>() {}

#[test]
fn public_types_can_be_cloned_shown_and_shared_between_threads() {
    handy::<(Point, Vector, Segment)>();
    handy::<(Outline, outline::Nearest, outline::Side)>();
    handy::<(partial_match::ChordAngles, partial_match::PartialMatch)>();
    handy::<(hypothesis::Face, hypothesis::Hypothesis, hypothesis::SampledFace)>();
    handy::<(crease::Axis, crease::Chord, crease::Crossing)>();
    handy::<(
        Folded,
        folding::FoldedPoint,
        folding::Piece,
        folding::Source,
        Layer,
    )>();
    handy::<inner_distance::InnerDistances>();
    handy::<(
        shape_context::ShapeContexts,
        shape_context::CostMatrix,
        shape_context::ShapeContextParameters,
    )>();
    handy::<(alignment::Alignment, alignment::AlignmentParameters)>();
    handy::<(Seen, Claim, Candidate, Matching, Explanation)>();
    handy::<registration::PlaneMap>();
    handy::<(FlexibleTemplate, JointExplanation, JointFits)>();
    handy::<(
        fit::JointFit,
        fit::Looks,
        fit::Picture,
        fit::PictureEvidence,
        fit::SeenField,
        fit::Start,
    )>();
    handy::<(fit::FoldCount, fit::KnownFold)>();
    handy::<(stack::Cloth, stack::Crease, stack::FoldedStack, stack::Turns)>();
    handy::<model::Region>();
    handy::<(
        Parameters,
        parameters::FitParameters,
        parameters::RimParameters,
        parameters::RegionParameters,
        parameters::SideParameters,
        parameters::PartialMatchParameters,
        parameters::HypothesisParameters,
        parameters::ParameterError,
    )>();
    handy::<(interrupt::Interrupt, interrupt::Interrupted)>();
    handy::<(FoldError, OutlineError)>();
}

#[test]
fn errors_travel_through_a_box_and_tell_what_was_wrong() {
    fn folded(corners: &[[f64; 2]], axis: Segment) -> Result<Folded, Box<dyn Error + Send + Sync>> {
        Ok(fold(&Outline::try_from(corners)?, &axis)?)
    }
    let sheet = [[0.0, 0.0], [60.0, 0.0], [60.0, 40.0], [0.0, 40.0]];
    let across = [Point::new(30.0, 40.0), Point::new(30.0, 0.0)];
    let beside = [Point::new(90.0, 40.0), Point::new(90.0, 0.0)];

    assert!(folded(&sheet, across).is_ok());
    let told = folded(&sheet[..2], across).unwrap_err();
    assert!(told.to_string().contains("at least three points, not 2"));
    assert!(told.downcast_ref::<OutlineError>().is_some());
    let told = folded(&sheet, beside).unwrap_err();
    assert_eq!(told.downcast_ref(), Some(&FoldError::NoCrease));
    assert!(told.to_string().contains("does not cross the outline"));
}
