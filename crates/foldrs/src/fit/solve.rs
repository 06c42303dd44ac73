//! Gauss-Newton over the corners' displacements, the pose and the crease of one candidate.

use super::field::SeenField;
use super::layers::{pieces, Piece};
use super::rim::{RimEvidence, Rims};
use super::shape::{log_determinant, FlexibleTemplate};
use crate::crease::Axis;
use crate::fold::Layer;
use crate::parameters::FitParameters;
use crate::{Point, Segment, Vector};
use nalgebra::{DMatrix, DVector, Matrix2};

/// Where a candidate begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// The side of the seen outline that is the crease, in the outline's direction.
    pub side: Segment,
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
    /// Whether the template is folded over the side at all.
    pub folded: bool,
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
    /// Scale (seen units a template unit) and turn of the fitted pose.
    pub scale: f64,
    /// Turn of the fitted pose.
    pub turn: f64,
    /// The crease in seen units, cut to what it creases; the flap was on its left.
    pub crease: Segment,
    /// Minus log evidence: how surprising the seen outline is under this template and crease, in nats.
    pub surprise: f64,
    /// What the picture says of it; nothing without a picture.
    pub rim: RimEvidence,
    /// The part of it that comes from the distances between the outlines alone.
    pub residual: f64,
    state: State,
}

/// Free variables of a candidate.
#[derive(Debug, Clone)]
struct State {
    /// Displacements of the corners in template units, x and y in turn.
    displacement: DVector<f64>,
    /// Logarithm of the scale over the start's.
    growth: f64,
    turn: f64,
    offset: Vector,
    /// Shift of the crease across its side, in seen units.
    shift: f64,
    /// Turn of the crease from its side.
    skew: f64,
}

/// Fixed in one candidate.
struct Problem<'a> {
    field: &'a SeenField,
    template: &'a FlexibleTemplate,
    start: Start,
    /// The side as an axis with the flap on its left.
    side: Axis,
    middle: Point,
    parameters: &'a FitParameters,
}

