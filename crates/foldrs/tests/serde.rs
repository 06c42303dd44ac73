//! Parameters, outlines and results are written and read back as they were.

use foldrs::fit::{FoldCount, KnownFold, Start};
use foldrs::hypothesis::Face;
use foldrs::inner_distance::{inner_distances, InnerDistances};
use foldrs::prelude::*;
use foldrs::shape_context::{chi_squared, shape_contexts, CostMatrix};
use foldrs::stack::{fold_stack, FoldedStack};
use serde_json::{from_str, to_string};

const SHEET: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [30.0, 0.0],
    [30.0, 50.0],
    [70.0, 50.0],
    [70.0, 80.0],
    [0.0, 80.0],
];

#[test]
fn parameters_left_out_keep_their_defaults_and_unknown_ones_are_refused() {
    let some: Parameters = from_str(r#"{"hypothesis": {"most": 7}}"#).unwrap();
    let mut wanted = Parameters::default();
    wanted.hypothesis.most = 7;
    assert_eq!(some, wanted);
    assert_eq!(
        from_str::<Parameters>(&to_string(&wanted).unwrap()).unwrap(),
        wanted
    );

    let told = from_str::<Parameters>(r#"{"hypothesis": {"mots": 7}}"#).unwrap_err();
    assert!(told.to_string().contains("mots"), "{told}");
}

#[test]
fn an_outline_is_its_points_and_is_checked_when_read() {
    let sheet = Outline::try_from(&SHEET[..]).unwrap();
    let text = to_string(&sheet).unwrap();
    assert_eq!(text, to_string(&SHEET).unwrap());
    assert_eq!(from_str::<Outline>(&text).unwrap(), sheet);

    let told = from_str::<Outline>("[[0, 0], [1, 1], [2, 2]]").unwrap_err();
    assert!(told.to_string().contains("encloses no area"), "{told}");
}

#[test]
fn results_are_read_back_as_they_were() {
    let sheet = Outline::try_from(&SHEET[..]).unwrap();
    let folded = fold(&sheet, &[Point::new(58.0, 80.0), Point::new(52.0, 50.0)]).unwrap();
    assert_eq!(from_str::<Folded>(&to_string(&folded).unwrap()).unwrap(), folded);

    let mut parameters = Parameters::default();
    parameters.hypothesis.most = 5;
    (parameters.fit.starts, parameters.fit.refined) = (40, 4);
    let seen = Seen::new(Outline::new(folded.outline.points).unwrap(), &parameters);
    let found = match_folded(&seen, std::slice::from_ref(&sheet), Some(1.0), &parameters);
    let again: Matching = from_str(&to_string(&found).unwrap()).unwrap();
    assert!(!found.candidates.is_empty());
    assert_eq!(format!("{again:?}"), format!("{found:?}"));

    let best = explain(&seen, &sheet, &found.candidates[0].hypothesis.axis, &parameters).unwrap();
    let again: Explanation = from_str(&to_string(&best).unwrap()).unwrap();
    assert_eq!(format!("{again:?}"), format!("{best:?}"));

    let claims = claim_axes(&seen, std::slice::from_ref(&sheet), Some(1.0), &parameters);
    let flexible = FlexibleTemplate::new(&sheet, &[], &parameters.fit);
    let fits = explain_jointly(
        &seen,
        &[flexible],
        &claims,
        Some(1.0),
        None,
        FoldCount::Exactly(1),
        &parameters,
    );
    assert!(!fits.by_folds[1].is_empty());
    let again: JointFits = from_str(&to_string(&fits).unwrap()).unwrap();
    assert_eq!(format!("{again:?}"), format!("{fits:?}"));
}

/// What comes of writing and reading it.
fn again<T: serde::Serialize + serde::de::DeserializeOwned>(told: &T) -> T {
    from_str(&to_string(told).unwrap()).unwrap()
}

#[test]
fn stacks_distances_and_what_a_fit_begins_with_are_read_back_as_they_were() {
    let sheet = Outline::try_from(&SHEET[..]).unwrap();
    let axes = [
        [Point::new(58.0, 80.0), Point::new(52.0, 50.0)],
        [Point::new(0.0, 60.0), Point::new(70.0, 65.0)],
    ];
    let stack = fold_stack(&sheet, &axes, &[]).unwrap();
    let read: FoldedStack = again(&stack);
    assert_eq!(read, stack);
    assert_eq!(read.creases_seen(0), stack.creases_seen(0));
    assert_eq!(read.outline(), stack.outline());

    let (points, parameters) = (sheet.resample(20), Parameters::default());
    let inner = inner_distances(&points);
    assert_eq!(again::<InnerDistances>(&inner), inner);
    let contexts = shape_contexts(&points, &inner, &parameters.shape_context);
    let costs = chi_squared(&contexts, &contexts);
    assert_eq!(again::<CostMatrix>(&costs), costs);

    let known = KnownFold {
        template: 0,
        axis: axes[0],
        crease: axes[1],
        face: Face::Mirrored,
    };
    assert_eq!(again(&known), known);
    assert_eq!(again(&FoldCount::UpTo(2)), FoldCount::UpTo(2));
    let start = Start {
        sides: axes.to_vec(),
        anchor: axes[0][0],
        target: axes[1][0],
        turn: 0.25,
        scale: 2.0,
        reflected: true,
    };
    assert_eq!(again(&start), start);
}
