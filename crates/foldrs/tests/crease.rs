//! The fold axis: reflection, and the chords it cuts from an outline.

mod common;

use common::{cases, outline, star};
use foldrs::crease::{Axis, Chord};
use foldrs::{FoldError, Outline, Point, Segment};
use proptest::prelude::*;

fn point() -> impl Strategy<Value = Point> {
    (-0.5..1.5_f64, -0.5..1.5_f64).prop_map(|(x, y)| Point::new(x, y))
}

fn axis() -> impl Strategy<Value = Axis> {
    (point(), point()).prop_filter_map("no direction", |(a, b)| {
        Axis::new(&[a, b]).ok().filter(|axis| axis.length > 0.1)
    })
}

/// Chords in the order of the axis, entering and leaving in turn.
fn assert_alternate(chords: &[Chord]) {
    let ends: Vec<_> = chords.iter().flat_map(|c| c.ends).collect();
    for pair in ends.windows(2) {
        // Where the line touches a vertex, the outline crosses it twice at one place but for rounding.
        assert!(pair[0].position <= pair[1].position + 1e-12);
        assert_ne!(pair[0].to_left, pair[1].to_left);
    }
}

fn total(chords: &[Chord]) -> f64 {
    chords.iter().map(Chord::length).sum()
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn reflecting_twice_leads_back(axis in axis(), p in point()) {
        prop_assert!((axis.reflect(&axis.reflect(&p)) - p).norm() < 1e-12);
    }

    #[test]
    fn the_axis_halves_the_way_to_the_image(axis in axis(), p in point(), q in point()) {
        let (image, other) = (axis.reflect(&p), axis.reflect(&q));
        prop_assert!((axis.side(&image) + axis.side(&p)).abs() < 1e-12);
        prop_assert!((axis.position(&image) - axis.position(&p)).abs() < 1e-12);
        prop_assert!(((image - other).norm() - (p - q).norm()).abs() < 1e-12);
    }

    #[test]
    fn chords_are_what_of_the_line_lies_inside(o in outline(3..28), axis in axis()) {
        let chords = axis.chords(&o).unwrap();
        assert_alternate(&chords);
        let mut cuts = vec![-5.0];
        for end in chords.iter().flat_map(|c| &c.ends) {
            let p = axis.at(end.position);
            let [a, b] = o.edge(end.edge);
            prop_assert!(((a - p).norm() + (b - p).norm() - (b - a).norm()).abs() < 1e-9);
            cuts.push(end.position);
        }
        cuts.push(5.0);
        for (k, cut) in cuts.windows(2).enumerate().filter(|(_, cut)| cut[1] - cut[0] > 1e-9) {
            prop_assert_eq!(o.contains(&axis.at((cut[0] + cut[1]) / 2.0)), k % 2 == 1);
        }
    }

    #[test]
    fn the_same_chords_are_met_from_either_end(o in outline(3..28), axis in axis()) {
        let back = Axis::new(&[axis.at(axis.length), axis.origin]).unwrap();
        let (one, other) = (axis.chords(&o).unwrap(), back.chords(&o).unwrap());
        prop_assert_eq!(one.len(), other.len());
        prop_assert!((total(&one) - total(&other)).abs() < 1e-9);
    }

    #[test]
    fn vertices_on_the_line_are_no_trouble(p in star(4..40), i in 0_usize..40, vertical in any::<bool>()) {
        let through = p[i % p.len()];
        let ahead = if vertical { Point::new(through.x, through.y + 1.0) } else { Point::new(through.x + 1.0, through.y) };
        let axis = Axis::new(&[through, ahead]).unwrap();
        prop_assert_eq!(axis.side(&through), 0.0);
        let beside = Axis::new(&[through, ahead].map(|p| p + foldrs::Vector::new(1e-9, 1e-9))).unwrap();
        let o = Outline::new(p).unwrap();
        let chords = axis.chords(&o).unwrap();
        assert_alternate(&chords);
        prop_assert!((total(&chords) - total(&beside.chords(&o).unwrap())).abs() < 1e-5);
    }

    #[test]
    fn overlaps_add_up(o in outline(3..28), axis in axis(), at in -2.0..2.0_f64) {
        for chord in axis.chords(&o).unwrap() {
            let parts = chord.overlap(-5.0, at) + chord.overlap(at, 5.0);
            prop_assert!((parts - chord.length()).abs() < 1e-12);
        }
    }
}

#[test]
fn a_line_along_a_side_folds_nothing_over() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
    let outline = Outline::new(square.to_vec()).unwrap();
    let below: Segment = [Point::new(0.0, -1.0), Point::new(1.0, -1.0)];
    assert!(Axis::new(&below).unwrap().chords(&outline).unwrap().is_empty());
    assert_eq!(Axis::new(&[square[0]; 2]), Err(FoldError::NoDirection));
}
