//! The rims of the layer on top, placed where the picture shows them.
//!
//! A flap that ends inside the outline may reach farther or less far than the template says, and the outline does not
//! tell. The fit's own covariance says along which directions it leaves the rims open; along these the picture's
//! evidence is searched, and where it outweighs what the shape says the model is fitted again with its rims held there.

use super::field::SeenField;
use super::layers::Piece;
use super::normal::{Factored, Jacobian};
use super::picture::Sight;
use super::problem::{Laid, Problem, State};
use super::shape::FlexibleTemplate;
use super::solve::JointFit;
use crate::fold::Layer;
use crate::parameters::FitParameters;
use crate::stack::{Source, Turns};
use crate::Point;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Where the picture shows rims.
#[derive(Debug, Clone, Default)]
pub(super) struct ShownRims {
    pub(super) places: Vec<ShownRim>,
    /// Spread of a rim about where it is shown.
    pub(super) spread: f64,
}

/// One place of a rim.
#[derive(Debug, Clone)]
pub(super) struct ShownRim {
    source: Source,
    turned: Turns,
    /// Share of its source.
    pub(super) t: f64,
    /// Where the picture shows it.
    pub(super) place: Point,
    /// How many observations it stands for.
    pub(super) weight: f64,
}

impl ShownRim {
    /// Whether it belongs to a piece of the model.
    pub(super) fn is_of(&self, piece: &Piece) -> bool {
        piece.source == self.source && piece.turned == self.turned
    }
}

/// A direction in which the outline leaves the rims open.
struct Open {
    /// How far the rims spread along it, the root of their mean square.
    spread: f64,
    /// The change of all variables by one spread.
    change: DVector<f64>,
}

/// Nats by which a search must better the fit: less is not worth another one.
const WORTH: f64 = 0.5;
/// The search's steps get smaller by half from round to round.
const ROUNDS: [f64; 3] = [1.0, 0.5, 0.25];
/// Most steps to either side.
const MOST_STEPS: f64 = 16.0;
/// Iterations of the fit with the rims held.
const ITERATIONS: usize = 8;

/// The fit with its rims where the picture shows them; `None` if that is no likelier.
pub(super) fn placed(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    sight: &Sight,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let mut problem = Problem::resumed(field, template, fit, parameters)?;
    let here = problem.factored(&fit.state, parameters.noise)?;
    let open = open_directions(&problem, &fit.state, &here, sight)?;
    let state = shown_state(&problem, fit, &open, sight)?;
    problem.shown = ShownRims {
        places: rims_on_top(&problem, &state, sight)?,
        spread: sight.region.placement,
    };
    fitted_again(&problem, state, sight).filter(|again| again.surprise < fit.surprise)
}

/// The directions in which the outline leaves the rims most open: main axes of the rims' covariance under the fit's.
fn open_directions(problem: &Problem, state: &State, here: &Factored, sight: &Sight) -> Option<Vec<Open>> {
    let laid = problem.laid(state)?;
    let jacobian = problem.jacobian(state, &laid);
    let lower = here.factor.l_dirty();
    let variables = here.gradient.len();
    let mut moments = DMatrix::zeros(variables, variables);
    let (mut row, mut total) = (Vec::new(), 0.0);
    for rim in rims_within(problem, &laid, &jacobian, sight).filter(|rim| rim.piece.layer != Layer::Crease) {
        row.clear();
        jacobian.row(rim.piece, rim.t, rim.piece.across(), variables, &mut row);
        let mut moved = DVector::zeros(variables);
        for &(variable, by) in &row {
            moved[variable] += by;
        }
        // In the variables in which the fit's covariance is one.
        if lower.solve_lower_triangular_mut(&mut moved) {
            moments.ger(rim.length, &moved, &moved, 1.0);
            total += rim.length;
        }
    }
    if total <= 0.0 {
        return None;
    }
    let eigen = SymmetricEigen::new(moments / total);
    let mut order: Vec<usize> = (0..variables).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let direction = |&k: &usize| {
        let spread = eigen.eigenvalues[k].max(0.0).sqrt();
        let mut change = eigen.eigenvectors.column(k).into_owned();
        let solved = spread > sight.region.open && lower.tr_solve_lower_triangular_mut(&mut change);
        solved.then_some(Open { spread, change })
    };
    Some(
        order
            .iter()
            .take(sight.region.directions)
            .filter_map(direction)
            .collect(),
    )
}

