//! The heavy steps on a wavy outline of 100 to 800 points, one by one and as one hypothesis needs them.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};
use foldrs::alignment::{align, alignment_costs, AlignmentParameters};
use foldrs::inner_distance::inner_distances;
use foldrs::matching::Seen;
use foldrs::parameters::PartialMatchParameters;
use foldrs::partial_match::{partial_matches, ChordAngles};
use foldrs::shape_context::{chi_squared, shape_contexts, ShapeContextParameters, ShapeContexts};
use foldrs::{fold, Outline, Parameters, Point, Segment};

/// A star with rounded rays, about a third of its vertices reflex.
fn outline(n: usize, phase: f64) -> Vec<Point> {
    (0..n)
        .map(|k| {
            let angle = TAU * k as f64 / n as f64;
            let radius = 1.0 + 0.5 * (5.0 * angle + phase).sin() + 0.2 * (11.0 * angle).cos();
            Point::new(radius * angle.cos(), radius * angle.sin())
        })
        .collect()
}

fn contexts(points: &[Point]) -> ShapeContexts {
    shape_contexts(
        points,
        &inner_distances(points),
        &ShapeContextParameters::default(),
    )
}

fn inner_distance(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("inner_distances");
    for n in [100, 200, 400, 800] {
        let points = outline(n, 0.0);
        group.bench_with_input(BenchmarkId::from_parameter(n), &points, |bencher, points| {
            bencher.iter(|| inner_distances(black_box(points)));
        });
    }
}

fn shape_matching(criterion: &mut Criterion) {
    let (a, b) = (outline(100, 0.0), outline(100, 1.0));
    let inner = inner_distances(&a);
    let (contexts_a, contexts_b) = (contexts(&a), contexts(&b));
    let cost = chi_squared(&contexts_a, &contexts_b);
    let parameters = AlignmentParameters::default();
    let starts: Vec<usize> = (0..8).map(|k| k * 12).collect();

    criterion.bench_function("shape_contexts", |bencher| {
        let parameters = ShapeContextParameters::default();
        bencher.iter(|| shape_contexts(black_box(&a), &inner, &parameters));
    });
    criterion.bench_function("chi_squared", |bencher| {
        bencher.iter(|| chi_squared(black_box(&contexts_a), &contexts_b));
    });
    criterion.bench_function("alignment_costs, 8 starts", |bencher| {
        bencher.iter(|| alignment_costs(black_box(&cost), &parameters, &starts));
    });
    criterion.bench_function("align", |bencher| {
        bencher.iter(|| align(black_box(&cost), &parameters, None));
    });
}

/// An axis off the centre, across the whole outline.
const AXIS: Segment = [Point::new(-2.0, 0.3), Point::new(2.0, 0.5)];

fn folding(criterion: &mut Criterion) {
    let unfolded = Outline::new(outline(100, 0.0)).expect("a star is an outline");
    criterion.bench_function("fold", |bencher| {
        bencher.iter(|| fold(black_box(&unfolded), &AXIS));
    });
}

fn partial_matching(criterion: &mut Criterion) {
    let parameters = PartialMatchParameters::default();
    let angles = |phase| ChordAngles::new(&outline(parameters.points, phase), parameters.delta);
    let (seen, template) = (angles(0.0), angles(1.0));
    criterion.bench_function("partial_matches, one face", |bencher| {
        bencher.iter(|| partial_matches(black_box(&seen), &template, &parameters));
    });
}

/// What testing one claim about the axis takes: fold, resample, describe, align both faces.
fn hypothesis(criterion: &mut Criterion) {
    let unfolded = Outline::new(outline(100, 0.0)).expect("a star is an outline");
    let seen = Outline::new(outline(100, 1.0)).expect("a star is an outline");
    let parameters = Parameters::default();
    let n = parameters.shape_context.n_points;
    let seen = contexts(Seen::new(seen, &parameters).points());
    let faces = [seen.mirrored(), seen];
    criterion.bench_function("one hypothesis", |bencher| {
        bencher.iter(|| {
            let folded = fold(black_box(&unfolded), &AXIS).expect("the axis folds the star");
            let points: Vec<Point> = folded.resample(n).iter().map(|p| p.point).collect();
            let folded = contexts(&points);
            faces
                .each_ref()
                .map(|seen| align(&chi_squared(&folded, seen), &parameters.alignment, None))
        });
    });
}

criterion_group!(
    benches,
    folding,
    partial_matching,
    inner_distance,
    shape_matching,
    hypothesis
);
criterion_main!(benches);
