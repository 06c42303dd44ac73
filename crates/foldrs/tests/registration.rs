//! Least-squares maps: exact where a map exists, best where none does.

mod common;

use common::cases;
use foldrs::registration::{roundness, PlaneMap};
use foldrs::{Point, Vector};
use nalgebra::Matrix2;
use proptest::prelude::*;

fn cloud() -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 4..30)
        .prop_map(|xy| xy.into_iter().map(|(x, y)| Point::new(x, y)).collect::<Vec<_>>())
        .prop_filter("nearly a line", |p| roundness(p) > 0.05)
}

fn offset() -> impl Strategy<Value = Vector> {
    (-40.0..40.0_f64, -40.0..40.0_f64).prop_map(|(x, y)| Vector::new(x, y))
}

fn similarity() -> impl Strategy<Value = PlaneMap> {
    (-4.0..4.0_f64, 0.1..8.0_f64, offset()).prop_map(|(angle, scale, offset)| {
        let (s, c) = angle.sin_cos();
        let linear = Matrix2::new(c, -s, s, c) * scale;
        PlaneMap { linear, offset }
    })
}

fn affine() -> impl Strategy<Value = PlaneMap> {
    (prop::array::uniform4(-3.0..3.0_f64), offset())
        .prop_map(|(m, offset)| PlaneMap {
            linear: Matrix2::new(m[0], m[1], m[2], m[3]),
            offset,
        })
        .prop_filter("nearly singular", |map| map.linear.determinant().abs() > 0.1)
}

fn mapped(map: &PlaneMap, points: &[Point]) -> Vec<Point> {
    points.iter().map(|p| map.apply(p)).collect()
}

fn apart(a: &PlaneMap, b: &PlaneMap) -> f64 {
    (a.linear - b.linear).norm() + (a.offset - b.offset).norm()
}

fn residual(map: &PlaneMap, from: &[Point], to: &[Point]) -> f64 {
    from.iter()
        .zip(to)
        .map(|(p, q)| (map.apply(p) - q).norm_squared())
        .sum()
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn similarities_are_recovered(map in similarity(), from in cloud()) {
        let found = PlaneMap::similarity(&from, &mapped(&map, &from), None).unwrap();
        prop_assert!(apart(&found, &map) < 1e-9);
    }

    #[test]
    fn affine_maps_are_recovered(map in affine(), from in cloud()) {
        let found = PlaneMap::affine(&from, &mapped(&map, &from), None).unwrap();
        prop_assert!(apart(&found, &map) < 1e-8);
    }

    #[test]
    fn points_without_weight_do_not_count(map in similarity(), from in cloud(), stray in cloud()) {
        let mut to = mapped(&map, &from);
        let mut weights = vec![1.0; from.len()];
        let all: Vec<Point> = from.iter().chain(&stray).copied().collect();
        to.extend(stray.iter().rev());
        weights.resize(all.len(), 0.0);
        prop_assert!(apart(&PlaneMap::similarity(&all, &to, Some(&weights)).unwrap(), &map) < 1e-9);
        prop_assert!(apart(&PlaneMap::affine(&all, &to, Some(&weights)).unwrap(), &map) < 1e-8);
    }

    #[test]
    fn no_other_similarity_fits_better(from in cloud(), to in cloud(), by in similarity(), step in 1e-4..1e-1_f64) {
        let n = from.len().min(to.len());
        let (from, to) = (&from[..n], &to[..n]);
        let best = PlaneMap::similarity(from, to, None).unwrap();
        let other = PlaneMap {
            linear: best.linear + by.linear * step,
            offset: best.offset + by.offset * step,
        };
        prop_assert!(residual(&best, from, to) <= residual(&other, from, to));
    }

    #[test]
    fn no_similarity_fits_better_than_the_affine_map(from in cloud(), to in cloud()) {
        let n = from.len().min(to.len());
        let (from, to) = (&from[..n], &to[..n]);
        prop_assume!(roundness(from) > 0.05);
        let (affine, similarity) = (PlaneMap::affine(from, to, None), PlaneMap::similarity(from, to, None));
        prop_assert!(residual(&affine.unwrap(), from, to) <= residual(&similarity.unwrap(), from, to) + 1e-9);
    }

    #[test]
    fn maps_lead_back(map in affine(), p in offset()) {
        let p = Point::from(p);
        prop_assert!((map.inverse().unwrap().apply(&map.apply(&p)) - p).norm() < 1e-9);
    }

    #[test]
    fn stretches_are_the_singular_values(map in affine()) {
        let [most, least] = map.stretch();
        let values = map.linear.svd(false, false).singular_values;
        prop_assert!((most - values.max()).abs() < 1e-9 && (least - values.min()).abs() < 1e-9);
    }

    #[test]
    fn roundness_is_a_share_that_no_similarity_changes(map in similarity(), points in cloud()) {
        let round = roundness(&points);
        prop_assert!((0.0..=1.0).contains(&round));
        prop_assert!((roundness(&mapped(&map, &points)) - round).abs() < 1e-9);
    }
}

#[test]
fn what_determines_no_map_gives_none() {
    let same = [Point::new(1.0, 2.0); 3];
    let line: Vec<Point> = (0..5).map(|k| Point::new(f64::from(k), 2.0)).collect();
    assert_eq!(PlaneMap::similarity(&[], &[], None), None);
    assert_eq!(PlaneMap::similarity(&same, &same, None), None);
    assert_eq!(PlaneMap::similarity(&line, &line, Some(&[0.0; 5])), None);
    assert_eq!(PlaneMap::affine(&line, &line, None), None);
    let oblique: Vec<Point> = (0..5)
        .map(|k| Point::new(0.1 * f64::from(k), 0.3 * f64::from(k) + 7.0))
        .collect();
    assert_eq!(PlaneMap::affine(&oblique, &oblique, None), None);
    // Of points without a weight nothing is known.
    assert_eq!(PlaneMap::similarity(&line, &line, Some(&[1.0])), None);
    assert_eq!(
        PlaneMap::similarity(&line, &line, None),
        Some(PlaneMap::identity())
    );
    assert_eq!(roundness(&line), 0.0);
}
