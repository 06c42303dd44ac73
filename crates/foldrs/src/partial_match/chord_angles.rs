//! The descriptor: angles between the chords of an outline.

use std::f32::consts::TAU;

use crate::Point;

/// Chord angles of a closed outline of equally spaced points.
///
/// For points `i` and `j = i + k` (k > delta) of a piece there are two: at `j`, from the chord to `i` to the chord back
/// to `j - delta`; and at `i`, from the chord to `j` to the chord on to `i + delta`. Turning or moving the outline
/// does not change them; mirroring it negates them.
#[derive(Debug, Clone)]
pub struct ChordAngles {
    pub(super) n: usize,
    pub(super) delta: usize,
    /// Row `i`, column `k`: the angles at `i + k` and at `i`; 0 for k <= delta.
    angles: Vec<[f32; 2]>,
}

impl ChordAngles {
    /// The chord angles of all pairs of points.
    #[must_use]
    pub fn new(points: &[Point], delta: usize) -> Self {
        let n = points.len();
        let directions = Directions::new(points);
        let mut angles = vec![[0.0; 2]; n * n];
        // A division would take longer than all the rest.
        let around = |i: usize| if i < n { i } else { i - n };
        for (i, row) in angles.chunks_exact_mut(n.max(1)).enumerate() {
            for (k, angles) in row.iter_mut().enumerate().skip(delta + 1) {
                let j = around(i + k);
                *angles = [
                    directions.angle(j, i, around(i + k - delta)),
                    directions.angle(i, j, around(i + delta)),
                ];
            }
        }
        Self { n, delta, angles }
    }

    /// The two angles of the points `i` and `i + k`, for every k.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[[f32; 2]] {
        &self.angles[i * self.n..(i + 1) * self.n]
    }

    /// Number of points of the outline.
    #[must_use]
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Squared difference of the angles of the pair (`i`, `i + k`) here and (`j`, `j + k`) there.
    pub(super) fn difference(&self, i: usize, other: &Self, j: usize, k: usize) -> f32 {
        let ([a, b], [c, d]) = (self.row(i)[k], other.row(j)[k]);
        square_wrapped(a - c) + square_wrapped(b - d)
    }
}

/// Directions of all chords, each of which is a side of many angles: an arc tangent a chord, not one an angle.
struct Directions {
    n: usize,
    /// Row `i`, column `j`: the direction from `i` to `j` in (-pi, pi]; not a number where the two are one point.
    radians: Vec<f64>,
}

impl Directions {
    fn new(points: &[Point]) -> Self {
        use std::f64::consts::PI;
        let n = points.len();
        let mut radians = vec![f64::NAN; n * n];
        for i in 0..n {
            for j in i + 1..n {
                let chord = points[j] - points[i];
                if chord.x != 0.0 || chord.y != 0.0 {
                    let there = chord.y.atan2(chord.x);
                    radians[i * n + j] = there;
                    radians[j * n + i] = if there > 0.0 { there - PI } else { there + PI };
                }
            }
        }
        Self { n, radians }
    }

    /// Angle at a corner from the chord to one point to the chord to another, in [-pi, pi]; 0 if there is no chord.
    fn angle(&self, corner: usize, from: usize, to: usize) -> f32 {
        use std::f64::consts::{PI, TAU};
        let row = &self.radians[corner * self.n..][..self.n];
        let turn = row[to] - row[from];
        let rounds = if turn > PI {
            -TAU
        } else if turn < -PI {
            TAU
        } else {
            0.0
        };
        if turn.is_nan() {
            0.0
        } else {
            (turn + rounds) as f32
        }
    }
}

/// Squared difference of two angles in [-pi, pi], the short way round.
#[inline(always)]
pub(super) fn square_wrapped(d: f32) -> f32 {
    let d = d.abs();
    let around = TAU - d;
    // Unlike `f32::min` a single instruction; no angle is NaN.
    let d = if d < around { d } else { around };
    d * d
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn angle_differences_go_the_short_way_round() {
        let d = 2.0 * std::f32::consts::PI + 0.5;
        assert!((square_wrapped(d) - 0.25).abs() < 1e-5);
    }

    #[test]
    fn angles_follow_their_definition() {
        let star: Vec<Point> = (0..24)
            .map(|i| {
                let t = f64::from(i) / 12.0 * PI;
                let r = 1.0 + 0.5 * (3.0 * t + 0.3).sin() + 0.2 * (7.0 * t).cos();
                Point::new(r * t.cos(), r * t.sin())
            })
            .collect();
        let (n, delta) = (star.len(), 5);
        let angles = ChordAngles::new(&star, delta);
        let direct = |corner: usize, from: usize, to: usize| {
            let u = star[from % n] - star[corner % n];
            let v = star[to % n] - star[corner % n];
            u.perp(&v).atan2(u.dot(&v)) as f32
        };
        for i in 0..n {
            for k in delta + 1..n {
                let at_end = direct(i + k, i, i + k - delta);
                let at_start = direct(i, i + k, i + delta);
                assert!(square_wrapped(angles.row(i)[k][0] - at_end) < 1e-12);
                assert!(square_wrapped(angles.row(i)[k][1] - at_start) < 1e-12);
            }
        }
    }

    #[test]
    fn points_on_one_spot_have_no_angle() {
        let angles = ChordAngles::new(&[Point::new(1.0, 2.0); 9], 2);
        assert!(angles.angles.iter().all(|&a| a == [0.0; 2]));
    }
}
