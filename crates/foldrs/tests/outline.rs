//! Stage 0: what outlines promise about arc length, simplification, inside and outside, and winding.

mod common;

use std::f64::consts::TAU;

use common::{cases, outline, polygon, star};
use foldrs::{Outline, OutlineError, Point};
use proptest::prelude::*;

/// The point reached by walking `s` along the edges.
fn walk(p: &[Point], mut s: f64) -> Point {
    for i in 0..p.len() {
        let (a, b) = (p[i], p[(i + 1) % p.len()]);
        let length = (b - a).norm();
        if s <= length {
            return a + (b - a) * (s / length);
        }
        s -= length;
    }
    p[0]
}

fn distance_to_segment(a: Point, b: Point, q: Point) -> f64 {
    let d = b - a;
    let t = (d.dot(&(q - a)) / d.norm_squared()).clamp(0.0, 1.0);
    (q - (a + d * t)).norm()
}

/// How often the outline winds around a point, by the angles its edges are seen under.
fn turns_around(o: &Outline, q: Point) -> i64 {
    let angle = |i: usize| {
        let [a, b] = o.edge(i).map(|p| p - q);
        a.perp(&b).atan2(a.dot(&b))
    };
    ((0..o.points().len()).map(angle).sum::<f64>() / TAU).round() as i64
}

fn proper_crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let side = |o: Point, u: Point, v: Point| (u - o).perp(&(v - o)) > 0.0;
    side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn resampled_points_are_equal_steps_apart(o in outline(3..28), n in 1_usize..200) {
        let step = o.length() / n as f64;
        let points = o.resample(n);
        prop_assert_eq!(points.len(), n);
        prop_assert_eq!(points[0], o.points()[0]);
        for (k, p) in points.iter().enumerate() {
            prop_assert!((p - walk(o.points(), k as f64 * step)).norm() < 1e-9);
            prop_assert!((p - o.at(k as f64 * step - o.length())).norm() < 1e-9);
        }
    }

    #[test]
    fn simplified_outlines_stay_within_the_tolerance(o in outline(3..60), tolerance in 0.0..0.3_f64) {
        let (p, corners) = (o.points(), o.simplify(tolerance));
        prop_assert!(corners.len() >= 2 && corners.windows(2).all(|c| c[0] < c[1]));
        for (k, &from) in corners.iter().enumerate() {
            let to = corners.get(k + 1).map_or(corners[0] + p.len(), |&c| c);
            for between in from + 1..to {
                let (a, b) = (p[from], p[to % p.len()]);
                let away = distance_to_segment(a, b, p[between % p.len()]);
                prop_assert!(away <= tolerance + 1e-12, "vertex {between} lies {away} off");
            }
        }
    }

    #[test]
    fn a_tolerance_of_nothing_keeps_every_vertex(o in outline(3..40)) {
        prop_assert_eq!(o.simplify(0.0).len(), o.points().len());
    }

    #[test]
    fn what_an_outline_winds_around_is_inside(o in outline(3..28), x in -0.2..1.2_f64, y in -0.2..1.2_f64) {
        let q = Point::new(x, y);
        prop_assume!(o.nearest(&q).distance > 1e-9);
        let turns = turns_around(&o, q);
        prop_assert_eq!(turns, if o.contains(&q) { o.signed_area().signum() as i64 } else { 0 });
    }

    #[test]
    fn nothing_on_the_outline_is_nearer_than_the_nearest(o in outline(3..28), x in -1.0..2.0_f64, y in -1.0..2.0_f64) {
        let q = Point::new(x, y);
        let nearest = o.nearest(&q);
        prop_assert!(((q - nearest.point).norm() - nearest.distance).abs() < 1e-12);
        prop_assert!((o.at(nearest.arc) - nearest.point).norm() < 1e-9);
        prop_assert!(o.resample(500).iter().all(|p| (q - p).norm() >= nearest.distance - 1e-12));
    }

    #[test]
    fn positive_outlines_keep_their_first_vertex_and_area(o in outline(3..28)) {
        let positive = o.clone().positive();
        prop_assert!((positive.signed_area() - o.signed_area().abs()).abs() < 1e-12);
        prop_assert_eq!(positive.points()[0], o.points()[0]);
        prop_assert!((positive.length() - o.length()).abs() < 1e-12);
        prop_assert_eq!(o.reversed().reversed(), o);
    }

    #[test]
    fn the_mirror_image_keeps_its_winding_and_mirrors_back(o in outline(3..28)) {
        let (mirrored, n) = (o.mirrored(), o.points().len());
        prop_assert!((mirrored.signed_area() - o.signed_area()).abs() < 1e-12);
        for (i, p) in mirrored.points().iter().enumerate() {
            let original = o.points()[(n - i) % n];
            prop_assert_eq!(*p, Point::new(-original.x, original.y));
        }
        prop_assert_eq!(mirrored.mirrored(), o);
    }

    #[test]
    fn outlines_without_crossings_are_simple(p in star(4..40)) {
        prop_assert_eq!(Outline::new(p).unwrap().check_simple(), Ok(()));
    }

    #[test]
    fn crossings_are_found(xy in prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64), 4..12)) {
        let p: Vec<Point> = xy.into_iter().map(|(x, y)| Point::new(x, y)).collect();
        let Ok(o) = Outline::new(p) else { return Ok(()) };
        let n = o.points().len();
        let crossing = (0..n)
            .flat_map(|i| (i + 2..n).map(move |j| (i, j)))
            .filter(|&(i, j)| i != (j + 1) % n)
            .find(|&(i, j)| proper_crossing(o.edge(i), o.edge(j)));
        prop_assert_eq!(o.check_simple().err(), crossing.map(|(i, j)| OutlineError::Crossing(i, j)));
    }

    #[test]
    fn the_centroid_moves_with_the_outline(p in polygon(3..28), x in -50.0..50.0_f64, y in -50.0..50.0_f64) {
        let shift = foldrs::Vector::new(x, y);
        let moved = Outline::new(p.iter().map(|p| p + shift).collect());
        let (Ok(o), Ok(moved)) = (Outline::new(p), moved) else { return Ok(()) };
        prop_assume!(o.signed_area().abs() > 1e-3);
        prop_assert!((moved.centroid() - (o.centroid() + shift)).norm() < 1e-8);
        prop_assert!((o.reversed().centroid() - o.centroid()).norm() < 1e-9);
    }
}
