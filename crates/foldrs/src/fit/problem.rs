//! One candidate: its variables, what they explain of the seen outline, and the step that explains more.

use super::field::SeenField;
use super::layers::{fold_layers, Layers, Piece};
use super::nearest::{nearest_pieces, Nearest};
use super::normal::{Factored, Jacobian, Normal, POSE};
use super::picture::PictureEvidence;
use super::place::ShownRims;
use super::shape::FlexibleTemplate;
use super::solve::{JointFit, Start};
use super::way::Way;
use crate::crease::Axis;
use crate::fold::Layer;
use crate::outline::encloses;
use crate::parameters::FitParameters;
use crate::{Point, Segment, Vector};
use nalgebra::{DVector, Matrix2};

/// Free variables of a candidate.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// Displacements of the corners in template units, x and y in turn.
    pub(super) displacement: DVector<f64>,
    /// Logarithm of the scale over the start's.
    pub(super) growth: f64,
    pub(super) turn: f64,
    pub(super) offset: Vector,
    /// Where every crease lies, first made first.
    slips: Vec<Slip>,
    /// How far every edge bulges to its left in the middle, in seen units: hems and seams are not straight.
    pub(super) bows: Vec<f64>,
}

/// How a crease lies beside its side.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slip {
    /// Shift across the side, in seen units.
    shift: f64,
    /// Turn from the side.
    skew: f64,
}

/// Fixed in one candidate.
pub(super) struct Problem<'a> {
    pub(super) field: &'a SeenField,
    pub(super) template: &'a FlexibleTemplate,
    pub(super) start: Start,
    /// The sides as axes with the flap on their left, first made first, and their middles.
    pub(super) sides: Vec<(Axis, Point)>,
    /// Spread of every edge's bow, in seen units.
    bow_spreads: Vec<f64>,
    pub(super) parameters: &'a FitParameters,
    /// Where the picture shows rims.
    pub(super) shown: ShownRims,
    /// How the garment was folded.
    pub(super) way: Way,
}

