//! Which distance bin and which angle bin the points of an outline fall into, seen from one of them.
//!
//! Borders are compared with, instead of taking logarithms and arc tangents.

use std::f64::consts::PI;

use crate::{Point, Vector};

/// Each distance bin is this much wider than the one before.
const DISTANCE_BASE: f64 = 1.5;

/// The mean inner distance lies at this share of the distance bins (Ling & Jacobs' published code).
const MEAN_AT: f64 = 0.75;

/// A direction this close (radians) below the border of two angle bins belongs to the upper one.
///
/// The next point of a straight side lies exactly in the direction of the tangent, on the border of the
/// first and the last bin; without this, rounding errors would toss a coin for each of them.
const BORDER: f64 = 1e-9;

/// The distance bins of the points seen from one.
pub(super) struct Rings {
    /// Distances from which the second, third, ... ring begins; the last one is infinite, then follow some that
    /// nothing reaches.
    borders: Vec<[f64; BLOCK]>,
    n_theta: u64,
    /// Number of the first bin of every point's ring.
    pub first_bin: Vec<u64>,
}

impl Rings {
    pub fn new(n: usize, n_dist: usize, n_theta: usize, mean: f64) -> Self {
        let a = (DISTANCE_BASE.powf(MEAN_AT * n_dist as f64) - 1.0) / mean;
        let border = |k: usize| (DISTANCE_BASE.powf(k as f64) - 1.0) / a;
        let borders: Vec<f64> = (1..n_dist).map(border).chain([f64::INFINITY]).collect();
        Self {
            borders: blocks(&borders, f64::NAN),
            n_theta: n_theta as u64,
            first_bin: vec![0; n],
        }
    }

    #[inline(always)]
    pub fn look(&mut self, distance: &[f64]) {
        self.first_bin.fill(0);
        for borders in &self.borders {
            for (bin, d) in self.first_bin.iter_mut().zip(distance) {
                *bin += borders
                    .iter()
                    .map(|border| if d >= border { self.n_theta } else { 0 })
                    .sum::<u64>();
            }
        }
    }
}

/// Borders compared in one go; as many as five rings or twelve sectors have.
const BLOCK: usize = 5;

/// Cuts borders into blocks, the last one filled up.
fn blocks(borders: &[f64], filler: f64) -> Vec<[f64; BLOCK]> {
    let block = |some: &[f64]| std::array::from_fn(|k| some.get(k).copied().unwrap_or(filler));
    borders.chunks(BLOCK).map(block).collect()
}

/// The angle bins of the points seen from one.
pub(super) struct Sectors {
    /// Cotangents of the borders within half a turn, filled up with borders that nothing passes.
    borders: Vec<[f64; BLOCK]>,
    /// Sectors between borders in half a turn.
    half_turn: u64,
    /// Binary logarithm of the sectors a bin has: an odd number of bins has no border at half a turn, so that
    /// every one is halved.
    per_bin: u32,
    /// Directions turned into the upper half turn.
    cosine: Vec<f64>,
    sine: Vec<f64>,
    /// Angle bin of every direction: the borders before it.
    pub passed: Vec<u64>,
}

impl Sectors {
    pub fn new(n: usize, n_theta: usize) -> Self {
        let per_bin = n_theta % 2;
        let half_turn = (n_theta << per_bin) / 2;
        let cotangents: Vec<f64> = (1..half_turn)
            .map(|k| {
                let (sine, cosine) = (k as f64 * PI / half_turn as f64).sin_cos();
                cosine / sine
            })
            .collect();
        Self {
            borders: blocks(&cotangents, f64::NEG_INFINITY),
            half_turn: half_turn as u64,
            per_bin: per_bin as u32,
            cosine: vec![0.0; n],
            sine: vec![0.0; n],
            passed: vec![0; n],
        }
    }

    /// Fills in the bins of the directions from one vertex, counted from the tangent there.
    #[inline(always)]
    pub fn look(&mut self, points: &[Point], from: Point, tangent: Vector, mirrored: bool) {
        // As atan2(0, 0) would have it.
        let tangent = if tangent == Vector::zeros() {
            Vector::x()
        } else {
            tangent
        };
        let normal = Vector::new(-tangent.y, tangent.x);
        // In the mirrored outline the reversed order of the points turns the tangent round, its mirrored frame
        // therefore keeps the normal.
        let tangent = if mirrored { -tangent } else { tangent };
        self.fill(points, from, [tangent, normal]);
        for borders in &self.borders {
            for ((c, s), passed) in self.cosine.iter().zip(&self.sine).zip(&mut self.passed) {
                *passed += borders
                    .iter()
                    .map(|border| u64::from(*c < border * s))
                    .sum::<u64>();
            }
        }
        self.passed.iter_mut().for_each(|passed| *passed >>= self.per_bin);
    }

    /// Directions from a vertex to all others in the frame of its tangent and normal, and the half turns before them.
    #[inline(always)]
    fn fill(&mut self, points: &[Point], from: Point, [tangent, normal]: [Vector; 2]) {
        let cells = self.cosine.iter_mut().zip(&mut self.sine).zip(&mut self.passed);
        for (point, ((cosine, sine), passed)) in points.iter().zip(cells) {
            let leg = point - from;
            let (along, aside) = (tangent.dot(&leg), normal.dot(&leg));
            // The sum with zero drops the sign of a zero.
            let (c, s) = (along - BORDER * aside, aside + BORDER * along + 0.0);
            let sign = s.to_bits() & (1 << 63);
            *cosine = f64::from_bits(c.to_bits() ^ sign);
            *sine = s.abs();
            *passed = self.half_turn & (sign >> 63).wrapping_neg();
        }
    }
}
