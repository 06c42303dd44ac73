//! Inner-distance shape contexts and their chi-squared distances.
//!
//! Every point of an outline is described by where the others lie: a histogram over the logarithm of the
//! inner distance and the direction of the first leg of the shortest path, measured from the tangent
//! (Ling & Jacobs 2007, sections 4.1 and 4.2). Folded outlines are compared by it in Mariolis & Malassiotis
//! 2015, section 2.1.2.

use std::f64::consts::PI;

use crate::inner_distance::{mean_inner_distance, InnerDistances};
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

/// Resolution of the shape contexts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct ShapeContextParameters {
    /// Points an outline is resampled to (Ling & Jacobs: 100). Two shape contexts are compared at
    /// `n_points^2` pairs of points.
    pub n_points: usize,
    /// Distance bins (Ling & Jacobs: 5); the last one is open.
    pub n_dist: usize,
    /// Angle bins over the full turn (Ling & Jacobs: 12).
    pub n_theta: usize,
}

impl Default for ShapeContextParameters {
    fn default() -> Self {
        Self {
            n_points: 100,
            n_dist: 5,
            n_theta: 12,
        }
    }
}

/// Histograms of all points of an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeContexts {
    n: usize,
    bins: usize,
    /// How many other points fall into a bin; `bins x n`, so that one bin of all points is contiguous.
    counts: Vec<u16>,
    /// The same for the mirrored outline, its points in reversed order.
    mirrored_counts: Vec<u16>,
}

impl ShapeContexts {
    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Number of bins of a histogram, `n_dist * n_theta`.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// The histograms, row-major `n x bins`; a bin is `distance * n_theta + angle`. They are shares of the
    /// `n - 1` other points, and sum to 1 unless some of these are unreachable.
    #[must_use]
    pub fn histograms(&self) -> Vec<f32> {
        let share = self.share();
        (0..self.n * self.bins)
            .map(|k| f32::from(self.counts[k % self.bins * self.n + k / self.bins]) * share)
            .collect()
    }

    /// The shape contexts of the mirrored outline.
    ///
    /// Mirroring turns the winding over, so the points are taken in reversed order: point `i` of the
    /// result is the mirror image of point `n - 1 - i`. All axes of reflection give the same.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self {
            n: self.n,
            bins: self.bins,
            counts: self.mirrored_counts.clone(),
            mirrored_counts: self.counts.clone(),
        }
    }

    /// What one point contributes to a histogram.
    fn share(&self) -> f32 {
        1.0 / self.n.saturating_sub(1).max(1) as f32
    }

    /// Counts of one bin for all points.
    fn bin(&self, bin: usize) -> &[u16] {
        &self.counts[bin * self.n..(bin + 1) * self.n]
    }
}

/// Inner-distance shape contexts of an outline.
///
/// `points` are the vertices of a closed outline at equal distances, `inner` their inner distances. The
/// distance bin is `floor(log_1.5(a d + 1))` with `a = (1.5^(0.75 n_dist) - 1) / mean`, the tangent at a
/// point goes from its predecessor to its successor. Pairs at infinite distance are not counted.
#[must_use]
pub fn shape_contexts(
    points: &[Point],
    inner: &InnerDistances,
    parameters: &ShapeContextParameters,
) -> ShapeContexts {
    let n = points.len().min(inner.n);
    let (n_dist, n_theta) = (parameters.n_dist.max(1), parameters.n_theta.max(1));
    let bins = n_dist * n_theta;
    let mut contexts = ShapeContexts {
        n,
        bins,
        counts: vec![0; n * bins],
        mirrored_counts: vec![0; n * bins],
    };
    let mut rings = Rings::new(n, n_dist, n_theta, mean_inner_distance(inner));
    let mut sectors = Sectors::new(n, n_theta);
    // One ring more than there are bins takes what is out of reach.
    let mut histogram = vec![0_u16; bins + n_theta];
    let mut mirrored = histogram.clone();
    for i in 0..n {
        let tangent = points[(i + 1) % n] - points[(i + n - 1) % n];
        sectors.look(&points[..n], points[i], tangent);
        rings.look(&inner.distance[i * inner.n..][..n]);
        histogram.fill(0);
        mirrored.fill(0);
        for (&step, &ring) in inner.first_step[i * inner.n..][..n].iter().zip(&rings.first_bin) {
            let Some(sector) = sectors.bins.get(step as usize) else {
                continue;
            };
            histogram[ring as usize + sector.seen as usize] += 1;
            mirrored[ring as usize + sector.mirrored as usize] += 1;
        }
        // The point itself was met, too.
        let (ring, own) = (rings.first_bin[i] as usize, sectors.bins[i]);
        histogram[ring + own.seen as usize] = histogram[ring + own.seen as usize].saturating_sub(1);
        mirrored[ring + own.mirrored as usize] = mirrored[ring + own.mirrored as usize].saturating_sub(1);
        for bin in 0..bins {
            contexts.counts[bin * n + i] = histogram[bin];
            contexts.mirrored_counts[bin * n + n - 1 - i] = mirrored[bin];
        }
    }
    contexts
}

