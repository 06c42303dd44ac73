//! Draws from what is as likely as a fit: where the flap is hidden its corners may lie elsewhere, and with them what a
//! gripper can reach.
//!
//! About a fit the density of all variables is taken to be Gaussian, as for its evidence (Laplace's approximation): the
//! normal equations' matrix is the inverse of the covariance.

use super::explain::JointExplanation;
use super::field::SeenField;
use super::problem::{Evidence, Problem};
use super::shape::FlexibleTemplate;
use super::solve::JointFit;
use crate::landmark::{reach, Landmark, Reach};
use crate::parameters::FitParameters;
use crate::{parallel, Outline, Point, Segment};
use nalgebra::DVector;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Where the same numbers begin for every fit: the same outline gives the same draws.
const SEED: u128 = 0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835;

/// A garment as it may lie as well, in the units of the explanation it belongs to.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Draw {
    /// Corners of the garment unfolded, its kept part where it lies, in seen units, in the order of the template given.
    pub outline: Vec<Point>,
    /// The creases, first made first; the flap was on their left.
    pub creases: Vec<Segment>,
}

impl Draw {
    /// Where an explanation has the garment.
    pub(super) fn of(told: &JointExplanation) -> Self {
        let corners = told.outline.iter();
        Self {
            outline: corners.map(|corner| told.to_seen.apply(corner)).collect(),
            creases: told.creases.clone(),
        }
    }
}

impl JointExplanation {
    /// How well a gripper reaches points of the fitted template's outline in up to so many of the draws, in seen units.
    /// Draws that do not fold are left out; without draws it is the fitted garment itself.
    ///
    /// `points` are in template units, on [`JointExplanation::outline`].
    #[must_use]
    pub fn reach_drawn(&self, points: &[Point], most: usize) -> Vec<Vec<Reach>> {
        let marks: Vec<Landmark> = points
            .iter()
            .filter_map(|p| Landmark::nearest(&self.outline, p))
            .collect();
        let reached = |draw: &Draw| {
            let places: Option<Vec<Point>> = marks.iter().map(|mark| mark.on(&draw.outline)).collect();
            let outline = Outline::new(draw.outline.clone()).ok()?;
            reach(&outline, &draw.creases, &places?).ok()
        };
        let own = [Draw::of(self)];
        let draws = if self.draws.is_empty() {
            &own
        } else {
            self.draws.as_slice()
        };
        let drawn = parallel::map(&draws[..most.min(draws.len())], reached);
        drawn.into_iter().flatten().collect()
    }
}

/// Fits drawn about another, each with its mirror image in the space of the variables: their mean is the fit. Those
/// that lose their crease are left out.
pub(super) fn drawn(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    parameters: &FitParameters,
) -> Vec<JointFit> {
    let pairs = parameters.draws.div_ceil(2);
    let Some(problem) = Problem::resumed(field, template, fit, parameters) else {
        return Vec::new();
    };
    let Some(here) = problem.factored(&fit.state, parameters.noise) else {
        return Vec::new();
    };
    // That of a draw is of no use, nor is it asked for.
    let evidence = Evidence {
        surprise: fit.surprise,
        residual: fit.residual,
    };
    let spread = parameters.draw_variance.sqrt();
    let mut random = Pcg64Mcg::new(SEED);
    let mut draws = Vec::with_capacity(2 * pairs);
    for _ in 0..pairs {
        let mut step = DVector::from_fn(here.gradient.len(), |_, _| {
            let normal: f64 = StandardNormal.sample(&mut random);
            spread * normal
        });
        here.factor.l_dirty().tr_solve_lower_triangular_mut(&mut step);
        draws.extend(problem.told(problem.shifted(&fit.state, &step), &evidence));
        draws.extend(problem.told(problem.shifted(&fit.state, &-step), &evidence));
    }
    draws
}