/// The model of a state, folded.
pub(super) struct Laid {
    ring: Vec<Point>,
    axes: Vec<Axis>,
    /// The points the creases turn about.
    pivots: Vec<Point>,
    pub(super) layers: Layers,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
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
            shown: ShownRims::default(),
            way: Way::default(),
        })
    }

    /// The problem a fit is a solution of.
    pub(super) fn resumed(
        field: &'a SeenField,
        template: &'a FlexibleTemplate,
        fit: &JointFit,
        parameters: &'a FitParameters,
    ) -> Option<Self> {
        Some(Self {
            shown: fit.shown.clone(),
            way: fit.way,
            ..Self::new(field, template, fit.start.clone(), parameters)?
        })
    }

    pub(super) fn initial(&self) -> State {
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
    pub(super) fn linear(&self, growth: f64, turn: f64) -> Matrix2<f64> {
        let scale = self.start.scale * growth.exp();
        let (s, c) = turn.sin_cos();
        let mirror = if self.start.reflected { -1.0 } else { 1.0 };
        Matrix2::new(c * mirror, -s, s * mirror, c) * scale
    }

    pub(super) fn ring(&self, state: &State) -> Vec<Point> {
        let linear = self.linear(state.growth, state.turn);
        let corner = |i: usize| {
            let d = Vector::new(state.displacement[2 * i], state.displacement[2 * i + 1]);
            Point::from(linear * (self.template.corners[i] + d) + state.offset)
        };
        (0..self.template.corners.len()).map(corner).collect()
    }

    /// The creases, of their sides' lengths, with the flap on their left.
    pub(super) fn axes(&self, state: &State) -> Vec<Axis> {
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
    pub(super) fn pivots(&self, state: &State) -> Vec<Point> {
        let pivot = |((side, middle), slip): (&(Axis, Point), &Slip)| middle + side.normal() * slip.shift;
        self.sides.iter().zip(&state.slips).map(pivot).collect()
    }

    /// The model folded; `None` if a crease folds nothing.
    pub(super) fn laid(&self, state: &State) -> Option<Laid> {
        let (ring, axes) = (self.ring(state), self.axes(state));
        let layers = fold_layers(&ring, &axes, self.parameters.covered)?;
        Some(Laid {
            pivots: self.pivots(state),
            ring,
            axes,
            layers,
        })
    }

    /// How the points of a folded model move with its variables.
    pub(super) fn jacobian<'b>(&self, state: &'b State, laid: &'b Laid) -> Jacobian<'b> {
        Jacobian {
            linear: self.linear(state.growth, state.turn),
            offset: Point::from(state.offset),
            axes: &laid.axes,
            pivots: &laid.pivots,
            creases: &laid.layers.creases,
            ring: &laid.ring,
            bows: &state.bows,
        }
    }

    pub(super) fn step(&self, state: &State, noise: f64) -> Option<State> {
        let normal = self.linearise(state, noise, false)?;
        Some(self.moved(state, &normal.factored()?))
    }

    /// The state one step on.
    pub(super) fn moved(&self, state: &State, here: &Factored) -> State {
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
        self.shifted(state, &(delta * damp))
    }

    /// The state with its variables changed by so much.
    pub(super) fn shifted(&self, state: &State, d: &DVector<f64>) -> State {
        let n = state.displacement.len();
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
        for deviation in self.deviations(state) {
            normal.hold(&deviation);
        }
        self.evaluate(state, noise, normal)
    }

    /// Adds what the outlines say of a state.
    pub(super) fn evaluate(&self, state: &State, noise: f64, mut normal: Normal) -> Option<Normal> {
        let laid = self.laid(state)?;
        let jacobian = self.jacobian(state, &laid);
        let pieces = &laid.layers.pieces;
        self.explain_seen(pieces, &jacobian, noise, &mut normal);
        self.stay_inside(&laid.layers, &jacobian, noise, &mut normal);
        self.follow_shown(pieces, &jacobian, &mut normal);
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
            let across = piece.across();
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

    /// No edge of the model should stick out of the seen outline, and none that has nothing but the table beside it
    /// should lie far within: it would have been seen.
    fn stay_inside(&self, layers: &Layers, jacobian: &Jacobian, noise: f64, normal: &mut Normal) {
        let p = self.parameters;
        let deep = p.bare * noise;
        let cloths = layers.rings();
        for piece in layers.pieces.iter().filter(|piece| piece.layer != Layer::Crease) {
            for (t, length) in piece.places(self.field.spacing) {
                let place = jacobian.point(piece, t);
                let (out, gradient) = self.field.at(&place);
                // A gap narrower than the noise may be closed.
                let bare = || {
                    !cloths
                        .iter()
                        .any(|ring| encloses(ring, &(place - piece.across() * p.noise)))
                };
                let off = if out > 0.0 {
                    out
                } else if out < -deep && bare() {
                    out + deep
                } else {
                    continue;
                };
                let weight = (length / p.correlation).min(1.0);
                normal.add(piece, t, off, gradient, 0.0, noise, weight, p.tail, jacobian);
            }
        }
    }

    /// Rims should lie where the picture shows them. How well they do is for the picture's evidence to tell.
    fn follow_shown(&self, pieces: &[Piece], jacobian: &Jacobian, normal: &mut Normal) {
        let (residual, tail) = (normal.residual, self.parameters.tail);
        for rim in &self.shown.places {
            let Some(piece) = pieces.iter().find(|piece| rim.is_of(piece)) else {
                continue;
            };
            let off = piece.across().dot(&(rim.place - jacobian.point(piece, rim.t)));
            let spread = self.shown.spread;
            normal.add(
                piece,
                rim.t,
                off,
                -piece.across(),
                0.0,
                spread,
                rim.weight,
                tail,
                jacobian,
            );
        }
        normal.residual = residual;
    }

    /// The density and its approximation about a state, ready for both its evidence and a step.
    pub(super) fn factored(&self, state: &State, noise: f64) -> Option<Factored> {
        self.linearise(state, noise, true)?.factored()
    }

    pub(super) fn evidence(&self, here: &Factored) -> Evidence {
        let poses: f64 = self.free_precisions().iter().map(|p| p.ln()).sum();
        let log_det = 2.0
            * here
                .factor
                .l_dirty()
                .diagonal()
                .iter()
                .map(|x| x.ln())
                .sum::<f64>();
        let way = if self.sides.is_empty() {
            0.0
        } else {
            self.way.surprise(self.template, self.parameters)
        };
        Evidence {
            surprise: here.residual + here.prior + 0.5 * (log_det - self.template.log_det - poses) + way,
            residual: here.residual,
        }
    }

    pub(super) fn finish(&self, state: State, noise: f64) -> Option<JointFit> {
        let evidence = self.evidence(&self.factored(&state, noise)?);
        self.told(state, &evidence)
    }

    pub(super) fn told(&self, state: State, evidence: &Evidence) -> Option<JointFit> {
        let Laid {
            ring, axes, layers, ..
        } = self.laid(&state)?;
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
            picture: PictureEvidence::default(),
            residual: evidence.residual,
            state,
            shown: self.shown.clone(),
            way: self.way,
        })
    }
}

/// How well a state explains the seen outline.
pub(super) struct Evidence {
    /// Minus log evidence.
    pub(super) surprise: f64,
    pub(super) residual: f64,
}
