//! Partial matching of two closed outlines by chord angles (section 2.1.1; Riemenschneider, Donoser & Bischof 2010).
//!
//! The descriptor of a pair of points lies within the piece of outline between them, so the closed outlines are
//! matched once and every side then uses the matches (or their longest part) that avoid it: removing the side first
//! would find the same pieces.

mod chord_angles;
mod distinct;
mod sweep;

pub use chord_angles::ChordAngles;

use crate::parameters::PartialMatchParameters;
use sweep::{best_pieces, Best, Lengths};

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
///
/// # Panics
/// If an outline has fewer points than the piece.
#[must_use]
pub fn piece_difference(
    seen: &ChordAngles,
    start: usize,
    template: &ChordAngles,
    template_start: usize,
    length: usize,
) -> f64 {
    assert!(
        length <= seen.len().min(template.len()),
        "a piece of {length} points is longer than an outline"
    );
    let mut sum = 0.0;
    for a in 0..length {
        for k in seen.delta + 1..length - a {
            let (i, j) = ((start + a) % seen.len(), (template_start + a) % template.len());
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
    let (m, n) = (seen.len(), template.len());
    let Some(lengths) = Lengths::new(m.min(n), seen.delta, parameters) else {
        return Vec::new();
    };
    let best = best_pieces(seen, template, &lengths);
    let found = ranked(&best).into_iter().map(|cell| {
        let piece = &best[cell];
        PartialMatch {
            start: cell / n,
            template_start: cell % n,
            length: piece.length as usize,
            difference: lengths.difference(piece, parameters),
            affinity: f64::from(piece.log_affinity).exp(),
        }
    });
    distinct::distinct(found, m, n, parameters.most)
}

/// The pieces that reach the threshold: the greatest affinity first, then the first starting points.
fn ranked(best: &[Best]) -> Vec<usize> {
    let mut order: Vec<u64> = best
        .iter()
        .enumerate()
        .filter(|(_, piece)| piece.length > 0)
        // Below zero numbers grow against their bits. One number to compare is sorted several times as fast as two.
        .map(|(cell, piece)| u64::from(piece.log_affinity.to_bits()) << 32 | cell as u64)
        .collect();
    order.sort_unstable();
    order
        .into_iter()
        .map(|key| (key & u64::from(u32::MAX)) as usize)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;

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
}
