//! Partial matching of two closed outlines by chord angles (section 2.1.1; Riemenschneider, Donoser & Bischof 2010).
//!
//! The descriptor of a pair of points lies within the piece of outline between them, so the closed outlines are
//! matched once and every side then uses the matches (or their longest part) that avoid it: removing the side first
//! would find the same pieces.

use crate::parameters::PartialMatchParameters;
use crate::Point;
use std::f32::consts::TAU;

/// Chord angles of a closed outline of equally spaced points.
///
/// For points `i` and `j = i + k` (k > delta) of a piece there are two: at `j`, from the chord to `i` to the chord back
/// to `j - delta`; and at `i`, from the chord to `j` to the chord on to `i + delta`. Turning or moving the outline
/// does not change them; mirroring it negates them.
#[derive(Debug, Clone)]
pub struct ChordAngles {
    n: usize,
    delta: usize,
    /// Row `i`, column `k`: the angle at `i + k`; 0 for k <= delta.
    at_end: Vec<f32>,
    /// Row `i`, column `k`: the angle at `i`; 0 for k <= delta.
    at_start: Vec<f32>,
}

impl ChordAngles {
    /// The chord angles of all pairs of points.
    #[must_use]
    pub fn new(points: &[Point], delta: usize) -> Self {
        let n = points.len();
        let mut at_end = vec![0.0; n * n];
        let mut at_start = vec![0.0; n * n];
        let angle = |corner: usize, to: usize, near: usize| {
            let (u, v) = (
                points[to % n] - points[corner % n],
                points[near % n] - points[corner % n],
            );
            u.perp(&v).atan2(u.dot(&v)) as f32
        };
        for i in 0..n {
            for k in delta + 1..n {
                at_end[i * n + k] = angle(i + k, i, i + k - delta);
                at_start[i * n + k] = angle(i, i + k, i + delta);
            }
        }
        Self {
            n,
            delta,
            at_end,
            at_start,
        }
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
    fn difference(&self, i: usize, other: &Self, j: usize, k: usize) -> f32 {
        let (a, b) = (i * self.n + k, j * other.n + k);
        square_wrapped(self.at_end[a] - other.at_end[b])
            + square_wrapped(self.at_start[a] - other.at_start[b])
    }
}

/// A piece of one outline that looks like a piece of another.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PartialMatch {
    /// First point of the piece on the seen outline.
    pub start: usize,
    /// First point of the piece on the template.
    pub template_start: usize,
    /// Points of the piece.
    pub length: usize,
    /// Mean squared difference of the chord angles, in square radians.
    pub difference: f64,
    /// Affinity As in [0, 1): grows with length and likeness.
    pub affinity: f64,
}

/// Squared difference of two angles in (-pi, pi], the short way round.
#[inline]
fn square_wrapped(d: f32) -> f32 {
    let d = d.abs();
    let d = d.min(TAU - d);
    d * d
}

/// Chord-angle pairs within a piece of `length` points, two angles each.
fn angles_within(length: usize, delta: usize) -> usize {
    let m = length.saturating_sub(delta + 1);
    m * (m + 1)
}

/// Affinity of two pieces: longer and more alike is better, 1 is never reached.
#[must_use]
pub fn affinity(length: usize, difference: f64, parameters: &PartialMatchParameters) -> f64 {
    let likeness = (-difference / (parameters.likeness * parameters.likeness)).exp();
    let weight = 1.0 - (-(length as f64) / parameters.length).exp();
    likeness * weight
}

/// Mean squared difference of two pieces by the direct double sum over all pairs of their points.
///
/// What [`partial_matches`] finds for all pieces at once; here for one, and for oracles.
#[must_use]
pub fn piece_difference(
    seen: &ChordAngles,
    start: usize,
    template: &ChordAngles,
    template_start: usize,
    length: usize,
) -> f64 {
    let mut sum = 0.0;
    for a in 0..length {
        for k in seen.delta + 1..length - a {
            let (i, j) = ((start + a) % seen.n, (template_start + a) % template.n);
            sum += f64::from(seen.difference(i, template, j, k));
        }
    }
    sum / angles_within(length, seen.delta).max(1) as f64
}

