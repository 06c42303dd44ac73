//! Gauss-Newton over the corners' displacements, the pose and the crease of one candidate.

use super::field::SeenField;
use super::layers::{fold_layers, Layers, Piece};
use super::nearest::{nearest_pieces, Nearest};
use super::normal::{Factored, Jacobian, Normal, POSE};
use super::rim::{RimEvidence, Rims};
use super::shape::FlexibleTemplate;
use crate::crease::Axis;
use crate::fold::Layer;
use crate::parameters::FitParameters;
use crate::{Point, Segment, Vector};
use nalgebra::{DVector, Matrix2};

/// Where a candidate begins.
#[derive(Debug, Clone, PartialEq)]
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
    /// Scale (seen units a template unit) and turn of the fitted pose.
    pub scale: f64,
    /// Turn of the fitted pose.
    pub turn: f64,
    /// Where the template's centre lies, in seen units.
    pub centre: Point,
    /// The creases in seen units, first made first, cut to what they crease; the flap was on their left.
    pub creases: Vec<Segment>,
    /// Minus log evidence: how surprising the seen outline is under this template and crease, in nats.
    pub surprise: f64,
    /// What the picture says of it; nothing without a picture.
    pub rim: RimEvidence,
    /// The part of it that comes from the distances between the outlines alone.
    pub residual: f64,
    state: State,
}

impl JointFit {
    /// Whether two fits of a template have the same creases and no corner farther apart than `distance` (seen units).
    pub(super) fn lies_as(&self, other: &Self, distance: f64) -> bool {
        let same = self.start.sides == other.start.sides && self.start.reflected == other.start.reflected;
        let near = |(a, b): (&Point, &Point)| (a - b).norm() <= distance;
        same && self.ring.iter().zip(&other.ring).all(near)
    }
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
    /// Where every crease lies, first made first.
    slips: Vec<Slip>,
    /// How far every edge bulges to its left in the middle, in seen units: hems and seams are not straight.
    bows: Vec<f64>,
}

/// How a crease lies beside its side.
#[derive(Debug, Clone, Copy, Default)]
struct Slip {
    /// Shift across the side, in seen units.
    shift: f64,
    /// Turn from the side.
    skew: f64,
}