/// The distance bins of the points seen from one.
struct Rings {
    /// Distances from which the second, third, ... ring begins; the last one is infinite, then follow some that
    /// nothing reaches.
    borders: Vec<[f64; BLOCK]>,
    n_theta: u64,
    /// Number of the first bin of every point's ring.
    first_bin: Vec<u64>,
}

impl Rings {
    fn new(n: usize, n_dist: usize, n_theta: usize, mean: f64) -> Self {
        let a = (DISTANCE_BASE.powf(MEAN_AT * n_dist as f64) - 1.0) / mean;
        let border = |k: usize| (DISTANCE_BASE.powf(k as f64) - 1.0) / a;
        let borders: Vec<f64> = (1..n_dist).map(border).chain([f64::INFINITY]).collect();
        Self {
            borders: blocks(&borders, f64::NAN),
            n_theta: n_theta as u64,
            first_bin: vec![0; n],
        }
    }

    fn look(&mut self, distance: &[f64]) {
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
struct Sectors {
    /// Cotangents of the borders within half a turn, filled up with borders that nothing passes.
    borders: Vec<[f64; BLOCK]>,
    /// Sectors between borders in half a turn.
    half_turn: u64,
    /// Binary logarithm of the sectors a bin has: an odd number of bins has no border at half a turn, so that
    /// every one is halved.
    per_bin: u32,
    seen: Directions,
    mirrored: Directions,
    bins: Vec<Sector>,
}

/// Angle bin of a direction, and of its mirror image.
#[derive(Clone, Copy, Default)]
struct Sector {
    seen: u32,
    mirrored: u32,
}

impl Sectors {
    fn new(n: usize, n_theta: usize) -> Self {
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
            seen: Directions::new(n),
            mirrored: Directions::new(n),
            bins: vec![Sector::default(); n],
        }
    }

    /// Fills in the bins of the directions from one vertex, counted from the tangent there.
    fn look(&mut self, points: &[Point], from: Point, tangent: Vector) {
        // As atan2(0, 0) would have it.
        let tangent = if tangent == Vector::zeros() {
            Vector::x()
        } else {
            tangent
        };
        let normal = Vector::new(-tangent.y, tangent.x);
        self.seen.fill(points, from, [tangent, normal], self.half_turn);
        // In the mirrored outline the reversed order of the points turns the tangent round, its mirrored frame
        // therefore keeps the normal.
        self.mirrored
            .fill(points, from, [-tangent, normal], self.half_turn);
        for directions in [&mut self.seen, &mut self.mirrored] {
            self.borders.iter().for_each(|borders| directions.pass(borders));
        }
        for ((bins, seen), mirrored) in self
            .bins
            .iter_mut()
            .zip(&self.seen.passed)
            .zip(&self.mirrored.passed)
        {
            *bins = Sector {
                seen: (seen >> self.per_bin) as u32,
                mirrored: (mirrored >> self.per_bin) as u32,
            };
        }
    }
}

/// Directions turned into the upper half turn, and the sectors passed before each.
struct Directions {
    cosine: Vec<f64>,
    sine: Vec<f64>,
    passed: Vec<u64>,
}

impl Directions {
    fn new(n: usize) -> Self {
        Self {
            cosine: vec![0.0; n],
            sine: vec![0.0; n],
            passed: vec![0; n],
        }
    }

