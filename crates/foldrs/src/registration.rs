//! Least-squares maps between corresponding points: the affine map and the non-reflective similarity (eq. 2).

use crate::{Point, Vector};
use nalgebra::{Matrix2, Vector2};

/// A linear map with an offset: `x -> linear x + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlaneMap {
    /// The linear part.
    pub linear: Matrix2<f64>,
    /// The offset.
    pub offset: Vector,
}

impl PlaneMap {
    /// The map that leaves every point where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            linear: Matrix2::identity(),
            offset: Vector::zeros(),
        }
    }

    /// The image of a point.
    #[must_use]
    pub fn apply(&self, p: &Point) -> Point {
        Point::from(self.linear * p.coords + self.offset)
    }

    /// The map back, if there is one.
    #[must_use]
    pub fn inverse(&self) -> Option<Self> {
        let linear = self.linear.try_inverse()?;
        Some(Self {
            linear,
            offset: -(linear * self.offset),
        })
    }

    /// Largest and smallest factor by which lengths change.
    #[must_use]
    pub fn stretch(&self) -> [f64; 2] {
        let m = &self.linear;
        let (e, f) = ((m.m11 + m.m22) / 2.0, (m.m11 - m.m22) / 2.0);
        let (g, h) = ((m.m21 + m.m12) / 2.0, (m.m21 - m.m12) / 2.0);
        let (q, r) = (e.hypot(h), f.hypot(g));
        [q + r, (q - r).abs()]
    }

    /// The least-squares non-reflective similarity (eq. 2): rotation, scale and offset.
    ///
    /// `None` if fewer than two points are apart, or their weights vanish. Every weight must be non-negative.
    #[must_use]
    pub fn similarity(from: &[Point], to: &[Point], weights: Option<&[f64]>) -> Option<Self> {
        let moments = Moments::new(from, to, weights)?;
        let spread = moments.spread.trace();
        if spread.is_nan() || spread <= 0.0 {
            return None;
        }
        let c = &moments.cross; // sum of w * to * from^T
        let (a, b) = ((c.m11 + c.m22) / spread, (c.m21 - c.m12) / spread);
        Some(moments.with_linear(Matrix2::new(a, -b, b, a)))
    }

    /// The least-squares affine map; `None` if the points lie on a line.
    #[must_use]
    pub fn affine(from: &[Point], to: &[Point], weights: Option<&[f64]>) -> Option<Self> {
        let moments = Moments::new(from, to, weights)?;
        // Rounding leaves points on a line a spread across it.
        let (across, all) = (moments.spread.determinant(), moments.spread.trace());
        if across.is_nan() || across <= ON_A_LINE * all * all {
            return None;
        }
        let inverse = moments.spread.try_inverse()?;
        Some(moments.with_linear(moments.cross * inverse))
    }
}

/// Determinant of the spread of points, as a share of its trace squared, up to which they count as on a line: a spread
/// across the line of a ten-millionth of that along it.
const ON_A_LINE: f64 = 1e-14;

/// How far points spread across their main direction, as a share of the spread along it: 0 for points on a line.
#[must_use]
pub fn roundness(points: &[Point]) -> f64 {
    let Some(moments) = Moments::new(points, points, None) else {
        return 0.0;
    };
    let m = &moments.spread;
    let (half, root) = (m.trace() / 2.0, ((m.m11 - m.m22) / 2.0).hypot(m.m12));
    if half > 0.0 {
        ((half - root).max(0.0) / (half + root)).sqrt()
    } else {
        0.0
    }
}

/// Weighted means and second moments of corresponding points.
struct Moments {
    from: Vector2<f64>,
    to: Vector2<f64>,
    /// Sum of w * from * from^T about the mean.
    spread: Matrix2<f64>,
    /// Sum of w * to * from^T about the means.
    cross: Matrix2<f64>,
}

impl Moments {
    fn new(from: &[Point], to: &[Point], weights: Option<&[f64]>) -> Option<Self> {
        let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
        let count = from
            .len()
            .min(to.len())
            .min(weights.map_or(usize::MAX, <[f64]>::len));
        let total: f64 = (0..count).map(weight).sum();
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let mean = |points: &[Point]| {
            (0..count)
                .map(|i| points[i].coords * weight(i))
                .sum::<Vector2<f64>>()
                / total
        };
        let (f, t) = (mean(from), mean(to));
        let (mut spread, mut cross) = (Matrix2::zeros(), Matrix2::zeros());
        for i in 0..count {
            let (u, v) = (from[i].coords - f, to[i].coords - t);
            spread += u * u.transpose() * weight(i);
            cross += v * u.transpose() * weight(i);
        }
        Some(Self {
            from: f,
            to: t,
            spread,
            cross,
        })
    }

    fn with_linear(&self, linear: Matrix2<f64>) -> PlaneMap {
        PlaneMap {
            linear,
            offset: self.to - linear * self.from,
        }
    }
}
