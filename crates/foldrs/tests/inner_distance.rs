//! Inner distances against a slow, exact oracle, and what they promise on any input.

mod common;

use common::{cases, polygon, star, subdivided, transformed};
use foldrs::inner_distance::{inner_distances, InnerDistances};
use foldrs::Point;
use proptest::prelude::*;
use robust::{orient2d, Coord};

fn points(xy: &[(f64, f64)]) -> Vec<Point> {
    xy.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

fn turn(a: Point, b: Point, c: Point) -> f64 {
    let coord = |p: Point| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Whether the chord stays in the closed polygon, given counter-clockwise. Chords through a third vertex may be
/// refused: they are the sum of two that are not.
fn is_visible(p: &[Point], i: usize, j: usize) -> bool {
    let n = p.len();
    if (i + 1) % n == j || (j + 1) % n == i {
        return true;
    }
    let crosses = (0..n).any(|k| {
        let (a, b) = (p[k], p[(k + 1) % n]);
        let opposite = |u: f64, v: f64| (u > 0.0 && v < 0.0) || (u < 0.0 && v > 0.0);
        opposite(turn(p[i], p[j], a), turn(p[i], p[j], b)) && opposite(turn(a, b, p[i]), turn(a, b, p[j]))
    });
    let touched = (0..n).any(|k| {
        k != i && k != j && turn(p[i], p[j], p[k]) == 0.0 && (p[i] - p[k]).dot(&(p[j] - p[k])) <= 0.0
    });
    if crosses || touched {
        return false;
    }
    let (before, after) = (p[(i + n - 1) % n], p[(i + 1) % n]);
    let (left_of_out, left_of_in) = (turn(p[i], after, p[j]) >= 0.0, turn(before, p[i], p[j]) >= 0.0);
    if turn(before, p[i], after) >= 0.0 {
        left_of_out && left_of_in
    } else {
        left_of_out || left_of_in
    }
}

/// Floyd-Warshall over all visible chords.
fn oracle(p: &[Point]) -> Vec<f64> {
    let n = p.len();
    let area: f64 = (0..n).map(|k| p[k].coords.perp(&p[(k + 1) % n].coords)).sum();
    let order: Vec<usize> = if area > 0.0 {
        (0..n).collect()
    } else {
        (0..n).rev().collect()
    };
    let ring: Vec<Point> = order.iter().map(|&k| p[k]).collect();
    let mut d = vec![f64::INFINITY; n * n];
    for i in 0..n {
        for j in 0..n {
            if i == j || is_visible(&ring, i, j) {
                d[order[i] * n + order[j]] = (ring[i] - ring[j]).norm();
            }
        }
    }
    for via in 0..n {
        for i in 0..n {
            for j in 0..n {
                d[i * n + j] = d[i * n + j].min(d[i * n + via] + d[via * n + j]);
            }
        }
    }
    d
}

fn assert_close(actual: &[f64], expected: &[f64], tolerance: f64) {
    for (k, (a, e)) in actual.iter().zip(expected).enumerate() {
        assert!((a - e).abs() <= tolerance, "entry {k}: {a}, expected {e}");
    }
}

/// What holds on any outline, simple or not.
fn assert_sound(p: &[Point], inner: &InnerDistances) {
    let n = p.len();
    for i in 0..n {
        for j in 0..n {
            let d = inner.distance[i * n + j];
            let straight = (p[i] - p[j]).norm();
            let step = inner.first_step[i * n + j] as usize;
            assert!(
                d.is_finite() && d >= straight * (1.0 - 1e-12),
                "{i} {j}: {d} < {straight}"
            );
            assert_eq!(d, inner.distance[j * n + i], "{i} {j}: not symmetric");
            assert!(step < n);
            assert_eq!(step == i, i == j, "{i} {j}: no step");
        }
    }
}

/// Following the first steps takes as long as the distance says; on simple outlines.
fn assert_steps_lead_there(p: &[Point], inner: &InnerDistances) {
    let n = p.len();
    for i in 0..n {
        for j in 0..n {
            let d = inner.distance[i * n + j];
            let step = inner.first_step[i * n + j] as usize;
            let along = (p[i] - p[step]).norm() + inner.distance[step * n + j];
            assert!(
                (along - d).abs() <= 1e-9,
                "{i} {j}: the first step leads {along}, not {d}"
            );
        }
    }
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn agrees_with_the_oracle(p in polygon(3..28)) {
        let inner = inner_distances(&p);
        assert_sound(&p, &inner);
        assert_steps_lead_there(&p, &inner);
        assert_close(&inner.distance, &oracle(&p), 1e-12);
    }

    #[test]
    fn agrees_with_the_oracle_on_straight_sides(p in polygon(3..9), pieces in 2_usize..8) {
        // Most points are collinear but for their last bits; chords that miss a vertex by that little count
        // as visible, so that the oracle may be longer only by rounding.
        let p = subdivided(&p, pieces);
        let inner = inner_distances(&p);
        assert_sound(&p, &inner);
        assert_steps_lead_there(&p, &inner);
        assert_close(&inner.distance, &oracle(&p), 1e-9);
    }

    #[test]
    fn triangle_inequality(p in polygon(3..28)) {
        let (n, d) = (p.len(), inner_distances(&p).distance);
        for i in 0..n {
            for j in 0..n {
                for k in 0..n {
                    prop_assert!(d[i * n + j] <= d[i * n + k] + d[k * n + j] + 1e-12);
                }
            }
        }
    }

    #[test]
    fn invariant_to_similarity_and_reflection(
        p in star(3..60), angle in -4.0..4.0_f64, scale in 0.01..500.0_f64, shift in -300.0..300.0_f64,
        flip in any::<bool>(),
    ) {
        let expected: Vec<f64> = inner_distances(&p).distance.iter().map(|d| d * scale).collect();
        let inner = inner_distances(&transformed(&p, angle, scale, shift, flip));
        assert_close(&inner.distance, &expected, 1e-9 * (scale + shift.abs()));
    }

    #[test]
    fn invariant_to_winding_and_start(p in star(3..60), by in 0_usize..60) {
        let n = p.len();
        let index: Vec<usize> = (0..n).map(|k| (2 * n - 1 - k + by) % n).collect();
        let turned: Vec<Point> = index.iter().map(|&k| p[k]).collect();
        let (d, e) = (inner_distances(&p).distance, inner_distances(&turned).distance);
        for i in 0..n {
            for j in 0..n {
                prop_assert!((e[i * n + j] - d[index[i] * n + index[j]]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn straight_in_convex_outlines(angles in prop::collection::btree_set(0_u32..10_000, 3..80)) {
        let p: Vec<Point> = angles
            .iter()
            .map(|&k| f64::from(k) * std::f64::consts::TAU / 1e4)
            .map(|t| Point::new(3.0 * t.cos(), t.sin()))
            .collect();
        let (n, inner) = (p.len(), inner_distances(&p));
        for i in 0..n {
            for j in 0..n {
                prop_assert_eq!(inner.distance[i * n + j], (p[i] - p[j]).norm());
                prop_assert_eq!(inner.first_step[i * n + j] as usize, j);
            }
        }
    }

    /// Points on a coarse grid: duplicates, spikes, touching and crossing sides, collinear runs.
    #[test]
    fn sound_on_any_input(xy in prop::collection::vec((0_i8..5, 0_i8..5), 0..25)) {
        let p: Vec<Point> = xy.iter().map(|&(x, y)| Point::new(x.into(), y.into())).collect();
        assert_sound(&p, &inner_distances(&p));
    }

    #[test]
    fn does_not_panic(xy in prop::collection::vec((any::<f64>(), any::<f64>()), 0..20)) {
        let p = points(&xy);
        prop_assert_eq!(inner_distances(&p).distance.len(), p.len() * p.len());
    }
}

#[test]
fn goes_around_the_notch_of_a_u() {
    let p = points(&[
        (0., 0.),
        (5., 0.),
        (5., 4.),
        (4., 4.),
        (4., 1.),
        (1., 1.),
        (1., 4.),
        (0., 4.),
    ]);
    let inner = inner_distances(&p);
    let n = p.len();
    assert_eq!(inner.distance[3 * n + 6], 9.0);
    assert_eq!(inner.first_step[3 * n + 6], 4);
    assert_eq!(inner.first_step[6 * n + 3], 5);
    assert!((inner.distance[2 * n + 7] - (2.0 * 10_f64.sqrt() + 3.0)).abs() < 1e-12);
    // From the lower left corner the upper right one is seen past the notch's corner only.
    assert!((inner.distance[2] - (17_f64.sqrt() + 10_f64.sqrt())).abs() < 1e-12);
}

#[test]
fn sees_through_a_vertex_it_touches() {
    // The chord from 0 to 3 touches the reflex vertex 5 without leaving the outline.
    let p = points(&[
        (0., 0.),
        (4., -2.),
        (8., -2.),
        (8., 0.),
        (6., 3.),
        (4., 0.),
        (2., 3.),
    ]);
    let inner = inner_distances(&p);
    assert_eq!(inner.distance[3], 8.0);
    assert_eq!(inner.first_step[3], 3);
}

#[test]
fn steps_to_the_far_end_of_a_straight_side() {
    let triangle = points(&[(0.1, 0.3), (0.7, 0.1), (0.4, 0.9)]);
    let p = subdivided(&triangle, 30);
    let n = p.len();
    let inner = inner_distances(&p);
    let direct = (0..n * n)
        .filter(|&k| inner.first_step[k] as usize == k % n)
        .count();
    assert_eq!(direct, n * n);
}

#[test]
fn small_inputs() {
    assert!(inner_distances(&[]).distance.is_empty());
    assert_eq!(inner_distances(&points(&[(1., 2.)])).distance, [0.0]);
    let two = inner_distances(&points(&[(0., 0.), (3., 4.)]));
    assert_eq!(
        (two.distance, two.first_step),
        (vec![0.0, 5.0, 5.0, 0.0], vec![0, 1, 0, 1])
    );
}

#[test]
fn mean_of_a_square() {
    let square = inner_distances(&points(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)]));
    assert!((square.mean() - (4.0 + 2.0 * 2_f64.sqrt()) / 6.0).abs() < 1e-15);
    assert_eq!(inner_distances(&[]).mean(), 0.0);
}
