//! Whole stages, on one thread and on all: claims about the axis, their scoring by number, and the joint fit.

mod common;

use std::hint::black_box;

use common::{outline, AXIS};
use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};
use foldrs::fit::{explain_jointly, FlexibleTemplate, FoldCount};
use foldrs::matching::{cheapest_folds, claim_axes, match_folded, Seen};
use foldrs::{fold, Outline, Parameters};

/// A star folded, and three stars it may be a fold of.
fn scene(parameters: &Parameters) -> (Seen, Vec<Outline>) {
    let star = |phase| Outline::new(outline(60, phase)).expect("a star is an outline");
    let folded = fold(&star(0.0), &AXIS).expect("the axis folds the star");
    let folded = Outline::new(folded.outline.points).expect("a folded star is an outline");
    (
        Seen::new(folded, parameters),
        vec![star(0.0), star(0.5), star(1.0)],
    )
}

/// Measures a stage on one thread and on all there are.
fn on_threads(criterion: &mut Criterion, name: &str, run: impl Fn() + Sync) {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10);
    let mut counts = vec![1, rayon::current_num_threads()];
    counts.dedup();
    for threads in counts {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads can be started");
        group.bench_function(BenchmarkId::new("threads", threads), |bencher| {
            pool.install(|| bencher.iter(&run));
        });
    }
}

fn matching(criterion: &mut Criterion) {
    let mut parameters = Parameters::default();
    let (seen, templates) = scene(&parameters);
    on_threads(criterion, "claim_axes", || {
        black_box(claim_axes(&seen, &templates, Some(1.0), &parameters));
    });
    for hypotheses in [25, 50, 100, 200] {
        parameters.hypothesis.most = hypotheses;
        on_threads(
            criterion,
            &format!("match_folded, {hypotheses} a template"),
            || {
                black_box(match_folded(&seen, &templates, Some(1.0), &parameters));
            },
        );
    }
    on_threads(criterion, "cheapest_folds, 200 a template", || {
        black_box(cheapest_folds(&seen, &templates, Some(1.0), &parameters));
    });
}

fn joint_fit(criterion: &mut Criterion) {
    let parameters = Parameters::default();
    let (seen, templates) = scene(&parameters);
    let claims = claim_axes(&seen, &templates, Some(1.0), &parameters);
    let flexible: Vec<FlexibleTemplate> = templates
        .iter()
        .map(|t| FlexibleTemplate::new(t, &[], &parameters.fit))
        .collect();
    on_threads(criterion, "explain_jointly", || {
        let folds = FoldCount::Exactly(1);
        black_box(explain_jointly(
            &seen,
            &flexible,
            &claims,
            Some(1.0),
            None,
            folds,
            &parameters,
        ));
    });
}

criterion_group!(benches, matching, joint_fit);
criterion_main!(benches);
