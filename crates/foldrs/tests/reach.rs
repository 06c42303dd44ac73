//! How a gripper reaches landmarks, over garments drawn from what is as likely as a fit.

mod common;

use foldrs::fit::{explain_from, FlexibleTemplate, JointExplanation, KnownFold};
use foldrs::hypothesis::Face;
use foldrs::landmark::{reach, Reach};
use foldrs::matching::Seen;
use foldrs::{fold, Outline, Parameters, Point};

/// A trapezium of 60 by 40 cm, its right part folded over where x is 38, under the left: the crease is seen, the flap not.
/// No two of its corners are alike, so that it can lie in one way only.
const GARMENT: [[f64; 2]; 4] = [[0.0, 0.0], [60.0, 6.0], [57.0, 40.0], [2.0, 44.0]];

fn explained(parameters: &Parameters) -> JointExplanation {
    let template = Outline::try_from(&GARMENT[..]).unwrap();
    // The upper and the lower side where the crease meets them.
    let (low, high) = (6.0 * 38.0 / 60.0, 44.0 - 4.0 * 36.0 / 55.0);
    let seen = Outline::try_from(&[[0.0, 0.0], [38.0, low], [38.0, high], [2.0, 44.0]][..]).unwrap();
    let known = KnownFold {
        template: 0,
        axis: [Point::new(38.0, low), Point::new(38.0, high)],
        crease: [Point::new(38.0, low), Point::new(38.0, high)],
        face: Face::Seen,
    };
    let templates = [FlexibleTemplate::new(&template, &[], &parameters.fit)];
    let seen = Seen::new(seen, parameters);
    let told = explain_from(&seen, &templates, &[known], Some(1.0), None, parameters);
    told.into_iter().next().unwrap()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}

#[test]
fn what_is_hidden_is_drawn_wider_than_what_is_seen() {
    let told = explained(&Parameters::default());
    // A draw may lose its crease.
    let asked = Parameters::default().fit.draws;
    assert!(
        (asked * 9 / 10..=asked).contains(&told.draws.len()),
        "{}",
        told.draws.len()
    );
    let spread = |corner: usize| {
        let at = told.to_seen.apply(&told.outline[corner]);
        mean(told.draws.iter().map(|draw| (draw.outline[corner] - at).norm()))
    };
    let (seen, hidden) = (spread(0).max(spread(3)), spread(1).min(spread(2)));
    assert!(seen < 2.0 && hidden > 2.0 * seen, "{seen} {hidden}");
    for (k, corner) in told.outline.iter().enumerate() {
        // Draws come in pairs about the fit.
        let x = mean(told.draws.iter().map(|draw| draw.outline[k].x));
        let y = mean(told.draws.iter().map(|draw| draw.outline[k].y));
        assert!((Point::new(x, y) - told.to_seen.apply(corner)).norm() < 1.5);
    }
}

#[test]
fn the_same_outline_gives_the_same_draws_and_less_variance_nearer_ones() {
    let mut parameters = Parameters::default();
    let wide = explained(&parameters);
    assert_eq!(explained(&parameters).draws[5].outline, wide.draws[5].outline);
    parameters.fit.draw_variance /= 9.0;
    let narrow = explained(&parameters);
    let spread = |told: &JointExplanation| {
        let at = told.to_seen.apply(&told.outline[1]);
        mean(told.draws.iter().map(|draw| (draw.outline[1] - at).norm()))
    };
    let ratio = spread(&wide) / spread(&narrow);
    assert!((ratio - 3.0).abs() < 0.3, "{ratio}");
}

#[test]
fn what_is_seen_is_within_reach_in_most_draws_and_what_is_turned_under_in_few() {
    let told = explained(&Parameters::default());
    let reached = told.reach_drawn(&told.outline, usize::MAX);
    assert!(reached.len() > 50);
    let share = |corner: usize| {
        let free = |corners: &&Vec<Reach>| {
            corners[corner].off_outline < 1.0 && corners[corner].to_double_layer > 2.0
        };
        reached.iter().filter(free).count() as f64 / reached.len() as f64
    };
    let shares = [0, 1, 2, 3].map(share);
    assert!(
        shares[0].min(shares[3]) > 0.95 && shares[1].max(shares[2]) < 0.25,
        "{shares:?}"
    );
    assert_eq!(told.reach_drawn(&told.outline, 6).len(), 6);
}

#[test]
fn without_draws_the_fit_itself_is_believed() {
    let mut parameters = Parameters::default();
    parameters.fit.draws = 0;
    let told = explained(&parameters);
    assert!(told.draws.is_empty());
    let unfolded: Vec<Point> = told.outline.iter().map(|p| told.to_seen.apply(p)).collect();
    let itself = reach(&Outline::new(unfolded.clone()).unwrap(), &told.creases, &unfolded).unwrap();
    let reached = told.reach_drawn(&told.outline, 64);
    assert_eq!(reached.len(), 1);
    for (one, other) in reached[0].iter().zip(&itself) {
        assert!((one.place - other.place).norm() < 1e-9);
        assert!((one.to_double_layer - other.to_double_layer).abs() < 1e-9);
    }
}

#[test]
fn garments_the_other_way_round_are_drawn_so() {
    // Either part is turned over; the smaller one is told to be, and the draws have to agree.
    let parameters = Parameters::default();
    let template = Outline::try_from(&GARMENT[..]).unwrap();
    let low = Point::new(22.0, 6.0 * 22.0 / 60.0);
    let high = Point::new(22.0, 44.0 - 4.0 * 20.0 / 55.0);
    for flap_left in [[low, high], [high, low]] {
        let kept_left = [flap_left[1], flap_left[0]];
        let folded = fold(&template, &flap_left).unwrap();
        let known = KnownFold {
            template: 0,
            axis: kept_left,
            crease: kept_left,
            face: Face::Seen,
        };
        let templates = [FlexibleTemplate::new(&template, &[], &parameters.fit)];
        let outline = Outline::new(folded.outline.points.clone()).unwrap().positive();
        let seen = Seen::new(outline, &parameters);
        let told = explain_from(&seen, &templates, &[known], Some(1.0), None, &parameters);
        let told = &told[0];
        for (k, corner) in told.outline.iter().enumerate() {
            let at = told.to_seen.apply(corner);
            let off = mean(told.draws.iter().map(|draw| (draw.outline[k] - at).norm()));
            assert!(off < 15.0, "corner {k} is drawn {off} cm away");
        }
        assert!(told.reach_drawn(&told.outline, usize::MAX).len() > 50);
    }
}
