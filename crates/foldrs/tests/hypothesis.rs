//! Stage 2: scores of axes, and their aggregation over direction and distance.

mod common;

use std::f64::consts::PI;

use common::{cases, outline, star};
use foldrs::hypothesis::{aggregate, inside_score, Face, Hypothesis};
use foldrs::parameters::HypothesisParameters;
use foldrs::registration::PlaneMap;
use foldrs::{Outline, Point, Segment, Vector};
use proptest::prelude::*;

fn segment() -> impl Strategy<Value = Segment> {
    let point = || (-1.0..2.0_f64, -1.0..2.0_f64).prop_map(|(x, y)| Point::new(x, y));
    [point(), point()].prop_filter("no length", |[a, b]| (b - a).norm() > 0.05)
}

fn claim(axis: Segment, confidence: f64, side: usize, face: Face) -> Hypothesis {
    Hypothesis {
        axis,
        confidence,
        side,
        face,
        map: PlaneMap::identity(),
    }
}

fn claims() -> impl Strategy<Value = Vec<Hypothesis>> {
    let one =
        (segment(), 0.01..1.0_f64, 0..2_usize, any::<bool>()).prop_map(|(axis, confidence, side, seen)| {
            claim(
                axis,
                confidence,
                side,
                if seen { Face::Seen } else { Face::Mirrored },
            )
        });
    prop::collection::vec(one, 1..60)
}

fn square() -> Outline {
    let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
    Outline::new(corners.map(|(x, y)| Point::new(x, y)).to_vec()).unwrap()
}

/// An axis of a direction, `distance` beside the square's centre.
fn beside_centre(angle: f64, distance: f64) -> Segment {
    let d = Vector::new(angle.cos(), angle.sin());
    let foot = Point::new(5.0, 5.0) + Vector::new(-d.y, d.x) * distance;
    [foot - d * 3.0, foot + d * 3.0]
}

fn merged(axes: &[Segment]) -> usize {
    let found: Vec<_> = axes.iter().map(|a| claim(*a, 1.0, 0, Face::Seen)).collect();
    aggregate(&found, &square(), &HypothesisParameters::default()).len()
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn scores_are_shares_of_either_direction(o in outline(3..28), [a, b] in segment()) {
        let score = inside_score(&[a, b], &o);
        prop_assert!((0.0..=1.0).contains(&score));
        prop_assert!((inside_score(&[b, a], &o) - score).abs() < 1e-9);
    }

    #[test]
    fn scores_follow_the_lengths_inside_and_outside(o in outline(3..28), axis in segment()) {
        const STEPS: usize = 4000;
        let at = |k: usize| axis[0] + (axis[1] - axis[0]) * ((k as f64 + 0.5) / STEPS as f64);
        let inside = (0..STEPS).filter(|&k| o.contains(&at(k))).count() as f64;
        // The steps tell the share inside to some thousandths, too coarse for very little of it.
        prop_assume!(inside == 0.0 || inside > 0.1 * STEPS as f64);
        let expected = if inside > 0.0 { (-(STEPS as f64 - inside) / inside).exp() } else { 0.0 };
        prop_assert!((inside_score(&axis, &o) - expected).abs() < 0.05);
    }

    #[test]
    fn axes_wholly_inside_score_one(p in star(5..30), i in 0_usize..30, share in 0.1..0.9_f64) {
        // From the kernel of a star every point is reached inside.
        let tip = p[i % p.len()] * share;
        let widest = p.windows(2).all(|p| p[0].coords.perp(&p[1].coords) > 0.0);
        prop_assume!(widest && p[p.len() - 1].coords.perp(&p[0].coords) > 0.0);
        prop_assert!((inside_score(&[Point::origin(), tip], &Outline::new(p).unwrap()) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn confidence_is_summed_and_sorted(found in claims(), o in outline(3..28)) {
        let all = aggregate(&found, &o, &HypothesisParameters::default());
        let sum = |h: &[Hypothesis]| h.iter().map(|h| h.confidence).sum::<f64>();
        prop_assert!((sum(&all) - sum(&found)).abs() < 1e-9);
        prop_assert!(all.windows(2).all(|h| h[0].confidence >= h[1].confidence));
    }

    #[test]
    fn the_direction_of_an_axis_does_not_matter(found in claims(), o in outline(3..28), turn in any::<u64>()) {
        let mut turned = found.clone();
        for (k, h) in turned.iter_mut().enumerate() {
            if turn >> (k % 64) & 1 == 1 {
                h.axis.reverse();
            }
        }
        let parameters = HypothesisParameters::default();
        let (one, other) = (aggregate(&found, &o, &parameters), aggregate(&turned, &o, &parameters));
        prop_assert_eq!(one.len(), other.len());
        for (h, g) in one.iter().zip(&other) {
            prop_assert_eq!((h.confidence, h.side, h.face), (g.confidence, g.side, g.face));
            let [a, b] = g.axis;
            prop_assert!(h.axis == [a, b] || h.axis == [b, a], "{:?} became {:?}", h.axis, g.axis);
        }
    }

    #[test]
    fn directions_have_no_seam(
        lines in prop::collection::vec((0.0..PI, -4.0..4.0_f64), 1..40), bins_on in 0_u32..72,
    ) {
        // Turned by whole bins, the same lines meet.
        let bin = PI / HypothesisParameters::default().angle_bins as f64;
        let axes = |by: f64| lines.iter().map(|l| beside_centre(l.0 + by, l.1)).collect::<Vec<_>>();
        prop_assert_eq!(merged(&axes(f64::from(bins_on) * bin)), merged(&axes(0.0)));
    }

    #[test]
    fn lines_half_a_turn_apart_are_one(distance in -4.0..4.0_f64, tilt in 1e-6..0.05_f64, level in any::<bool>()) {
        let to = if level { -tilt } else { PI - tilt };
        let distance_there = if level { distance } else { -distance };
        prop_assert_eq!(merged(&[beside_centre(tilt, distance), beside_centre(to, distance_there)]), 1);
    }
}

#[test]
fn lines_apart_stay_apart() {
    assert_eq!(merged(&[beside_centre(0.5, 1.0), beside_centre(0.5, 2.0)]), 2);
    assert_eq!(
        merged(&[beside_centre(0.1, 2.0), beside_centre(PI - 0.1, 2.0)]),
        2
    );
    assert_eq!(merged(&[beside_centre(0.5, 1.0), beside_centre(1.5, 1.0)]), 2);
    // A level line, drawn from either end, meets its neighbours on both sides of the seam.
    let level = |turned: bool| beside_centre(if turned { PI } else { 0.0 }, if turned { -1.0 } else { 1.0 });
    for turned in [false, true] {
        assert_eq!(merged(&[level(turned), beside_centre(0.12, 1.0)]), 1);
    }
}

#[test]
fn sides_and_faces_are_kept_apart() {
    let axis = beside_centre(0.5, 1.0);
    let found = [
        (0, Face::Seen),
        (1, Face::Seen),
        (0, Face::Mirrored),
        (0, Face::Seen),
    ];
    let found = found.map(|(side, face)| claim(axis, 0.25, side, face));
    let all = aggregate(&found, &square(), &HypothesisParameters::default());
    assert_eq!(
        all.iter().map(|h| h.confidence).collect::<Vec<_>>(),
        [0.5, 0.25, 0.25]
    );
}
