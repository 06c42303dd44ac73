//! Parameters, outlines and results are written and read back as they were.

use foldrs::fit::FoldCount;
use foldrs::prelude::*;
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