/// A few iterations with a wide noise, to see whether a start leads anywhere.
pub(super) fn coarse(
    field: &SeenField,
    template: &FlexibleTemplate,
    start: &Start,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let problem = Problem::new(field, template, *start, parameters)?;
    let mut state = problem.initial();
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
    let problem = Problem::new(field, template, from.start, parameters)?;
    let mut state = from.state.clone();
    let middle = parameters.coarse_noise.sqrt() * parameters.noise;
    for _ in 0..parameters.coarse_iterations {
        state = problem.step(&state, middle)?;
    }
    let mut best: Option<JointFit> = None;
    for _ in 0..parameters.iterations {
        state = problem.step(&state, parameters.noise)?;
        let fit = problem.finish(state.clone(), parameters.noise)?;
        let gain = best.as_ref().map_or(f64::INFINITY, |b| b.surprise - fit.surprise);
        if gain > 0.0 {
            best = Some(fit);
        }
        if gain.abs() < 1e-3 {
            break;
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
    let problem = Problem::new(field, template, fit.start, parameters)?;
    let mut state = fit.state.clone();
    for _ in 0..parameters.polish_iterations {
        state = problem.step(&state, parameters.polish_noise)?;
    }
    let polished = problem.finish(state, parameters.polish_noise)?;
    Some(JointFit {
        rim: fit.rim,
        surprise: fit.surprise,
        residual: fit.residual,
        ..polished
    })
}

/// The fit with what the picture says of its rims added to its evidence.
pub(super) fn with_picture(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    rims: &Rims,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let problem = Problem::new(field, template, fit.start, parameters)?;
    let pieces = problem.pieces(&problem.ring(&fit.state), &problem.axis(&fit.state))?;
    let rim = rims.evidence(&pieces, field);
    Some(JointFit {
        rim,
        surprise: fit.surprise - rim.gain,
        ..fit.clone()
    })
}

impl<'a> Problem<'a> {
    fn new(
        field: &'a SeenField,
        template: &'a FlexibleTemplate,
        start: Start,
        parameters: &'a FitParameters,
    ) -> Option<Self> {
        let side = Axis::new(&[start.side[1], start.side[0]]).ok()?;
        let middle = nalgebra::center(&start.side[0], &start.side[1]);
        Some(Self {
            field,
            template,
            start,
            side,
            middle,
            parameters,
        })
    }

    fn initial(&self) -> State {
        let linear = self.linear(0.0, self.start.turn);
        let anchor = linear * (self.start.anchor - self.template.centre);
        State {
            displacement: DVector::zeros(2 * self.template.corners.len()),
            growth: 0.0,
            turn: self.start.turn,
            offset: self.start.target.coords - anchor,
            shift: 0.0,
            skew: 0.0,
        }
    }

    /// Linear part of the pose: scale, turn, and reflection.
    fn linear(&self, growth: f64, turn: f64) -> Matrix2<f64> {
        let scale = self.start.scale * growth.exp();
        let (s, c) = turn.sin_cos();
        let mirror = if self.start.reflected { -1.0 } else { 1.0 };
        Matrix2::new(c * mirror, -s, s * mirror, c) * scale
    }

    fn ring(&self, state: &State) -> Vec<Point> {
        let linear = self.linear(state.growth, state.turn);
        let corner = |i: usize| {
            let d = Vector::new(state.displacement[2 * i], state.displacement[2 * i + 1]);
            Point::from(linear * (self.template.corners[i] + d) + state.offset)
        };
        (0..self.template.corners.len()).map(corner).collect()
    }

    /// The crease, of the side's length, with the flap on its left.
    fn axis(&self, state: &State) -> Axis {
        let u = self.side.direction;
        let (s, c) = state.skew.sin_cos();
        let direction = Vector::new(c * u.x - s * u.y, s * u.x + c * u.y);
        let through = self.middle + Vector::new(-u.y, u.x) * state.shift;
        Axis {
            origin: through - direction * (self.side.length / 2.0),
            direction,
            length: self.side.length,
        }
    }

    fn pieces(&self, ring: &[Point], axis: &Axis) -> Option<Vec<Piece>> {
        pieces(ring, axis, self.start.folded.then_some(self.parameters.covered))
    }

    fn step(&self, state: &State, noise: f64) -> Option<State> {
        let normal = self.linearise(state, noise)?;
        let delta = normal.hessian.cholesky()?.solve(&(-normal.gradient));
        let n = state.displacement.len();
        // A step beyond the range in which the model is linear would lead anywhere.
        let length = (0..n)
            .map(|k| delta[k].abs())
            .fold(delta[n].abs() * 40.0, f64::max);
        let length = length
            .max(delta[n + 1].abs() * 40.0)
            .max(delta[n + 2].abs())
            .max(delta[n + 3].abs());
        let damp = (self.parameters.longest_step / length).min(1.0);
        let d = delta * damp;
        Some(State {
            displacement: &state.displacement + d.rows(0, n),
            growth: state.growth + d[n],
            turn: state.turn + d[n + 1],
            offset: state.offset + Vector::new(d[n + 2], d[n + 3]),
            shift: state.shift + d[n + 4],
            skew: state.skew + d[n + 5],
        })
    }

    /// Prior precisions of growth, turn, offset x and y, shift and skew.
    fn pose_precisions(&self) -> [f64; 6] {
        let p = self.parameters;
        [p.growth, p.turn, p.offset, p.offset, p.shift, p.skew].map(|spread| spread.powi(-2))
    }

    /// Minus log of the joint density and its quadratic approximation about a state.
    fn linearise(&self, state: &State, noise: f64) -> Option<Normal> {
        let ring = self.ring(state);
        let axis = self.axis(state);
        let pieces = self.pieces(&ring, &axis)?;
        let n = state.displacement.len();
        let mut normal = Normal {
            hessian: DMatrix::zeros(n + 6, n + 6),
            gradient: DVector::zeros(n + 6),
            residual: 0.0,
            prior: self.template.cost(&state.displacement),
        };
        normal
            .hessian
            .view_mut((0, 0), (n, n))
            .copy_from(&self.template.precision);
        normal
            .gradient
            .rows_mut(0, n)
            .copy_from(&(&self.template.precision * &state.displacement));
        let free = [state.growth, 0.0, 0.0, 0.0, state.shift, state.skew];
        for (k, (precision, value)) in self.pose_precisions().into_iter().zip(free).enumerate() {
            normal.hessian[(n + k, n + k)] += precision;
            normal.gradient[n + k] += precision * value;
            normal.prior += 0.5 * precision * value * value;
        }
        let jacobian = Jacobian {
            linear: self.linear(state.growth, state.turn),
            offset: Point::from(state.offset),
            axis,
            through: self.middle + Vector::new(-self.side.direction.y, self.side.direction.x) * state.shift,
            ring: &ring,
        };
        self.explain_seen(&pieces, &jacobian, noise, &mut normal);
        self.stay_inside(&pieces, &jacobian, noise, &mut normal);
        Some(normal)
    }

    /// Every seen point should lie near a piece of the model that runs its way.
    fn explain_seen(&self, pieces: &[Piece], jacobian: &Jacobian, noise: f64, normal: &mut Normal) {
        let p = self.parameters;
        let weight = (self.field.spacing / p.correlation).min(1.0);
        for (q, direction) in &self.field.samples {
            let mut best = (f64::INFINITY, 0, 0.0, 0.0);
            for (k, piece) in pieces.iter().enumerate() {
                let against = (1.0 - piece.direction.dot(direction) - p.bend).max(0.0);
                let opposed = 0.5 * p.against * p.against * against;
                if opposed >= best.0 {
                    continue;
                }
                let along = (piece.ends[1] - piece.ends[0]) / piece.length.max(f64::MIN_POSITIVE);
                let v = q - piece.ends[0];
                let t = (v.dot(&along) / piece.length.max(f64::MIN_POSITIVE))
                    .clamp(piece.share[0], piece.share[1]);
                let squared = (v - along * (t * piece.length)).norm_squared() + opposed;
                if squared < best.0 {
                    best = (squared, k, t, opposed);
                }
            }
            let (_, k, t, opposed) = best;
            let piece = &pieces[k];
            let x = piece.ends[0] + (piece.ends[1] - piece.ends[0]) * t;
            let v = q - x;
            let across = Vector::new(-piece.direction.y, piece.direction.x);
            // Within the edge only the distance across it counts; beyond its end, all of it.
            let inner = t > piece.share[0] && t < piece.share[1];
            let (r, w) = if inner {
                (across.dot(&v), -across)
            } else {
                let r = v.norm();
                (r, if r > 1e-9 { -v / r } else { -across })
            };
            normal.add(piece, t, r, w, opposed, noise, weight, p.tail, jacobian);
        }
    }

    /// No edge of the model should stick out of the seen outline.
    fn stay_inside(&self, pieces: &[Piece], jacobian: &Jacobian, noise: f64, normal: &mut Normal) {
        let p = self.parameters;
        for piece in pieces.iter().filter(|piece| piece.layer != Layer::Crease) {
            let visible = piece.length * (piece.share[1] - piece.share[0]);
            let count = (visible / self.field.spacing).ceil().max(1.0);
            let weight = (visible / count / p.correlation).min(1.0);
            for k in 0..count as usize {
                let t = piece.share[0] + (piece.share[1] - piece.share[0]) * (k as f64 + 0.5) / count;
                let x = piece.ends[0] + (piece.ends[1] - piece.ends[0]) * t;
                let (out, gradient) = self.field.at(&x);
                if out > 0.0 {
                    normal.add(piece, t, out, gradient, 0.0, noise, weight, p.tail, jacobian);
                }
            }
        }
    }

    fn finish(&self, state: State, noise: f64) -> Option<JointFit> {
        let normal = self.linearise(&state, noise)?;
        let poses: f64 = self.pose_precisions().iter().map(|p| p.ln()).sum();
        let log_det = log_determinant(&normal.hessian)?;
        let surprise = normal.residual + normal.prior + 0.5 * (log_det - self.template.log_det - poses);
        let ring = self.ring(&state);
        let axis = self.axis(&state);
        let ends: Vec<Point> = self
            .pieces(&ring, &axis)?
            .iter()
            .filter(|p| p.layer == Layer::Crease)
            .flat_map(|p| p.ends)
            .collect();
        let crease = match ends.as_slice() {
            [first, .., last] => [*first, *last],
            _ => self.start.side,
        };
        let corners = self
            .template
            .corners
            .iter()
            .enumerate()
            .map(|(i, c)| {
                Point::new(
                    c.x + state.displacement[2 * i],
                    c.y + state.displacement[2 * i + 1],
                )
            })
            .collect();
        Some(JointFit {
            start: self.start,
            corners,
            ring,
            scale: self.start.scale * state.growth.exp(),
            turn: state.turn,
            crease,
            surprise,
            rim: RimEvidence::default(),
            residual: normal.residual,
            state,
        })
    }
}

/// What a point of the model depends on.
struct Jacobian<'a> {
    linear: Matrix2<f64>,
    offset: Point,
    axis: Axis,
    /// The point the crease turns about.
    through: Point,
    ring: &'a [Point],
}

/// The normal equations.
struct Normal {
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    residual: f64,
    prior: f64,
}

impl Normal {
    /// Adds a residual `r` whose change is `w . dx`, x being the point of the piece's edge at share `t`.
    ///
    /// `opposed` is a squared distance that does not change; together they count by a robust loss with heavy tails.
    #[allow(clippy::too_many_arguments)]
    fn add(
        &mut self,
        piece: &Piece,
        t: f64,
        r: f64,
        w: Vector,
        opposed: f64,
        noise: f64,
        weight: f64,
        tail: f64,
        jacobian: &Jacobian,
    ) {
        let e = (r * r + opposed) / (noise * noise * tail * tail);
        self.residual += 0.5 * weight * tail * tail * e.ln_1p();
        let weight = weight / (1.0 + e) / (noise * noise);
        let n = self.gradient.len() - 6;
        let mut row = [(0, 0.0); 10];
        let axis = &jacobian.axis;
        let normal = Vector::new(-axis.direction.y, axis.direction.x);
        let count = if piece.layer == Layer::Crease {
            let x = piece.ends[0] + (piece.ends[1] - piece.ends[0]) * t;
            row[0] = (n + 4, w.dot(&normal));
            row[1] = (
                n + 5,
                w.dot(&normal) * axis.direction.dot(&(x - jacobian.through)),
            );
            2
        } else {
            let [i, j] = piece.corners;
            let x = jacobian.ring[i] + (jacobian.ring[j] - jacobian.ring[i]) * t;
            let flap = piece.layer == Layer::Flap;
            // The reflection is its own transpose.
            let u = if flap {
                axis.direction * (2.0 * axis.direction.dot(&w)) - w
            } else {
                w
            };
            let d = jacobian.linear.transpose() * u;
            let v = x - jacobian.offset;
            let corners = [
                (2 * i, d.x * (1.0 - t)),
                (2 * i + 1, d.y * (1.0 - t)),
                (2 * j, d.x * t),
                (2 * j + 1, d.y * t),
            ];
            row[..4].copy_from_slice(&corners);
            row[4] = (n, u.dot(&v));
            row[5] = (n + 1, u.dot(&Vector::new(-v.y, v.x)));
            row[6] = (n + 2, u.x);
            row[7] = (n + 3, u.y);
            if flap {
                let from = x - jacobian.through;
                let turned = normal * axis.direction.dot(&from) + axis.direction * normal.dot(&from);
                row[8] = (n + 4, 2.0 * w.dot(&normal));
                row[9] = (n + 5, 2.0 * w.dot(&turned));
                10
            } else {
                8
            }
        };
        let row = &row[..count];
        for &(a, x) in row {
            self.gradient[a] += weight * r * x;
            for &(b, y) in row {
                self.hessian[(a, b)] += weight * x * y;
            }
        }
    }
}
