//! Draws from what is as likely as a fit: where the flap is hidden its corners may lie elsewhere, and with them what a
//! gripper can reach.
//!
//! About a fit the density of all variables is taken to be Gaussian, as for its evidence (Laplace's approximation): the
//! normal equations' matrix is the inverse of the covariance.

use super::field::SeenField;
use super::problem::Problem;
use super::shape::FlexibleTemplate;
use super::solve::JointFit;
use crate::parameters::FitParameters;
use nalgebra::DVector;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Where the same numbers begin for every fit: the same outline gives the same draws.
const SEED: u128 = 0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835;

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
    let evidence = problem.evidence(&here);
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