    /// Directions from a vertex to all others in the frame of its tangent and normal.
    fn fill(&mut self, points: &[Point], from: Point, [tangent, normal]: [Vector; 2], half_turn: u64) {
        let cells = self.cosine.iter_mut().zip(&mut self.sine).zip(&mut self.passed);
        for (point, ((cosine, sine), passed)) in points.iter().zip(cells) {
            let leg = point - from;
            let (along, aside) = (tangent.dot(&leg), normal.dot(&leg));
            // The sum with zero drops the sign of a zero.
            let (c, s) = (along - BORDER * aside, aside + BORDER * along + 0.0);
            let sign = s.to_bits() & (1 << 63);
            *cosine = f64::from_bits(c.to_bits() ^ sign);
            *sine = s.abs();
            *passed = half_turn & (sign >> 63).wrapping_neg();
        }
    }

    /// Counts the borders before each direction.
    fn pass(&mut self, borders: &[f64; BLOCK]) {
        for ((c, s), passed) in self.cosine.iter().zip(&self.sine).zip(&mut self.passed) {
            *passed += borders
                .iter()
                .map(|border| u64::from(*c < border * s))
                .sum::<u64>();
        }
    }
}

/// A matrix of matching costs, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct CostMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The costs, `rows x columns`.
    pub values: Vec<f32>,
}

impl CostMatrix {
    /// One row.
    #[must_use]
    pub fn row(&self, i: usize) -> &[f32] {
        &self.values[i * self.columns..(i + 1) * self.columns]
    }
}

/// Chi-squared distances `sum (a - b)^2 / (a + b)` of all histograms of one outline to all of another, from
/// 0 to 2 (Ling & Jacobs 2007, section 4.2, without the factor 1/2).
///
/// Both must have the same bins; surplus ones of either are left out.
#[must_use]
pub fn chi_squared(a: &ShapeContexts, b: &ShapeContexts) -> CostMatrix {
    // (a - b)^2 / (a + b) = a + b - 4 a b / (a + b): only bins that are filled in both histograms take work.
    // Counts are small, so many points of `a` share one, and with it the last term for all points of `b`.
    let (n, m) = (a.n, b.n);
    let bins = a.bins.min(b.bins);
    let mut common = vec![0.0_f32; n * m];
    let (mut mass_a, mut mass_b) = (vec![0.0_f32; n], vec![0.0_f32; m]);
    let (mut share_b, mut term) = (vec![0.0_f32; m], vec![0.0_f32; m]);
    let mut with_count: Vec<Vec<u32>> = vec![Vec::new(); n.max(1)];
    for bin in 0..bins {
        for ((share, mass), &count) in share_b.iter_mut().zip(&mut mass_b).zip(b.bin(bin)) {
            *share = f32::from(count) * b.share();
            *mass += *share;
        }
        for (i, &count) in a.bin(bin).iter().enumerate() {
            if count > 0 {
                with_count[usize::from(count).min(n - 1)].push(i as u32);
            }
        }
        for (count, rows) in with_count.iter_mut().enumerate() {
            if rows.is_empty() {
                continue;
            }
            let share_a = count as f32 * a.share();
            for (term, share) in term.iter_mut().zip(&share_b) {
                *term = share_a * share / (share_a + share);
            }
            for i in rows.drain(..) {
                let i = i as usize;
                mass_a[i] += share_a;
                for (sum, term) in common[i * m..(i + 1) * m].iter_mut().zip(&term) {
                    *sum += term;
                }
            }
        }
    }
    for (row, mass) in common.chunks_exact_mut(m.max(1)).zip(&mass_a) {
        for (value, mass_b) in row.iter_mut().zip(&mass_b) {
            *value = (mass + mass_b - 4.0 * *value).max(0.0);
        }
    }
    CostMatrix {
        rows: n,
        columns: m,
        values: common,
    }
}