/// All good matches between pieces of two outlines sampled at the same spacing, the best first.
///
/// For every pair of starting points the length of greatest affinity is taken; of matches that overlap along the same
/// or a neighbouring offset only the best is kept. The structural zeros of the descriptor are left out of the mean.
/// Time grows with the product of both numbers of points and the longest piece, memory with their product.
#[must_use]
pub fn partial_matches(
    seen: &ChordAngles,
    template: &ChordAngles,
    parameters: &PartialMatchParameters,
) -> Vec<PartialMatch> {
    let (m, n) = (seen.n, template.n);
    let longest = ((m.min(n) as f64 * parameters.longest) as usize).min(m.min(n));
    let shortest = parameters.shortest.max(seen.delta + 2);
    if longest < shortest {
        return Vec::new();
    }
    let weights = LengthWeights::new(longest, shortest, seen.delta, parameters);
    let mut best = vec![PartialMatch::NONE; m * n];
    let mut sums = vec![0.0f32; longest + 1]; // sums[l]: summed difference of the piece of l points from here on
    let mut row = vec![0.0f32; longest];
    for offset in 0..n {
        sums.fill(0.0);
        // Pieces run over the start, so the sums are first built up over the points behind it.
        for i in (0..m + longest).rev() {
            let known = if i >= m { longest - (i - m) } else { longest };
            difference_row(seen, i % m, template, (i + offset) % n, &mut row[..known]);
            let mut pairs = 0.0;
            // sums[l] becomes sums[l - 1] of the next point plus this point's pairs; backwards, in place.
            for r in row[..known].iter_mut() {
                pairs += *r;
                *r = pairs;
            }
            for l in (1..=known).rev() {
                sums[l] = sums[l - 1] + row[l - 1];
            }
            if i < m {
                best[i * n + offset] = weights.best(&sums, i, (i + offset) % n);
            }
        }
    }
    select(best, m, n, parameters)
}

/// Differences of the pairs (`i`, `i + k`) and (`j`, `j + k`) for every k below the row's length.
fn difference_row(seen: &ChordAngles, i: usize, template: &ChordAngles, j: usize, row: &mut [f32]) {
    let k = row.len();
    let (a, b) = (
        &seen.at_end[i * seen.n..][..k],
        &template.at_end[j * template.n..][..k],
    );
    let (c, d) = (
        &seen.at_start[i * seen.n..][..k],
        &template.at_start[j * template.n..][..k],
    );
    for ((((r, a), b), c), d) in row.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *r = square_wrapped(a - b) + square_wrapped(c - d);
    }
}

/// The affinity's factors that depend on the length alone.
struct LengthWeights {
    shortest: usize,
    /// 1 / (angles within, times likeness squared), a length.
    likeness: Vec<f32>,
    /// Logarithm of the length's own factor.
    weight: Vec<f32>,
    floor: f32,
    likeness_squared: f64,
}

impl LengthWeights {
    fn new(longest: usize, shortest: usize, delta: usize, parameters: &PartialMatchParameters) -> Self {
        let likeness_squared = parameters.likeness * parameters.likeness;
        Self {
            shortest,
            likeness: (0..=longest)
                .map(|l| (1.0 / (angles_within(l, delta).max(1) as f64 * likeness_squared)) as f32)
                .collect(),
            weight: (0..=longest)
                .map(|l| (1.0 - (-(l as f64) / parameters.length).exp()).ln() as f32)
                .collect(),
            floor: parameters.affinity.ln() as f32,
            likeness_squared,
        }
    }

