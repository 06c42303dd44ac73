//! The result of matching and fitting is the same on any number of threads, to the last bit.

use foldrs::fit::{explain_jointly, FlexibleTemplate, FoldCount};
use foldrs::matching::{cheapest_folds, claim_axes, Seen};
use foldrs::{fold, match_folded, Outline, Parameters, Point};

/// A T-shirt, cm.
const SHIRT: [[f64; 2]; 12] = [
    [-9.0, 0.0],
    [-22.0, 3.0],
    [-40.0, 22.0],
    [-28.0, 32.0],
    [-22.0, 25.0],
    [-22.0, 70.0],
    [22.0, 70.0],
    [22.0, 25.0],
    [28.0, 32.0],
    [40.0, 22.0],
    [22.0, 3.0],
    [9.0, 0.0],
];

/// A towel, cm.
const TOWEL: [[f64; 2]; 4] = [[0.0, 0.0], [50.0, 0.0], [50.0, 70.0], [0.0, 70.0]];

fn outline(corners: &[[f64; 2]]) -> Outline {
    Outline::new(corners.iter().map(|p| Point::new(p[0], p[1])).collect()).unwrap()
}

/// Everything the two stages say, as text: floating-point numbers are written so that they can be read back exactly.
fn told(parameters: &Parameters) -> (String, usize, usize) {
    let templates = [outline(&SHIRT), outline(&TOWEL)];
    let folded = fold(&templates[0], &[Point::new(-30.0, 52.0), Point::new(30.0, 40.0)]).unwrap();
    let seen = Seen::new(Outline::new(folded.outline.points).unwrap(), parameters);
    let flexible = templates
        .each_ref()
        .map(|t| FlexibleTemplate::new(t, &[], &parameters.fit));
    let claims = claim_axes(&seen, &templates, Some(1.0), parameters);
    let matching = match_folded(&seen, &templates, Some(1.0), parameters);
    let cheapest = cheapest_folds(&seen, &templates, Some(1.0), parameters);
    // What bounds the search leaves out is never the answer.
    for found in &cheapest.candidates {
        let first = matching.candidates.iter().find(|c| c.template == found.template);
        assert_eq!(format!("{found:?}"), format!("{:?}", first.unwrap()));
    }
    let matched: std::collections::BTreeSet<usize> = matching.candidates.iter().map(|c| c.template).collect();
    assert_eq!(cheapest.candidates.len(), matched.len());
    assert_eq!(cheapest.unfolded, matching.unfolded);
    let fits = explain_jointly(
        &seen,
        &flexible,
        &claims,
        Some(1.0),
        None,
        FoldCount::Exactly(2),
        parameters,
    );
    let counts = (matching.candidates.len(), fits.by_folds[2].len());
    (
        format!("{claims:?} {matching:?} {cheapest:?} {fits:?}"),
        counts.0,
        counts.1,
    )
}

#[test]
fn any_number_of_threads_tells_the_same() {
    let mut parameters = Parameters::default();
    // Enough work to be shared out, little enough for a test.
    parameters.partial_match.points = 60;
    parameters.hypothesis.most = 12;
    parameters.fit.starts = 20;
    parameters.fit.refined = 6;
    parameters.fit.polished = 4;
    let [one, two, eight] = [1, 2, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| told(&parameters))
    });
    assert!(
        one.1 > 3 && one.2 > 3,
        "too few results to tell: {} and {}",
        one.1,
        one.2
    );
    assert!(one == two && one == eight);
}