/// The state within what the outline leaves open that the picture and the fit together make likeliest; `None` if that
/// is hardly likelier than the fit itself.
fn shown_state(problem: &Problem, fit: &JointFit, open: &[Open], sight: &Sight) -> Option<State> {
    let p = sight.region;
    let variables = open.first()?.change.len();
    let at = |z: &[f64]| {
        let mut change = DVector::zeros(variables);
        for (z, open) in z.iter().zip(open) {
            change.axpy(*z, &open.change, 1.0);
        }
        problem.shifted(&fit.state, &change)
    };
    let worth = |z: &[f64]| {
        let laid = problem.laid(&at(z))?;
        let cost = 0.5 * z.iter().map(|z| z * z).sum::<f64>();
        Some(sight.evidence(&laid.layers, problem.field).gain - cost)
    };
    let mut best = vec![0.0; open.len()];
    let mut most = worth(&best)?;
    let enough = most + WORTH;
    for fineness in ROUNDS {
        for (k, open) in open.iter().enumerate() {
            let step = fineness * p.step / open.spread;
            let (from, reach) = if fineness == ROUNDS[0] {
                (0.0, (p.range / step).min(MOST_STEPS))
            } else {
                (best[k], 2.0)
            };
            for i in -(reach as i64)..=reach as i64 {
                let mut there = best.clone();
                there[k] = from + i as f64 * step;
                if let Some(value) = worth(&there).filter(|&value| value > most) {
                    (most, best) = (value, there);
                }
            }
        }
    }
    (most > enough).then(|| at(&best))
}

/// The rims of the layer on top within the cloth, where a state has them.
fn rims_on_top(problem: &Problem, state: &State, sight: &Sight) -> Option<Vec<ShownRim>> {
    let laid = problem.laid(state)?;
    let jacobian = problem.jacobian(state, &laid);
    let on_top = if sight.evidence(&laid.layers, problem.field).flap_on_top > 0.0 {
        Layer::Flap
    } else {
        Layer::Kept
    };
    let shown = |rim: Rim| ShownRim {
        source: rim.piece.source,
        turned: rim.piece.turned,
        t: rim.t,
        place: rim.place,
        weight: rim.length / problem.parameters.correlation,
    };
    let rims = rims_within(problem, &laid, &jacobian, sight);
    Some(rims.filter(|rim| rim.piece.layer == on_top).map(shown).collect())
}

/// A place of a model's boundary within the cloth.
struct Rim<'a> {
    piece: &'a Piece,
    t: f64,
    place: Point,
    /// The length it stands for.
    length: f64,
}

/// Places along all of a model's boundary as far as it lies within the cloth.
fn rims_within<'a>(
    problem: &'a Problem,
    laid: &'a Laid,
    jacobian: &'a Jacobian,
    sight: &'a Sight,
) -> impl Iterator<Item = Rim<'a>> {
    let along = move |piece: &'a Piece| {
        piece.places(problem.field.spacing).map(move |(t, length)| Rim {
            piece,
            t,
            place: jacobian.point(piece, t),
            length,
        })
    };
    let all = laid.layers.pieces.iter().flat_map(along);
    all.filter(move |rim| problem.field.at(&rim.place).0 < -sight.region.inside)
}

/// The likeliest of a few iterations with the rims held. How surely the picture places them counts in the volume of
/// what is left open, so that a rim looked for at many places pays for the choice.
fn fitted_again(problem: &Problem, mut state: State, sight: &Sight) -> Option<JointFit> {
    let mut best: Option<JointFit> = None;
    for _ in 0..ITERATIONS {
        let here = problem.factored(&state, problem.parameters.noise)?;
        let evidence = problem.evidence(&here);
        let picture = sight.evidence(&problem.laid(&state)?.layers, problem.field);
        let surprise = evidence.surprise - picture.gain;
        if best.as_ref().is_none_or(|best| surprise < best.surprise) {
            best = Some(JointFit {
                picture,
                surprise,
                ..problem.told(state.clone(), &evidence)?
            });
        }
        state = problem.moved(&state, &here);
    }
    best
}
