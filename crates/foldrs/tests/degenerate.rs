//! Outlines as tracing, rounding and odd units leave them: spikes, threads, points on straight sides, doubled points,
//! edges that touch, and coordinates of any size. The garment they enclose is the same, and so must be the answers.

mod common;

use common::{cases, polygon};
use foldrs::alignment::{align, AlignmentParameters};
use foldrs::inner_distance::inner_distances;
use foldrs::outline::signed_area;
use foldrs::shape_context::{chi_squared, shape_contexts, ShapeContextParameters};
use foldrs::{fold, Outline, Point, Vector};
use proptest::prelude::*;

/// A flaw, with where it is: shares of the number of points, of lengths and of directions.
#[derive(Debug, Clone, Copy)]
enum Flaw {
    /// The same point once more.
    Doubled(f64),
    /// A point on the side that starts at another.
    OnSide(f64, f64),
    /// A thread without width, out and back.
    Spike(f64, f64, f64),
    /// A thread to a point of another edge, and back: edges touch.
    Touching(f64, f64, f64),
}

fn flaw() -> impl Strategy<Value = Flaw> {
    let share = || 0.0..1.0_f64;
    prop_oneof![
        share().prop_map(Flaw::Doubled),
        (share(), share()).prop_map(|(i, t)| Flaw::OnSide(i, t)),
        (share(), share(), share()).prop_map(|(i, turn, length)| Flaw::Spike(i, turn, length)),
        (share(), share(), share()).prop_map(|(i, j, t)| Flaw::Touching(i, j, t)),
    ]
}

fn with_flaw(mut p: Vec<Point>, flaw: &Flaw) -> Vec<Point> {
    let n = p.len();
    let index = |share: f64| ((share * n as f64) as usize).min(n - 1);
    match *flaw {
        Flaw::Doubled(i) => p.insert(index(i), p[index(i)]),
        Flaw::OnSide(i, t) => {
            let i = index(i);
            let on = p[i] + (p[(i + 1) % n] - p[i]) * t;
            p.insert(i + 1, on);
        }
        Flaw::Spike(i, turn, length) => {
            let i = index(i);
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            let (foot, tip) = (p[i], p[i] + Vector::new(cos, sin) * length);
            p.splice(i..i, [foot, tip]);
        }
        Flaw::Touching(i, j, t) => {
            let (i, j) = (index(i), index(j));
            let (foot, there) = (p[i], p[j] + (p[(j + 1) % n] - p[j]) * t);
            p.splice(i..i, [foot, there]);
        }
    }
    p
}

/// A polygon, and the same with flaws, that enclose the same.
fn flawed() -> impl Strategy<Value = (Vec<Point>, Vec<Point>)> {
    let enclosing = |p: &Vec<Point>| signed_area(p).abs() > 0.02;
    (
        polygon(3..16).prop_filter("hardly an area", enclosing),
        prop::collection::vec(flaw(), 1..6),
    )
        .prop_map(|(p, flaws)| {
            let worse = flaws.iter().fold(p.clone(), with_flaw);
            (p, worse)
        })
}

