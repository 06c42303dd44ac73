//! The integer grid on which places are told apart.

use crate::{Point, Segment, Vector};
use i_overlay::i_float::int::point::IntPoint;

/// An integer grid of some 2^30 steps over the pieces.
pub(super) struct Grid {
    centre: Point,
    scale: f64,
}

impl Grid {
    /// Steps from the centre to the farthest side.
    pub(super) const HALF: i32 = 1 << 29;

    pub(super) fn around<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let (mut low, mut high) = (Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN));
        for p in points {
            low = Point::new(low.x.min(p.x), low.y.min(p.y));
            high = Point::new(high.x.max(p.x), high.y.max(p.y));
        }
        let half = ((high.x - low.x).max(high.y - low.y) / 2.0).max(f64::MIN_POSITIVE);
        Self {
            centre: nalgebra::center(&low, &high),
            scale: f64::from(Self::HALF) / half,
        }
    }

    /// Length of a step, in the unit of the points.
    pub(super) fn step(&self) -> f64 {
        1.0 / self.scale
    }

    pub(super) fn snap(&self, p: &Point) -> IntPoint<i32> {
        let v = (p - self.centre) * self.scale;
        // As `f64::round`, which is a call into the mathematics library on processors of the oldest kind.
        let rounded = |x: f64| (x + 0.5_f64.copysign(x)) as i32;
        IntPoint::new(rounded(v.x), rounded(v.y))
    }

    pub(super) fn back(&self, p: &IntPoint<i32>) -> Point {
        self.centre + Vector::new(f64::from(p.x), f64::from(p.y)) / self.scale
    }

    /// Where the lines of two edges cross, which are not parallel; to the last bit as the overlay library rounds it.
    pub(super) fn crossing(&self, edges: [&Segment; 2]) -> Point {
        // From left to right or upwards, the edge farther left first.
        let mut edges = edges.map(|edge| {
            let mut ends = edge.map(|p| self.snap(&p)).map(|p| (p.x, p.y));
            ends.sort_unstable();
            ends
        });
        edges.sort_unstable();
        let [[o, a], [b, c]] = edges;
        let from_o = |p: (i32, i32)| {
            [
                i128::from(p.0) - i128::from(o.0),
                i128::from(p.1) - i128::from(o.1),
            ]
        };
        let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(from_o);
        let (share, whole) = (bx * cy - by * cx, ay * (bx - cx) - ax * (by - cy));
        let along = |length: i128| {
            let up = length * share * whole.signum();
            // Towards zero along an upright or level edge, else to the nearest step.
            let half = if ax == 0 || ay == 0 { 0 } else { whole.abs() / 2 };
            ((up + half * up.signum()) / whole.abs().max(1)) as f64
        };
        let v = Vector::new(f64::from(o.0) + along(ax), f64::from(o.1) + along(ay));
        self.centre + v / self.scale
    }
}