    /// The length of greatest affinity, if it reaches the threshold.
    fn best(&self, sums: &[f32], start: usize, template_start: usize) -> PartialMatch {
        let (mut length, mut log) = (0, self.floor);
        let lengths = sums.iter().zip(&self.weight).zip(&self.likeness).enumerate();
        for (l, ((sum, weight), likeness)) in lengths.skip(self.shortest) {
            let a = weight - sum * likeness;
            if a > log {
                (length, log) = (l, a);
            }
        }
        if length == 0 {
            return PartialMatch::NONE;
        }
        let difference = f64::from(sums[length] * self.likeness[length]) * self.likeness_squared;
        PartialMatch {
            start,
            template_start,
            length,
            difference,
            affinity: f64::from(log).exp(),
        }
    }
}

impl PartialMatch {
    const NONE: Self = Self {
        start: 0,
        template_start: 0,
        length: 0,
        difference: 0.0,
        affinity: 0.0,
    };
}

/// Keeps the best of matches that overlap along the same or a neighbouring offset.
fn select(
    best: Vec<PartialMatch>,
    m: usize,
    n: usize,
    parameters: &PartialMatchParameters,
) -> Vec<PartialMatch> {
    let mut found: Vec<PartialMatch> = best.into_iter().filter(|p| p.length > 0).collect();
    found.sort_by(|a, b| {
        b.affinity
            .total_cmp(&a.affinity)
            .then((a.start, a.template_start).cmp(&(b.start, b.template_start)))
    });
    let mut kept: Vec<PartialMatch> = Vec::new();
    for p in found {
        if kept.len() == parameters.most {
            break;
        }
        if !kept.iter().any(|q| overlap(&p, q, m, n)) {
            kept.push(p);
        }
    }
    kept
}

/// Whether two matches say nearly the same: offsets apart by at most 2 points, more than half of the shorter shared.
fn overlap(p: &PartialMatch, q: &PartialMatch, m: usize, n: usize) -> bool {
    let ahead = signed_steps(p.start, q.start, m);
    let template_ahead = signed_steps(p.template_start, q.template_start, n);
    if (ahead - template_ahead).abs() > 2 {
        return false;
    }
    let end = (p.length as isize).min(ahead + q.length as isize);
    2 * (end - ahead.max(0)) > p.length.min(q.length) as isize
}

/// Steps from one place of a ring of `n` to another, the shorter way.
fn signed_steps(from: usize, to: usize, n: usize) -> isize {
    let ahead = (to + n - from) % n;
    if 2 * ahead > n {
        ahead as isize - n as isize
    } else {
        ahead as isize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn wobbly(n: usize, seed: f64) -> Vec<Point> {
        (0..n)
            .map(|i| {
                let t = i as f64 / n as f64 * std::f64::consts::TAU;
                let r = 1.0 + 0.3 * (3.0 * t + seed).sin() + 0.2 * (5.0 * t + 2.0 * seed).cos();
                Point::new(r * t.cos(), r * t.sin())
            })
            .collect()
    }

    #[test]
    fn every_score_is_the_direct_double_sum() {
        let p = PartialMatchParameters {
            affinity: 1e-6,
            most: usize::MAX,
            likeness: 2.0,
            ..Default::default()
        };
        let (a, b) = (
            ChordAngles::new(&wobbly(40, 0.3), 5),
            ChordAngles::new(&wobbly(46, 1.1), 5),
        );
        let found = partial_matches(&a, &b, &p);
        assert!(found.len() > 10);
        for x in &found {
            let direct = piece_difference(&a, x.start, &b, x.template_start, x.length);
            assert!(
                (x.difference - direct).abs() < 1e-4 * (1.0 + direct),
                "{x:?} {direct}"
            );
            assert!((x.affinity - affinity(x.length, direct, &p)).abs() < 1e-4);
        }
    }

    #[test]
    fn an_outline_matches_itself_without_difference() {
        let points = wobbly(60, 0.7);
        let a = ChordAngles::new(&points, 5);
        let best = partial_matches(&a, &a, &PartialMatchParameters::default())[0];
        assert_eq!(best.start, best.template_start);
        assert!(best.difference < 1e-9);
    }

    #[test]
    fn angle_differences_go_the_short_way_round() {
        assert!((square_wrapped(PI + 0.5 + PI) - 0.25).abs() < 1e-5);
    }
}