fn finite(p: &Point) -> bool {
    p.x.is_finite() && p.y.is_finite()
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn flaws_enclose_nothing((p, worse) in flawed()) {
        let (whole, flawed) = (Outline::new(p).unwrap(), Outline::new(worse).unwrap());
        prop_assert!((whole.signed_area() - flawed.signed_area()).abs() < 1e-12);
        prop_assert!((whole.centroid() - flawed.centroid()).norm() < 1e-9);
        prop_assert!(flawed.length() >= whole.length() - 1e-12);
        prop_assert!(flawed.resample(50).iter().all(finite));
        prop_assert!(flawed.sides(0.02).iter().all(|side| side.segment.iter().all(finite)));
    }

    #[test]
    fn a_flawed_outline_is_simple_or_says_where_it_is_not((_, worse) in flawed()) {
        let outline = Outline::new(worse).unwrap();
        if let Err(error) = outline.check_simple() {
            let foldrs::OutlineError::Crossing(i, j) = error else {
                return Err(TestCaseError::fail(format!("{error}")));
            };
            // The edges named do touch.
            let ([a, b], [c, d]) = (outline.edge(i), outline.edge(j));
            let near = |q: &Point, [s, t]: [Point; 2]| {
                let along = ((q - s).dot(&(t - s)) / (t - s).norm_squared()).clamp(0.0, 1.0);
                (q - (s + (t - s) * along)).norm()
            };
            let touch = [near(&a, [c, d]), near(&b, [c, d]), near(&c, [a, b]), near(&d, [a, b])];
            let turn = |o: Point, u: Point, v: Point| (u - o).perp(&(v - o)) > 0.0;
            let cross = turn(a, b, c) != turn(a, b, d) && turn(c, d, a) != turn(c, d, b);
            prop_assert!(cross || touch.iter().any(|&d| d < 1e-9), "edges {i} and {j} are apart");
        }
    }

    #[test]
    fn inner_distances_of_flawed_outlines_are_sound((_, worse) in flawed()) {
        let (n, inner) = (worse.len(), inner_distances(&worse));
        for i in 0..n {
            for j in 0..n {
                let d = inner.distance[i * n + j];
                prop_assert!(d.is_finite() && d >= (worse[i] - worse[j]).norm() * (1.0 - 1e-12));
                prop_assert_eq!(d, inner.distance[j * n + i]);
                prop_assert_eq!(inner.first_step[i * n + j] as usize == i, i == j);
            }
        }
    }

    #[test]
    fn a_flawed_outline_is_folded_or_refused(
        (_, worse) in flawed(), angle in 0.0..6.3_f64, x in 0.2..0.8_f64, y in 0.2..0.8_f64,
    ) {
        let outline = Outline::new(worse).unwrap();
        let d = Vector::new(angle.cos(), angle.sin()) * 9.0;
        let Ok(folded) = fold(&outline, &[Point::new(x, y) - d, Point::new(x, y) + d]) else { return Ok(()) };
        prop_assert!(folded.resample(60).iter().all(|p| finite(&p.point) && p.arc.is_finite()));
        let cloth: f64 = folded.kept.iter().chain(&folded.flap).map(|piece| signed_area(&piece.points)).sum();
        prop_assert!((cloth.abs() - outline.signed_area().abs()).abs() < 1e-9);
    }

    #[test]
    fn a_flawed_outline_aligns_with_itself((_, worse) in flawed()) {
        let points = Outline::new(worse).unwrap().resample(40);
        let contexts = shape_contexts(&points, &inner_distances(&points), &ShapeContextParameters::default());
        let found = align(&chi_squared(&contexts, &contexts), &AlignmentParameters::default(), None);
        prop_assert!(found.is_some_and(|alignment| alignment.cost < 1e-5 && alignment.pairs.len() == 40));
    }

    #[test]
    fn the_unit_does_not_matter((_, worse) in flawed(), exponent in -45_i32..45, angle in 0.0..6.3_f64) {
        // A power of two changes no digit.
        let unit = 2.0_f64.powi(exponent * 10 / 3);
        let (plain, scaled) = (
            Outline::new(worse.clone()).unwrap(),
            Outline::new(worse.iter().map(|p| p * unit).collect()).unwrap(),
        );
        prop_assert_eq!(scaled.signed_area(), plain.signed_area() * unit * unit);
        prop_assert_eq!(scaled.simplify(0.02 * unit), plain.simplify(0.02));
        prop_assert_eq!(scaled.check_simple(), plain.check_simple());
        let middle = plain.centroid();
        let d = Vector::new(angle.cos(), angle.sin()) * 9.0;
        let axis = [middle - d, middle + d];
        match (fold(&plain, &axis), fold(&scaled, &axis.map(|p| p * unit))) {
            (Ok(one), Ok(other)) => {
                let ratio = other.flap_area() / unit / unit / one.flap_area();
                prop_assert!((ratio - 1.0).abs() < 1e-9);
                prop_assert_eq!(one.creases.len(), other.creases.len());
            }
            (one, other) => prop_assert_eq!(one.err(), other.err()),
        }
    }
}

#[test]
fn what_is_beyond_all_measure_is_named() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
    for unit in [1e51, 1e150, 1e300, 1e-51, 1e-150, 1e-300] {
        let error = Outline::new(square.iter().map(|p| p * unit).collect()).unwrap_err();
        assert!(
            matches!(error, foldrs::OutlineError::OutOfRange(_)),
            "{unit:e}: {error}"
        );
        assert!(error.to_string().contains("scale its coordinates"));
    }
    for unit in [1e50, 1.0, 1e-50] {
        let outline = Outline::new(square.iter().map(|p| p * unit).collect()).unwrap();
        assert!(((outline.centroid() / unit) - Point::new(0.5, 0.5)).norm() < 1e-12);
    }
}
