//! Gauss-Newton over the corners' displacements, the pose and the crease of one candidate, from coarse to fine.

use super::field::SeenField;
use super::normal::Normal;
use super::picture::{PictureEvidence, Sight};
use super::place::ShownRims;
use super::problem::{Evidence, Problem, State};
use super::shape::FlexibleTemplate;
use super::way::Way;
use crate::parameters::FitParameters;
use crate::{Point, Segment};

/// Where a candidate begins.
///
/// Seen units, here and in [`JointFit`], are those of the [`SeenField`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Start {
    /// The creases, first made first, each in the frame of the part that no fold turns, with the cloth on its left;
    /// of one fold a side of the seen outline in the outline's direction; empty for the template unfolded.
    pub sides: Vec<Segment>,
    /// The template point that comes to lie on `target`, in template coordinates.
    pub anchor: Point,
    /// Where it comes to lie.
    pub target: Point,
    /// Turn of the template (after its reflection, if it is reflected), in radians.
    pub turn: f64,
    /// Seen units a template unit.
    pub scale: f64,
    /// Whether the template is mirrored first (x -> -x).
    pub reflected: bool,
}

/// A template fitted to the seen outline.
#[derive(Debug, Clone)]
pub struct JointFit {
    /// Its start.
    pub start: Start,
    /// Corners of the fitted template in template units, about the template's centre, wound positively there.
    pub corners: Vec<Point>,
    /// The corners in seen units: the garment unfolded, its kept part where it lies.
    pub ring: Vec<Point>,
    /// Scale of the fitted pose: seen units a template unit.
    pub scale: f64,
    /// Turn of the fitted pose (after its reflection, if it is reflected), in radians.
    pub turn: f64,
    /// Where the template's centre lies, in seen units.
    pub centre: Point,
    /// The creases in seen units, first made first, cut to what they crease; the flap was on their left.
    pub creases: Vec<Segment>,
    /// Minus log evidence: how surprising the seen outline is under this template and crease, in nats.
    pub surprise: f64,
    /// What the picture says of it; nothing without a picture.
    pub picture: PictureEvidence,
    /// The part of the surprise that comes from the distances between the outlines alone.
    pub residual: f64,
    pub(super) state: State,
    /// Where the picture shows rims.
    pub(super) shown: ShownRims,
    /// How the garment was folded.
    pub(super) way: Way,
}

impl JointFit {
    /// Whether two fits of a template have the same creases and no corner farther apart than `distance` (seen units).
    pub(super) fn lies_as(&self, other: &Self, distance: f64) -> bool {
        let same = self.start.sides == other.start.sides && self.start.reflected == other.start.reflected;
        let near = |(a, b): (&Point, &Point)| (a - b).norm() <= distance;
        same && self.ring.iter().zip(&other.ring).all(near)
    }
}

/// How ill a start explains the seen outline as it stands, with a wide noise; `None` if it folds nothing.
pub(super) fn cost(
    field: &SeenField,
    template: &FlexibleTemplate,
    start: &Start,
    parameters: &FitParameters,
) -> Option<f64> {
    let problem = Problem::new(field, template, start.clone(), parameters)?;
    let state = problem.initial();
    let noise = parameters.coarse_noise * parameters.noise;
    problem
        .evaluate(&state, noise, Normal::of(0))
        .map(|normal| normal.residual)
}

/// A few iterations with a wide noise, to see whether a start leads anywhere.
pub(super) fn coarse(
    field: &SeenField,
    template: &FlexibleTemplate,
    start: &Start,
    parameters: &FitParameters,
) -> Option<JointFit> {
    coarse_from(field, template, start, None, parameters)
}

/// The same from a state of its own instead of the start's.
fn coarse_from(
    field: &SeenField,
    template: &FlexibleTemplate,
    start: &Start,
    state: Option<State>,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let problem = Problem::new(field, template, start.clone(), parameters)?;
    let mut state = state.unwrap_or_else(|| problem.initial());
    for _ in 0..parameters.coarse_iterations {
        state = problem.step(&state, parameters.coarse_noise * parameters.noise)?;
    }
    problem.finish(state, parameters.coarse_noise * parameters.noise)
}

/// Iterations until nothing moves, with the true noise; from the result of [`coarse`].
pub(super) fn fine(
    field: &SeenField,
    template: &FlexibleTemplate,
    from: &JointFit,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let problem = Problem::new(field, template, from.start.clone(), parameters)?;
    let mut state = from.state.clone();
    let middle = parameters.coarse_noise.sqrt() * parameters.noise;
    for _ in 0..parameters.coarse_iterations {
        state = problem.step(&state, middle)?;
    }
    settled(&problem, state)
}

/// The likeliest state on the way to where nothing moves, with the true noise.
pub(super) fn settled(problem: &Problem, mut state: State) -> Option<JointFit> {
    let parameters = problem.parameters;
    let mut best: Option<(Evidence, State)> = None;
    let mut here = problem.factored(&state, parameters.noise)?;
    for _ in 0..parameters.iterations {
        state = problem.moved(&state, &here);
        here = problem.factored(&state, parameters.noise)?;
        let evidence = problem.evidence(&here);
        let gain = best
            .as_ref()
            .map_or(f64::INFINITY, |(b, _)| b.surprise - evidence.surprise);
        if gain > 0.0 {
            best = Some((evidence, state.clone()));
        }
        if gain.abs() < 1e-3 {
            break;
        }
    }
    let (evidence, state) = best?;
    problem.told(state, &evidence)
}

/// The fit, or what another start near by ends at if that is better: a coarse fit once more from where it ended, with
/// its corners as they are and with those of the template.
pub(super) fn retried(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    parameters: &FitParameters,
) -> JointFit {
    let mut best = fit.clone();
    for bent in [1.0, 0.0] {
        let mut from = best.state.clone();
        from.displacement *= bent;
        from.bows.iter_mut().for_each(|bow| *bow *= bent);
        let again = coarse_from(field, template, &best.start, Some(from), parameters)
            .and_then(|coarse| fine(field, template, &coarse, parameters));
        if let Some(again) = again.filter(|again| again.surprise < best.surprise) {
            best = again;
        }
    }
    best
}

/// Draws the corners onto the outline: a few more iterations with a noise small enough for the template's shape to give
/// way wherever the outline is seen. The evidence stays that of the fit.
pub(super) fn polished(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let problem = Problem::resumed(field, template, fit, parameters)?;
    let mut state = fit.state.clone();
    for _ in 0..parameters.polish_iterations {
        state = problem.step(&state, parameters.polish_noise)?;
    }
    let polished = problem.finish(state, parameters.polish_noise)?;
    Some(JointFit {
        picture: fit.picture,
        surprise: fit.surprise,
        residual: fit.residual,
        ..polished
    })
}

/// The fit with what the picture says of it added to its evidence.
pub(super) fn with_picture(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    sight: &Sight,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let problem = Problem::resumed(field, template, fit, parameters)?;
    let picture = sight.evidence(&problem.laid(&fit.state)?.layers, field);
    Some(JointFit {
        picture,
        surprise: fit.surprise - picture.gain,
        ..fit.clone()
    })
}
