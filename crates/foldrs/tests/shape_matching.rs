//! Shape contexts, their distances and the alignment against plain versions of their definitions.

mod common;

use std::f64::consts::TAU;

use common::{cases, polygon, star, subdivided, transformed};
use foldrs::alignment::{align, alignment_costs, AlignmentParameters};
use foldrs::inner_distance::inner_distances;
use foldrs::shape_context::{
    chi_squared, mirrored_shape_contexts, shape_contexts, CostMatrix, ShapeContextParameters, ShapeContexts,
};
use foldrs::Point;
use proptest::prelude::*;

fn resolution(n_dist: usize, n_theta: usize) -> ShapeContextParameters {
    let mut parameters = ShapeContextParameters::default();
    (parameters.n_dist, parameters.n_theta) = (n_dist, n_theta);
    parameters
}

fn alignment(skip_penalty: f64, starts: usize) -> AlignmentParameters {
    let mut parameters = AlignmentParameters::default();
    (parameters.skip_penalty, parameters.starts) = (skip_penalty, starts);
    parameters
}

fn contexts(p: &[Point]) -> ShapeContexts {
    shape_contexts(p, &inner_distances(p), &ShapeContextParameters::default())
}

/// Histograms straight from the definition, with logarithm and arc tangent.
fn plain_histograms(p: &[Point], parameters: &ShapeContextParameters) -> Vec<f32> {
    let (n, n_dist, n_theta) = (p.len(), parameters.n_dist, parameters.n_theta);
    let inner = inner_distances(p);
    let a = (1.5_f64.powf(0.75 * n_dist as f64) - 1.0) / inner.mean();
    let mut histograms = vec![0.0; n * n_dist * n_theta];
    for i in 0..n {
        let tangent = p[(i + 1) % n] - p[(i + n - 1) % n];
        for j in (0..n).filter(|&j| j != i) {
            let ring = (((a * inner.distance[i * n + j] + 1.0).ln() / 1.5_f64.ln()) as usize).min(n_dist - 1);
            let leg = p[inner.first_step[i * n + j] as usize] - p[i];
            let angle = (leg.y.atan2(leg.x) - tangent.y.atan2(tangent.x) + 1e-9).rem_euclid(TAU);
            let sector = (angle / TAU * n_theta as f64) as usize % n_theta;
            histograms[(i * n_dist + ring) * n_theta + sector] += 1.0 / (n - 1) as f32;
        }
    }
    histograms
}

fn assert_close(actual: &[f32], expected: &[f32], tolerance: f32) {
    assert_eq!(actual.len(), expected.len());
    for (k, (a, e)) in actual.iter().zip(expected).enumerate() {
        assert!((a - e).abs() <= tolerance, "entry {k}: {a}, expected {e}");
    }
}

/// Cheapest alignment from one start, cell by cell.
fn plain_alignment(cost: &CostMatrix, penalty: f64, start: usize) -> f64 {
    let (n, m) = (cost.rows, cost.columns);
    let mut table = vec![vec![0.0; m + 1]; n + 1];
    for i in 0..=n {
        for j in 0..=m {
            let mut least = if i + j == 0 { 0.0 } else { f64::INFINITY };
            if i > 0 {
                least = f64::min(least, table[i - 1][j] + penalty);
            }
            if j > 0 {
                least = f64::min(least, table[i][j - 1] + penalty);
            }
            if i > 0 && j > 0 {
                let pair = f64::from(cost.row(i - 1)[(start + j - 1) % m]);
                least = f64::min(least, table[i - 1][j - 1] + pair);
            }
            table[i][j] = least;
        }
    }
    table[n][m] / n as f64
}

