//! The normal equations of a candidate: how a point of the folded model moves with every variable.

use super::layers::Piece;
use super::way::Deviation;
use crate::crease::Axis;
use crate::stack::{Crease, Source};
use crate::{Point, Vector};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix2};

/// Variables of the pose: growth, turn, offset.
pub(super) const POSE: usize = 4;

/// What a point of the model depends on.
pub(super) struct Jacobian<'a> {
    pub(super) linear: Matrix2<f64>,
    pub(super) offset: Point,
    pub(super) axes: &'a [Axis],
    /// The points the creases turn about.
    pub(super) pivots: &'a [Point],
    pub(super) creases: &'a [Crease],
    pub(super) ring: &'a [Point],
    pub(super) bows: &'a [f64],
}

impl Jacobian<'_> {
    /// Where the model has the point of a piece's source at share `t`.
    pub(super) fn point(&self, piece: &Piece, t: f64) -> Point {
        let along = piece.ends[1] - piece.ends[0];
        let straight = piece.ends[0] + along * t;
        let Source::Edge(i) = piece.source else {
            return straight;
        };
        // What is turned over bulges to the other side.
        let left = if piece.turned.over() { -1.0 } else { 1.0 };
        let across = Vector::new(-along.y, along.x) / piece.length.max(f64::MIN_POSITIVE);
        straight + across * (left * self.bows[i] * bulge(t))
    }

    /// How `w . x` changes with the variables, x being the point of a piece's source at share `t`.
    pub(super) fn row(
        &self,
        piece: &Piece,
        t: f64,
        mut w: Vector,
        variables: usize,
        row: &mut Vec<(usize, f64)>,
    ) {
        let bows = variables - self.bows.len();
        let first = bows - 2 * self.axes.len();
        let n = first - POSE;
        let mut x = piece.ends[0] + (piece.ends[1] - piece.ends[0]) * t;
        // Back through the folds that turned it over, to where it lay before.
        for (k, axis) in self.axes.iter().enumerate().rev() {
            if !piece.turned.by(k) {
                continue;
            }
            x = axis.reflect(&x);
            let normal = axis.normal();
            let from = x - self.pivots[k];
            let turned = normal * axis.direction.dot(&from) + axis.direction * normal.dot(&from);
            row.push((first + 2 * k, 2.0 * w.dot(&normal)));
            row.push((first + 2 * k + 1, 2.0 * w.dot(&turned)));
            // The reflection is its own transpose.
            w = axis.direction * (2.0 * axis.direction.dot(&w)) - w;
        }
        match piece.source {
            Source::Crease(c) => {
                let k = self.creases[c].fold;
                let axis = &self.axes[k];
                let normal = axis.normal();
                let along = axis.direction.dot(&(x - self.pivots[k]));
                row.push((first + 2 * k, w.dot(&normal)));
                row.push((first + 2 * k + 1, w.dot(&normal) * along));
            }
            Source::Edge(i) => {
                let j = (i + 1) % self.ring.len();
                let d = self.linear.transpose() * w;
                let v = x - self.offset;
                row.push((2 * i, d.x * (1.0 - t)));
                row.push((2 * i + 1, d.y * (1.0 - t)));
                row.push((2 * j, d.x * t));
                row.push((2 * j + 1, d.y * t));
                row.push((n, w.dot(&v)));
                row.push((n + 1, w.dot(&Vector::new(-v.y, v.x))));
                row.push((n + 2, w.x));
                row.push((n + 3, w.y));
                let along = self.ring[j] - self.ring[i];
                let across = Vector::new(-along.y, along.x) / piece.length.max(f64::MIN_POSITIVE);
                row.push((bows + i, w.dot(&across) * bulge(t)));
            }
        }
    }
}

/// How far out an edge is at share `t` of its length, of what it is in the middle.
fn bulge(t: f64) -> f64 {
    4.0 * t * (1.0 - t)
}

/// The normal equations, their matrix factored.
pub(super) struct Factored {
    pub(super) factor: Cholesky<f64, Dyn>,
    pub(super) gradient: DVector<f64>,
    pub(super) residual: f64,
    pub(super) prior: f64,
}

/// The normal equations.
pub(super) struct Normal {
    /// Its lower triangle; what is above is not kept.
    pub(super) hessian: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    /// What one residual depends on: indices of variables, and how much.
    row: Vec<(usize, f64)>,
    /// Whether the residual is asked for, which takes a logarithm a summand.
    pub(super) weighed: bool,
    pub(super) residual: f64,
    pub(super) prior: f64,
}

impl Normal {
    /// Nothing yet, for so many variables; none if only the residual is asked for.
    pub(super) fn of(variables: usize) -> Self {
        Self {
            hessian: DMatrix::zeros(variables, variables),
            gradient: DVector::zeros(variables),
            row: Vec::with_capacity(16),
            weighed: true,
            residual: 0.0,
            prior: 0.0,
        }
    }

    /// `None` if the matrix is not positive definite.
    pub(super) fn factored(self) -> Option<Factored> {
        Some(Factored {
            factor: self.hessian.cholesky()?,
            gradient: self.gradient,
            residual: self.residual,
            prior: self.prior,
        })
    }

    /// Adds a residual `r` whose change is `w . dx`, x being the point of the piece's edge at share `t`.
    ///
    /// `opposed` is a squared distance that does not change; together they count by a robust loss with heavy tails.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn add(
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
        if self.weighed {
            self.residual += 0.5 * weight * tail * tail * e.ln_1p();
        }
        let variables = self.gradient.len();
        if variables == 0 {
            return;
        }
        let weight = weight / (1.0 + e) / (noise * noise);
        self.row.clear();
        jacobian.row(piece, t, w, variables, &mut self.row);
        self.add_row(r, weight);
    }

    /// Adds a deviation from what is expected, which counts by its square.
    pub(super) fn hold(&mut self, deviation: &Deviation) {
        let precision = deviation.spread.powi(-2);
        self.prior += 0.5 * precision * deviation.value.powi(2);
        self.row.clear();
        self.row.extend_from_slice(&deviation.row);
        self.add_row(deviation.value, precision);
    }

    /// Adds a residual that changes by [`Normal::row`].
    fn add_row(&mut self, r: f64, weight: f64) {
        let variables = self.gradient.len();
        // Every variable occurs once; in their order the lower triangle is filled column by column.
        self.row.sort_unstable_by_key(|&(a, _)| a);
        for (k, &(a, x)) in self.row.iter().enumerate() {
            self.gradient[a] += weight * r * x;
            let column = &mut self.hessian.as_mut_slice()[a * variables..(a + 1) * variables];
            for &(b, y) in &self.row[k..] {
                column[b] += weight * y * x;
            }
        }
    }
}
