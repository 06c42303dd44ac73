//! The heavy steps on wavy outlines of 50 to 400 points, one by one and as one hypothesis needs them; one thread.

mod common;

use std::hint::black_box;

use common::{contexts, outline, AXIS, SIZES};
use criterion::{criterion_group, criterion_main, Bencher, BenchmarkId, Criterion};
use foldrs::alignment::{align, alignment_costs, AlignmentParameters};
use foldrs::inner_distance::inner_distances;
use foldrs::matching::Seen;
use foldrs::parameters::PartialMatchParameters;
use foldrs::partial_match::{partial_matches, ChordAngles};
use foldrs::shape_context::{chi_squared, mirrored_shape_contexts, shape_contexts, ShapeContextParameters};
use foldrs::{fold, Outline, Parameters, Point};

/// Measures one step at every size.
fn step(criterion: &mut Criterion, name: &str, mut run: impl FnMut(&mut Bencher<'_>, usize)) {
    let mut group = criterion.benchmark_group(name);
    for n in SIZES {
        group.bench_with_input(BenchmarkId::from_parameter(n), &n, |bencher, &n| run(bencher, n));
    }
}

fn folding(criterion: &mut Criterion) {
    step(criterion, "fold", |bencher, n| {
        let unfolded = Outline::new(outline(n, 0.0)).expect("a star is an outline");
        bencher.iter(|| fold(black_box(&unfolded), &AXIS));
    });
}

fn partial_matching(criterion: &mut Criterion) {
    let parameters = PartialMatchParameters::default();
    step(criterion, "chord_angles", |bencher, n| {
        let points = outline(n, 0.0);
        bencher.iter(|| ChordAngles::new(black_box(&points), parameters.delta));
    });
    step(criterion, "partial_matches, one face", |bencher, n| {
        let angles = |phase| ChordAngles::new(&outline(n, phase), parameters.delta);
        let (seen, template) = (angles(0.0), angles(1.0));
        bencher.iter(|| partial_matches(black_box(&seen), &template, &parameters));
    });
}

fn shape_matching(criterion: &mut Criterion) {
    step(criterion, "inner_distances", |bencher, n| {
        let points = outline(n, 0.0);
        bencher.iter(|| inner_distances(black_box(&points)));
    });
    step(criterion, "shape_contexts", |bencher, n| {
        let points = outline(n, 0.0);
        let (inner, parameters) = (inner_distances(&points), ShapeContextParameters::default());
        bencher.iter(|| shape_contexts(black_box(&points), &inner, &parameters));
    });
    step(criterion, "chi_squared", |bencher, n| {
        let (a, b) = (contexts(&outline(n, 0.0)), contexts(&outline(n, 1.0)));
        bencher.iter(|| chi_squared(black_box(&a), &b));
    });
    let parameters = AlignmentParameters::default();
    let cost = |n| chi_squared(&contexts(&outline(n, 0.0)), &contexts(&outline(n, 1.0)));
    step(criterion, "alignment_costs, 8 starts", |bencher, n| {
        let (cost, starts): (_, Vec<usize>) = (cost(n), (0..8).map(|k| k * n / 8).collect());
        bencher.iter(|| alignment_costs(black_box(&cost), &parameters, &starts));
    });
    step(criterion, "align", |bencher, n| {
        let cost = cost(n);
        bencher.iter(|| align(black_box(&cost), &parameters, None));
    });
}

/// What testing one claim about the axis takes: fold, resample, describe, align both faces.
fn hypothesis(criterion: &mut Criterion) {
    step(criterion, "one hypothesis", |bencher, n| {
        let unfolded = Outline::new(outline(n, 0.0)).expect("a star is an outline");
        let mut parameters = Parameters::default();
        parameters.shape_context.n_points = n;
        let seen = Outline::new(outline(n, 1.0)).expect("a star is an outline");
        let points = Seen::new(seen, &parameters).points().to_vec();
        let inner = inner_distances(&points);
        let faces = [shape_contexts, mirrored_shape_contexts]
            .map(|describe| describe(&points, &inner, &parameters.shape_context));
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

criterion_group!(benches, folding, partial_matching, shape_matching, hypothesis);
criterion_main!(benches);