fn costs(rows: std::ops::Range<usize>, columns: std::ops::Range<usize>) -> impl Strategy<Value = CostMatrix> {
    (rows, columns).prop_flat_map(|(rows, columns)| {
        prop::collection::vec(0.0_f32..2.0, rows * columns).prop_map(move |values| CostMatrix {
            rows,
            columns,
            values,
        })
    })
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn histograms_follow_the_definition(p in polygon(3..40), n_dist in 1_usize..8, n_theta in 1_usize..20) {
        let parameters = resolution(n_dist, n_theta);
        let contexts = shape_contexts(&p, &inner_distances(&p), &parameters);
        assert_close(&contexts.histograms(), &plain_histograms(&p, &parameters), 1e-6);
    }

    #[test]
    fn straight_sides_do_not_depend_on_rounding(
        p in polygon(3..8), pieces in 2_usize..8, angle in -4.0..4.0_f64, scale in 0.01..500.0_f64,
    ) {
        let p = subdivided(&p, pieces);
        let turned = transformed(&p, angle, scale, 0.0, false);
        assert_close(&contexts(&turned).histograms(), &contexts(&p).histograms(), 1e-6);
    }

    #[test]
    fn mirrored_as_if_computed_from_mirrored_points(p in star(3..60), n_theta in 1_usize..16, angle in 0.0..6.0_f64) {
        let parameters = resolution(5, n_theta);
        let mut mirrored = transformed(&p, angle, 2.0, 0.0, true);
        mirrored.reverse();
        let expected = shape_contexts(&mirrored, &inner_distances(&mirrored), &parameters);
        let contexts = mirrored_shape_contexts(&p, &inner_distances(&p), &parameters);
        assert_close(&contexts.histograms(), &expected.histograms(), 1e-6);
    }

    #[test]
    fn chi_squared_follows_the_definition(p in polygon(3..40), q in polygon(3..40)) {
        let (a, b) = (contexts(&p), contexts(&q));
        let cost = chi_squared(&a, &b);
        let (ha, hb) = (a.histograms(), b.histograms());
        for (i, x) in ha.chunks(a.bins()).enumerate() {
            for (j, y) in hb.chunks(b.bins()).enumerate() {
                let terms = x.iter().zip(y).filter(|(x, y)| **x + **y > 0.0);
                let expected: f32 = terms.map(|(x, y)| (x - y) * (x - y) / (x + y)).sum();
                prop_assert!((cost.row(i)[j] - expected).abs() < 1e-5, "{i} {j}");
            }
        }
    }

    #[test]
    fn costs_of_all_starts_follow_the_definition(cost in costs(1..20, 1..20), penalty in 0.05..1.0_f64) {
        let parameters = alignment(penalty, 8);
        let starts: Vec<usize> = (0..cost.columns).rev().collect();
        for (&start, actual) in starts.iter().zip(alignment_costs(&cost, &parameters, &starts)) {
            prop_assert!((actual - plain_alignment(&cost, penalty, start)).abs() < 1e-5);
        }
    }

    #[test]
    fn finds_the_best_of_all_starts(cost in costs(1..25, 1..25), penalty in 0.05..1.0_f64, starts in 1_usize..12) {
        let parameters = alignment(penalty, starts);
        let best = (0..cost.columns)
            .map(|start| plain_alignment(&cost, penalty, start))
            .fold(f64::INFINITY, f64::min);
        let found = align(&cost, &parameters, None).unwrap();
        prop_assert!((found.cost - best).abs() < 1e-5, "{} instead of {best}", found.cost);
        prop_assert_eq!(align(&cost, &parameters, Some(found.cost * 1.001)), Some(found.clone()));
        prop_assert_eq!(align(&cost, &parameters, Some(found.cost * 0.999)), None);

        let paired: f64 = found.pairs.iter().map(|&(i, j)| f64::from(cost.row(i as usize)[j as usize])).sum();
        let skipped = cost.rows + cost.columns - 2 * found.pairs.len();
        let total = paired + penalty * skipped as f64;
        prop_assert!((total / cost.rows as f64 - found.cost).abs() < 1e-6);

        let ahead = |j: u32| (j as usize + cost.columns - found.start) % cost.columns;
        for pair in found.pairs.windows(2) {
            prop_assert!(pair[0].0 < pair[1].0 && ahead(pair[0].1) < ahead(pair[1].1));
        }
    }

    #[test]
    fn finds_a_turned_outline_again(p in star(20..60), by in 0_usize..60, flip in any::<bool>()) {
        let n = p.len();
        let turned: Vec<Point> = (0..n).map(|k| p[(k + by) % n]).collect();
        let mut seen = transformed(&turned, 1.0, 3.0, 7.0, flip);
        if flip {
            seen.reverse();
        }
        let describe = if flip { mirrored_shape_contexts } else { shape_contexts };
        let query = describe(&p, &inner_distances(&p), &ShapeContextParameters::default());
        let found = align(&chi_squared(&query, &contexts(&seen)), &AlignmentParameters::default(), None).unwrap();
        prop_assert!(found.cost < 0.01, "cost {}", found.cost);
        prop_assert!(found.pairs.len() >= n - 1);
    }
}

#[test]
fn histogram_of_a_square() {
    let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| Point::new(x, y));
    let histograms = contexts(&square).histograms();
    // At a corner the tangent is parallel to a diagonal: the sides lie at 45 and 135, the other diagonal at 90
    // degrees. The sides are 0.88 of the mean long, the diagonal 1.24.
    let a = 1.5_f64.powf(3.75) - 1.0;
    let mean = (2.0 + 2_f64.sqrt()) / 3.0;
    let ring = |d: f64| ((a * d / mean + 1.0).ln() / 1.5_f64.ln()) as usize;
    for corner in histograms.chunks(60) {
        let mut expected = vec![0.0; 60];
        expected[ring(1.0) * 12 + 1] = 1.0 / 3.0;
        expected[ring(1.0) * 12 + 4] = 1.0 / 3.0;
        expected[ring(2_f64.sqrt()) * 12 + 3] = 1.0 / 3.0;
        assert_close(corner, &expected, 1e-6);
    }
}

#[test]
fn unreachable_points_are_not_counted() {
    let p = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| Point::new(x, y));
    let mut inner = inner_distances(&p);
    inner.distance[2] = f64::INFINITY;
    inner.distance[8] = f64::INFINITY;
    let contexts = shape_contexts(&p, &inner, &ShapeContextParameters::default());
    let sums: Vec<f32> = contexts.histograms().chunks(60).map(|h| h.iter().sum()).collect();
    assert_close(&sums, &[2.0 / 3.0, 1.0, 2.0 / 3.0, 1.0], 1e-6);
}

#[test]
fn degenerate_outlines() {
    for n in [0, 1, 2, 5] {
        let same = contexts(&vec![Point::new(1.0, 1.0); n]);
        assert_eq!(same.histograms().len(), 60 * n);
        let cost = chi_squared(&same, &same);
        assert!(cost.values.iter().all(|&c| c < 1e-6));
        assert_eq!(
            align(&cost, &AlignmentParameters::default(), None).is_some(),
            n > 0
        );
    }
}

#[test]
fn skips_what_is_too_dear() {
    let cost = CostMatrix {
        rows: 2,
        columns: 2,
        values: vec![1.3; 4],
    };
    let found = align(&cost, &AlignmentParameters::default(), None).unwrap();
    assert!(found.pairs.is_empty());
    assert!((found.cost - 1.2).abs() < 1e-6);
}
