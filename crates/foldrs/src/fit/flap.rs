//! How much of a garment its folds turn over.

use crate::crease::Axis;
use crate::stack::fold_ring;
use crate::{Point, Segment};

/// Share of the cloth that every fold turns over; `None` if one turns nothing.
///
/// `creases` have the flap on their left, the first made first, and lie in the frame of the part no fold turns.
pub(super) fn shares(ring: &[Point], creases: &[Segment], covered: f64) -> Option<Vec<f64>> {
    let axes: Vec<Axis> = creases.iter().map(Axis::new).collect::<Result<_, _>>().ok()?;
    let (cloths, _) = fold_ring(ring, &axes, covered, &[]).ok()?;
    let area = |ring: &[Point]| crate::outline::signed_area(ring).abs();
    let areas: Vec<f64> = cloths.iter().map(|cloth| area(&cloth.ring())).collect();
    let all: f64 = areas.iter().sum();
    let share = |fold: usize| {
        let turned = cloths.iter().zip(&areas);
        let turned: f64 = turned.filter(|(c, _)| c.turned.by(fold)).map(|(_, a)| a).sum();
        turned / all
    };
    Some((0..axes.len()).map(share).collect())
}

/// Minus log density of such shares, up to a constant, if it grows with a power of the smaller side's share.
pub(super) fn surprise(shares: &[f64], power: f64) -> f64 {
    let least = 1e-3; // a hem turned by a thread
    smaller(shares).map(|s| -power * (2.0 * s.max(least)).ln()).sum()
}

/// Of every fold the share of the smaller part: which of the two was turned over cannot be seen.
pub(super) fn smaller(shares: &[f64]) -> impl Iterator<Item = f64> + '_ {
    shares.iter().map(|s| s.min(1.0 - s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_what_is_turned_over() {
        let towel = [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)].map(|(x, y)| Point::new(x, y));
        let at = |x: f64| [Point::new(x, 40.0), Point::new(x, 0.0)];
        for (x, share) in [(45.0, 0.25), (15.0, 0.75), (30.0, 0.5)] {
            let found = shares(&towel, &[at(x)], 0.5).unwrap();
            assert!((found[0] - share).abs() < 1e-9);
        }
        assert!(shares(&towel, &[at(70.0)], 0.5).is_none());
        assert_eq!(shares(&towel, &[], 0.5), Some(vec![]));
    }

    #[test]
    fn small_flaps_surprise_more() {
        assert_eq!(surprise(&[0.5, 0.5], 2.0), 0.0);
        assert!(surprise(&[0.05], 2.0) > surprise(&[0.1], 2.0) + 1.0);
        assert_eq!(surprise(&[0.05], 0.0), 0.0);
        assert!((surprise(&[0.2], 2.0) - surprise(&[0.8], 2.0)).abs() < 1e-12);
    }
}