/// Fixed in one candidate.
struct Problem<'a> {
    field: &'a SeenField,
    template: &'a FlexibleTemplate,
    start: Start,
    /// The sides as axes with the flap on their left, first made first, and their middles.
    sides: Vec<(Axis, Point)>,
    /// Spread of every edge's bow, in seen units.
    bow_spreads: Vec<f64>,
    parameters: &'a FitParameters,
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
    let problem = Problem::new(field, template, fit.start.clone(), parameters)?;
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
    let problem = Problem::new(field, template, fit.start.clone(), parameters)?;
    let layers = problem.layers(&problem.ring(&fit.state), &problem.axes(&fit.state))?;
    let rim = rims.evidence(&layers.pieces, field);
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
        let turned = |side: &Segment| {
            let middle = nalgebra::center(&side[0], &side[1]);
            Some((Axis::new(&[side[1], side[0]]).ok()?, middle))
        };
        let sides = start.sides.iter().map(turned).collect::<Option<_>>()?;
        let corners = &template.corners;
        let length = |i: usize| (corners[(i + 1) % corners.len()] - corners[i]).norm() * start.scale;
        let unit = template.area.sqrt() * start.scale;
        let bow_spreads = (0..corners.len())
            .map(|i| parameters.bow * (length(i) * unit).sqrt())
            .collect();
        Some(Self {
            field,
            template,
            start,
            sides,
            bow_spreads,
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
            slips: vec![Slip::default(); self.sides.len()],
            bows: vec![0.0; self.template.corners.len()],
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

    /// The creases, of their sides' lengths, with the flap on their left.
    fn axes(&self, state: &State) -> Vec<Axis> {
        let axis = |((side, _), slip): (&(Axis, Point), &Slip)| {
            let u = side.direction;
            let (s, c) = slip.skew.sin_cos();
            let direction = Vector::new(c * u.x - s * u.y, s * u.x + c * u.y);
            Axis {
                origin: Point::origin(),
                direction,
                length: side.length,
            }
        };
        let mut axes: Vec<Axis> = self.sides.iter().zip(&state.slips).map(axis).collect();
        for (axis, through) in axes.iter_mut().zip(self.pivots(state)) {
            axis.origin = through - axis.direction * (axis.length / 2.0);
        }
        axes
    }

    /// The points the creases turn about.
    fn pivots(&self, state: &State) -> Vec<Point> {
        let pivot = |((side, middle), slip): (&(Axis, Point), &Slip)| {
            middle + Vector::new(-side.direction.y, side.direction.x) * slip.shift
        };
        self.sides.iter().zip(&state.slips).map(pivot).collect()
    }

    fn layers(&self, ring: &[Point], axes: &[Axis]) -> Option<Layers> {
        fold_layers(ring, axes, self.parameters.covered)
    }

    fn step(&self, state: &State, noise: f64) -> Option<State> {
        let normal = self.linearise(state, noise, false)?;
        Some(self.moved(state, &normal.factored()?))
    }

    /// The state one step on.
    fn moved(&self, state: &State, here: &Factored) -> State {
        let delta = here.factor.solve(&-&here.gradient);
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
        State {
            displacement: &state.displacement + d.rows(0, n),
            growth: state.growth + d[n],
            turn: state.turn + d[n + 1],
            offset: state.offset + Vector::new(d[n + 2], d[n + 3]),
            slips: (0..state.slips.len())
                .map(|k| Slip {
                    shift: state.slips[k].shift + d[n + POSE + 2 * k],
                    skew: state.slips[k].skew + d[n + POSE + 2 * k + 1],
                })
                .collect(),
            bows: (0..state.bows.len())
                .map(|i| state.bows[i] + d[n + POSE + 2 * state.slips.len() + i])
                .collect(),
        }
    }

    /// Prior precisions of growth, turn, offset x and y, every crease's shift and skew, and every edge's bow.
    fn free_precisions(&self) -> Vec<f64> {
        let p = self.parameters;
        let mut spreads = vec![p.growth, p.turn, p.offset, p.offset];
        for k in 0..self.sides.len() {
            // Of an earlier fold's crease the outline shows a part, or what a later fold turned over.
            let last = k + 1 == self.sides.len();
            spreads.extend(if last {
                [p.shift, p.skew]
            } else {
                [p.earlier_shift, p.earlier_skew]
            });
        }
        spreads.extend(&self.bow_spreads);
        spreads.into_iter().map(|spread| spread.powi(-2)).collect()
    }

    /// Minus log of the joint density and its quadratic approximation about a state, without the density itself
    /// unless it is `weighed`.
    fn linearise(&self, state: &State, noise: f64, weighed: bool) -> Option<Normal> {
        let n = state.displacement.len();
        let mut normal = Normal::of(n + POSE + 2 * self.sides.len() + state.bows.len());
        normal.weighed = weighed;
        normal.prior = self.template.cost(&state.displacement);
        normal
            .hessian
            .view_mut((0, 0), (n, n))
            .copy_from(&self.template.precision);
        normal
            .gradient
            .rows_mut(0, n)
            .copy_from(&(&self.template.precision * &state.displacement));
        let slips = state.slips.iter().flat_map(|slip| [slip.shift, slip.skew]);
        let free = [state.growth, 0.0, 0.0, 0.0].into_iter().chain(slips);
        let free = free.chain(state.bows.iter().copied());
        for (k, (precision, value)) in self.free_precisions().into_iter().zip(free).enumerate() {
            normal.hessian[(n + k, n + k)] += precision;
            normal.gradient[n + k] += precision * value;
            normal.prior += 0.5 * precision * value * value;
        }
        self.evaluate(state, noise, normal)
    }

    /// Adds what the outlines say of a state.
    fn evaluate(&self, state: &State, noise: f64, mut normal: Normal) -> Option<Normal> {
        let ring = self.ring(state);
        let axes = self.axes(state);
        let Layers { pieces, creases } = self.layers(&ring, &axes)?;
        let jacobian = Jacobian {
            linear: self.linear(state.growth, state.turn),
            offset: Point::from(state.offset),
            axes: &axes,
            pivots: &self.pivots(state),
            creases: &creases,
            ring: &ring,
            bows: &state.bows,
        };
        self.explain_seen(&pieces, &jacobian, noise, &mut normal);
        self.stay_inside(&pieces, &jacobian, noise, &mut normal);
        Some(normal)
    }

    /// Every seen point should lie near a piece of the model that runs its way.
    fn explain_seen(&self, pieces: &[Piece], jacobian: &Jacobian, noise: f64, normal: &mut Normal) {
        let p = self.parameters;
        let weight = (self.field.spacing / p.correlation).min(1.0);
        let nearest = nearest_pieces(&self.field.samples, pieces, p.against, p.bend);
        for ((q, _), Nearest { piece: k, t, opposed }) in self.field.samples.iter().zip(nearest) {
            let piece = &pieces[k];
            let v = q - jacobian.point(piece, t);
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
                if let Some((out, gradient)) = self.field.outside(&jacobian.point(piece, t)) {
                    normal.add(piece, t, out, gradient, 0.0, noise, weight, p.tail, jacobian);
                }
            }
        }
    }

    /// The density and its approximation about a state, ready for both its evidence and a step.
    fn factored(&self, state: &State, noise: f64) -> Option<Factored> {
        self.linearise(state, noise, true)?.factored()
    }

    fn evidence(&self, here: &Factored) -> Evidence {
        let poses: f64 = self.free_precisions().iter().map(|p| p.ln()).sum();
        let log_det = 2.0
            * here
                .factor
                .l_dirty()
                .diagonal()
                .iter()
                .map(|x| x.ln())
                .sum::<f64>();
        Evidence {
            surprise: here.residual + here.prior + 0.5 * (log_det - self.template.log_det - poses),
            residual: here.residual,
        }
    }

    fn finish(&self, state: State, noise: f64) -> Option<JointFit> {
        let evidence = self.evidence(&self.factored(&state, noise)?);
        self.told(state, &evidence)
    }

    fn told(&self, state: State, evidence: &Evidence) -> Option<JointFit> {
        let ring = self.ring(&state);
        let axes = self.axes(&state);
        let layers = self.layers(&ring, &axes)?;
        let creases = (0..axes.len()).map(|k| layers.creased(k, &axes[k])).collect();
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
            start: self.start.clone(),
            corners,
            ring,
            scale: self.start.scale * state.growth.exp(),
            turn: state.turn,
            centre: Point::from(state.offset),
            creases,
            surprise: evidence.surprise,
            rim: RimEvidence::default(),
            residual: evidence.residual,
            state,
        })
    }
}

/// How well a state explains the seen outline.
struct Evidence {
    /// Minus log evidence.
    surprise: f64,
    residual: f64,
}
