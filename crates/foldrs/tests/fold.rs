//! Stage 3: folding neither loses nor makes cloth, and every point knows where it comes from.

mod common;

use common::{cases, outline};
use foldrs::fold::Piece;
use foldrs::model::{intersection_over_union, Region};
use foldrs::outline::signed_area;
use foldrs::{fold, Layer, Outline, Point, Segment, Vector};
use proptest::prelude::*;

/// Positions carry the rounding of the union's grid, some 1e-9 of the extent.
const GRID: f64 = 1e-7;

/// An axis across the whole outline, through a point of the unit square.
fn axis() -> impl Strategy<Value = Segment> {
    (0.2..0.8_f64, 0.2..0.8_f64, 0.0..6.3_f64).prop_map(|(x, y, angle)| {
        let d = Vector::new(angle.cos(), angle.sin()) * 3.0;
        [Point::new(x, y) - d, Point::new(x, y) + d]
    })
}

fn area(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|p| signed_area(&p.points).abs()).sum()
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn cloth_is_neither_lost_nor_made(o in outline(3..28), axis in axis()) {
        let Ok(folded) = fold(&o, &axis) else { return Ok(()) };
        let all = o.signed_area().abs();
        prop_assert!((area(&folded.kept) + area(&folded.flap) - all).abs() < 1e-9);
        prop_assert!((folded.flap_area() - area(&folded.flap)).abs() < 1e-12);
        if folded.holes == 0 && folded.apart == 0 {
            let seen = signed_area(&folded.outline.points).abs();
            prop_assert!((seen + Region::double_layer(&folded).area() - all).abs() < 1e-6);
        }
        prop_assert_eq!(signed_area(&folded.outline.points) > 0.0, o.signed_area() > 0.0);
    }

    #[test]
    fn cloth_is_neither_lost_nor_made_over_one_chord(o in outline(6..28), axis in axis(), which in 0_usize..9) {
        let chords = foldrs::crease::Axis::new(&axis).unwrap().chords(&o).unwrap();
        prop_assume!(!chords.is_empty());
        let line = foldrs::crease::Axis::new(&axis).unwrap();
        let segment = chords[which % chords.len()].ends.map(|e| line.at(e.position));
        let Ok(folded) = fold(&o, &segment) else { return Ok(()) };
        prop_assert_eq!(folded.creases.len(), 1);
        prop_assert_eq!((folded.kept.len(), folded.flap.len()), (1, 1));
        prop_assert!((area(&folded.kept) + area(&folded.flap) - o.signed_area().abs()).abs() < 1e-9);
    }

    #[test]
    fn folding_the_other_side_gives_the_mirror_image(o in outline(3..28), axis in axis()) {
        let (Ok(one), Ok(other)) = (fold(&o, &axis), fold(&o, &[axis[1], axis[0]])) else { return Ok(()) };
        prop_assert_eq!(one.holes, other.holes);
        let image = other.outline.points.iter().map(|p| one.axis.reflect(p)).collect();
        let image = Outline::new(image).unwrap();
        let one = Outline::new(one.outline.points).unwrap();
        prop_assert!(intersection_over_union(&one, &image) > 1.0 - 1e-5);
    }

    #[test]
    fn every_point_lies_where_its_arc_length_says(o in outline(3..28), axis in axis(), n in 1_usize..150) {
        let Ok(folded) = fold(&o, &axis) else { return Ok(()) };
        for p in folded.resample(n) {
            let origin = o.at(p.arc);
            let away = match p.layer {
                Layer::Kept => (origin - p.point).norm(),
                Layer::Flap => (folded.axis.reflect(&origin) - p.point).norm(),
                // The crease has no place on the unfolded outline, but its ends have.
                Layer::Crease => folded.axis.side(&p.point).abs().max(folded.axis.side(&origin).abs()),
            };
            prop_assert!(away < GRID, "{p:?} lies {away} off");
        }
    }

    #[test]
    fn what_lies_on_the_left_is_turned(o in outline(3..28), axis in axis(), share in 0.0..1.0_f64) {
        let Ok(folded) = fold(&o, &axis) else { return Ok(()) };
        let arc = share * o.length();
        let side = folded.axis.side(&o.at(arc));
        prop_assume!(side.abs() > 1e-9);
        prop_assert_eq!(folded.is_turned(arc), side > 0.0);
        prop_assert_eq!(folded.is_turned(arc + o.length()), side > 0.0);
    }

    #[test]
    fn no_flap_reaches_back_over_the_axis(o in outline(3..28), axis in axis()) {
        let Ok(folded) = fold(&o, &axis) else { return Ok(()) };
        let points = folded.kept.iter().chain(&folded.flap).flat_map(|p| &p.points);
        prop_assert!(points.into_iter().all(|p| folded.axis.side(p) < 1e-9));
    }
}
