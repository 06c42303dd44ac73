//! Several folds: cloth is neither lost nor stretched, and one fold is a stack of one.

mod common;

use common::{cases, outline};
use foldrs::model::Region;
use foldrs::outline::signed_area;
use foldrs::stack::fold_stack;
use foldrs::{fold, FoldError, Outline, Point, Segment};
use proptest::prelude::*;

/// A line all across the unit square, in either direction.
fn line() -> impl Strategy<Value = Segment> {
    (0.2..0.8_f64, 0.2..0.8_f64, 0.0..std::f64::consts::TAU).prop_map(|(x, y, angle)| {
        let along = nalgebra::Vector2::new(angle.cos(), angle.sin()) * 2.0;
        let middle = Point::new(x, y);
        [middle - along, middle + along]
    })
}

fn square() -> Outline {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    Outline::new(corners.map(|(x, y)| Point::new(x, y)).to_vec()).unwrap()
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn layers_add_up_to_the_garment(
        garment in outline(4..12),
        lines in prop::collection::vec(line(), 1..4),
    ) {
        let Ok(stack) = fold_stack(&garment, &lines, &[]) else { return Ok(()) };
        let cloth: f64 = stack.layers.iter().map(|l| signed_area(&l.ring()).abs()).sum();
        prop_assert!((cloth - garment.signed_area().abs()).abs() < 1e-9);
        // What is seen is as large as the cloth, less what lies over other cloth.
        let rings: Vec<_> = stack.layers.iter().map(|l| l.ring()).collect();
        let seen = Region::union(&rings).area();
        prop_assert!(seen <= cloth + 1e-6 && seen >= cloth / stack.layers.len() as f64 - 1e-6);
        prop_assert!(stack.double_layer().area() <= seen + 1e-6);
    }

    #[test]
    fn one_fold_is_a_stack_of_one(garment in outline(4..12), line in line(), part in (0.0..0.5_f64, 0.5..1.0_f64)) {
        // Some axes do not cover all chords.
        let line = [part.0, part.1].map(|t| line[0] + (line[1] - line[0]) * t);
        let (stack, folded) = (fold_stack(&garment, &[line], &[]), fold(&garment, &line));
        let (Ok(stack), Ok(folded)) = (stack, folded) else { return Ok(()) };
        let turned: f64 = stack.layers.iter().filter(|l| l.turned.by(0)).map(|l| signed_area(&l.ring()).abs()).sum();
        prop_assert!((turned - folded.flap_area()).abs() < 1e-9);
        prop_assert!((stack.double_layer().area() - Region::double_layer(&folded).area()).abs() < 1e-6);
    }

    #[test]
    fn every_point_of_the_rim_is_carried_onto_a_layer(lines in prop::collection::vec(line(), 1..4), share in 0.0..1.0_f64) {
        let garment = square();
        let Ok(stack) = fold_stack(&garment, &lines, &[]) else { return Ok(()) };
        let arc = share * garment.length();
        let placed = stack.place(&garment.at(arc), arc);
        let rims = stack.layers.iter().filter_map(|l| Outline::new(l.ring()).ok());
        let nearest = rims.map(|rim| rim.nearest(&placed).distance).fold(f64::INFINITY, f64::min);
        prop_assert!(nearest < 1e-9);
        let round = stack.place(&garment.at(arc), arc - garment.length());
        prop_assert!((round - placed).norm() < 1e-9);
    }
}

#[test]
fn folds_that_crease_nothing_are_named() {
    let beside = [Point::new(2.0, 0.0), Point::new(2.0, 1.0)];
    assert_eq!(
        fold_stack(&square(), &[beside], &[]).unwrap_err(),
        FoldError::NoCrease
    );
    let no_length = [Point::new(0.5, 0.5); 2];
    assert_eq!(
        fold_stack(&square(), &[no_length], &[]).unwrap_err(),
        FoldError::NoDirection
    );
    let stack = fold_stack(&square(), &[], &[]).unwrap();
    assert_eq!(stack.layers.len(), 1);
    assert_eq!(stack.double_layer().area(), 0.0);
}
