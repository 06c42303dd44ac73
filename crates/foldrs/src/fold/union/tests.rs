//! The walk beside the library: where it answers, both answer alike.

use super::super::{fold, overlay, Grid, Piece};
use super::unite;
use crate::common::{cases, outline, polygon, star, subdivided, transformed};
use crate::{Outline, Point, Segment, Vector};
use proptest::prelude::*;

/// Arc lengths may differ by this share of the extent: the library tells them from vertices rounded to the grid.
const MOVED: f64 = 2e-8;

/// Whether the walk answers; fails if it does otherwise than the library.
fn answers(o: &Outline, axis: &Segment) -> Result<bool, TestCaseError> {
    let Ok(folded) = fold(o, axis) else {
        return Ok(false);
    };
    let (kept, flap, positive) = (&folded.kept, &folded.flap, o.signed_area() > 0.0);
    let grid = Grid::around(kept.iter().chain(flap).flat_map(|p| &p.points));
    let Some((walked, holes)) = unite(kept, flap, positive, &grid) else {
        return Ok(false);
    };
    let (library, holes_of_library, apart) = overlay::unite(kept, flap, positive, &grid).unwrap();
    prop_assert_eq!((holes, 0), (holes_of_library, apart));
    alike(&walked, &library)?;
    Ok(true)
}

/// The same vertices to the last bit, and the same origins.
fn alike(walked: &Piece, library: &Piece) -> Result<(), TestCaseError> {
    prop_assert_eq!(&walked.points, &library.points);
    let away = library.points.iter().map(|p| (p - library.points[0]).norm());
    let moved = MOVED * away.fold(0.0, f64::max);
    for (i, (a, b)) in walked.sources.iter().zip(&library.sources).enumerate() {
        prop_assert_eq!(a.layer, b.layer);
        let off = [0, 1].map(|end| (a.arc[end] - b.arc[end]).abs());
        prop_assert!(off[0] < moved && off[1] < moved, "edge {i}: {a:?} is not {b:?}");
    }
    Ok(())
}

/// An axis through a point of the unit square, of any length.
fn axis() -> impl Strategy<Value = Segment> {
    (0.1..0.9_f64, 0.1..0.9_f64, 0.0..6.3_f64, 0.05..3.0_f64).prop_map(|(x, y, angle, half)| {
        let d = Vector::new(angle.cos(), angle.sin()) * half;
        [Point::new(x, y) - d, Point::new(x, y) + d]
    })
}

/// One side of a garment, from its collar down; mirrored over the y axis.
fn garment(side: &[[f64; 2]]) -> Vec<Point> {
    let right = side.iter().map(|&[x, y]| Point::new(x, y));
    let left = side.iter().rev().map(|&[x, y]| Point::new(-x, y));
    left.chain(right).collect()
}

const SHIRT: [[f64; 2]; 7] = [
    [0.8, 10.0],
    [2.5, 9.5],
    [5.5, 7.0],
    [4.7, 6.0],
    [2.7, 7.5],
    [2.5, 4.0],
    [2.7, 0.0],
];
const UPRIGHT: Segment = [Point::new(0.0, -20.0), Point::new(0.0, 20.0)];

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn random_outlines(o in outline(3..40), axis in axis()) {
        answers(&o, &axis)?;
    }

    /// Straight sides of many points, over any line; both windings.
    #[test]
    fn stars_with_straight_sides(star in star(3..20), pieces in 1_usize..9, axis in axis(), flip in any::<bool>()) {
        let points = transformed(&subdivided(&star, pieces), 0.3, 0.5, 0.5, flip);
        answers(&Outline::new(points).unwrap(), &axis)?;
    }

    /// Outlines that cross themselves: the library has its own idea of what is inside.
    #[test]
    fn tangled_outlines(xy in prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64), 4..12), axis in axis()) {
        let points = xy.into_iter().map(|(x, y)| Point::new(x, y)).collect();
        let Ok(o) = Outline::new(points) else { return Ok(()) };
        answers(&o, &axis)?;
    }

    /// Vertices upon edges and edges upon each other, before the fold and after it.
    #[test]
    fn corners_on_a_coarse_grid(p in polygon(4..24), steps in 3..12_i32, ends in prop::array::uniform4(-1..13_i32)) {
        let on = |v: f64| (v * f64::from(steps)).round() / f64::from(steps);
        let Ok(o) = Outline::new(p.iter().map(|p| Point::new(on(p.x), on(p.y))).collect()) else { return Ok(()) };
        let [a, b, c, d] = ends.map(|v| f64::from(v) / f64::from(steps));
        answers(&o, &[Point::new(a, b), Point::new(c, d)])?;
    }

    /// Symmetric garments, folded on their middle or nearly so.
    #[test]
    fn garments_near_their_middle(
        (by, angle) in (-12..-3_i32, -1.0..1.0_f64), pieces in 1_usize..12, turn in 0.0..6.3_f64,
    ) {
        let near = 10.0_f64.powi(by);
        let d = Vector::new(angle * near, 20.0);
        let axis = [Point::new(near, 5.0) - d, Point::new(near, 5.0) + d];
        let turned = |p: &[Point]| transformed(p, turn, 37.0, 400.0, false);
        let axis = turned(&axis);
        answers(&Outline::new(turned(&subdivided(&garment(&SHIRT), pieces))).unwrap(), &[axis[0], axis[1]])?;
    }
}

/// Whatever is left to the library costs time, so clear cases must not be.
#[test]
fn clear_folds_are_answered() {
    let shirt = Outline::new(garment(&SHIRT)).unwrap();
    let many = Outline::new(subdivided(&garment(&SHIRT), 20)).unwrap();
    // The hem turned up, a sleeve turned in, aslant through all, and through both sleeves.
    for (a, b) in [
        ((-9.0, 2.1), (9.0, 2.0)),
        ((2.0, 12.0), (4.0, 5.0)),
        ((-9.0, 1.0), (9.0, 7.4)),
        ((-9.0, 6.6), (9.0, 6.7)),
    ] {
        let (a, b) = (Point::new(a.0, a.1), Point::new(b.0, b.1));
        for o in [&shirt, &many, &shirt.reversed()] {
            for axis in [[a, b], [b, a]] {
                assert!(answers(o, &axis).unwrap(), "{axis:?}");
            }
        }
    }
}

#[test]
fn edges_upon_each_other_are_left_to_the_library() {
    let shirt = Outline::new(garment(&SHIRT)).unwrap();
    assert!(!answers(&shirt, &UPRIGHT).unwrap());
    let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Point::new(x, y));
    let square = Outline::new(square.to_vec()).unwrap();
    for height in [1.5, 1.0, 0.25] {
        assert!(!answers(&square, &[Point::new(-1.0, height), Point::new(3.0, height)]).unwrap());
    }
}

#[test]
fn holes_are_counted() {
    let elbow = [(0, 0), (10, 0), (10, 1), (1, 1), (1, 6), (0, 6)]
        .map(|(x, y)| Point::new(f64::from(x), f64::from(y)));
    let elbow = Outline::new(elbow.to_vec()).unwrap();
    let d = Vector::new(0.38, 0.92);
    let axis = [Point::new(4.0, 0.5) + d, Point::new(4.0, 0.5) - d];
    assert!(answers(&elbow, &axis).unwrap());
    assert_eq!(fold(&elbow, &axis).unwrap().holes, 1);
}
