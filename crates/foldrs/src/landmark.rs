//! Landmarks: carried along when an outline's corners move (section 3.1), and how well a gripper can reach them on the
//! folded garment (section 3.2).

use crate::outline::nearest_edge;
use crate::stack::fold_stack;
use crate::{FoldError, Outline, Point, Segment};

/// A point of an outline, told by the edge it lies on: it stays the same when the corners move.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Landmark {
    /// Index of the edge, which is that of its first corner.
    pub edge: usize,
    /// Share of the edge's length before the point, 0 to 1.
    pub share: f64,
}

impl Landmark {
    /// The point of a closed polygon's outline nearest to `q`; `None` without corners.
    ///
    /// ```
    /// use foldrs::{landmark::Landmark, Point};
    /// let square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
    /// let wide = [(0.0, 0.0), (8.0, 0.0), (8.0, 4.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
    /// let mark = Landmark::nearest(&square, &Point::new(1.0, -0.1)).unwrap();
    /// assert_eq!(mark.on(&wide), Some(Point::new(2.0, 0.0)));
    /// ```
    #[must_use]
    pub fn nearest(corners: &[Point], q: &Point) -> Option<Self> {
        let (edge, share, _) = nearest_edge(corners, q);
        (!corners.is_empty()).then_some(Self { edge, share })
    }

    /// Where it lies on the outline of a polygon with as many corners; `None` if that has no such edge.
    #[must_use]
    pub fn on(&self, corners: &[Point]) -> Option<Point> {
        let from = corners.get(self.edge)?;
        let to = corners[(self.edge + 1) % corners.len()];
        Some(from + (to - from) * self.share)
    }
}

/// Where folding puts a landmark, and what a gripper finds there.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Reach {
    /// Where it lies on the folded garment.
    pub place: Point,
    /// Its distance from the outline of that: 0 unless another layer sticks out over it.
    pub off_outline: f64,
    /// Its distance from where two layers or more lie over each other; infinite if they do so nowhere.
    pub to_double_layer: f64,
}

/// How well points of an outline can be reached when it is folded over creases that have the flap on their left, the first
/// made first. All lengths are in the outline's unit.
///
/// # Errors
/// Those of [`fold_stack`], and [`FoldError::EmptyFlap`] if the layers enclose no area.
pub fn reach(outline: &Outline, creases: &[Segment], points: &[Point]) -> Result<Vec<Reach>, FoldError> {
    let stack = fold_stack(outline, creases, &[])?;
    let (rim, double) = (stack.outline()?, stack.double_layer());
    let reached = points.iter().map(|point| {
        let place = stack.place(point, outline.nearest(point).arc);
        Reach {
            place,
            off_outline: rim.nearest(&place).distance,
            to_double_layer: double.distance(&place),
        }
    });
    Ok(reached.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fold;

    /// A rectangle of 40 by 20, its right end of 10 folded over, and its corners.
    fn folded() -> (Outline, Segment, Vec<Point>) {
        let outline = Outline::try_from(&[[0.0, 0.0], [40.0, 0.0], [40.0, 20.0], [0.0, 20.0]][..]).unwrap();
        let crease = [Point::new(30.0, 21.0), Point::new(30.0, -1.0)];
        let corners = outline.points().to_vec();
        (outline, crease, corners)
    }

    #[test]
    fn what_is_turned_over_lies_in_the_double_layer_and_what_is_kept_beside_it() {
        let (outline, crease, corners) = folded();
        let reached = reach(&outline, &[crease], &corners).unwrap();
        let places: Vec<Point> = reached.iter().map(|r| r.place).collect();
        let expected = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)].map(|(x, y)| Point::new(x, y));
        for (place, expected) in places.iter().zip(expected) {
            assert!((place - expected).norm() < 1e-6, "{place} {expected}");
        }
        for (mark, to_double_layer) in reached.iter().zip([20.0, 0.0, 0.0, 20.0]) {
            assert!((mark.to_double_layer - to_double_layer).abs() < 1e-6);
            assert!(mark.off_outline < 1e-6);
        }
    }

    #[test]
    fn what_comes_to_lie_within_is_off_the_outline() {
        let (outline, crease, _) = folded();
        let reached = reach(&outline, &[crease], &[Point::new(40.0, 8.0)]).unwrap()[0];
        assert!((reached.off_outline - 8.0).abs() < 1e-6);
    }

    #[test]
    fn without_a_fold_everything_is_within_reach() {
        let (outline, _, corners) = folded();
        for (mark, corner) in reach(&outline, &[], &corners)
            .unwrap()
            .iter()
            .zip(outline.points())
        {
            assert_eq!(mark.place, *corner);
            assert_eq!(mark.off_outline, 0.0);
            assert_eq!(mark.to_double_layer, f64::INFINITY);
        }
    }

    #[test]
    fn a_crease_beside_the_garment_is_refused() {
        let (outline, _, corners) = folded();
        let beside = [Point::new(90.0, 21.0), Point::new(90.0, -1.0)];
        assert!(reach(&outline, &[beside], &corners).is_err());
    }

    proptest::proptest! {
        #[test]
        fn landmarks_are_carried_as_the_outline_is(scale in 0.1..10.0_f64, at in 0.0..1.0_f64, x in -9.0..9.0_f64) {
            let (outline, _, _) = folded();
            let carry = |p: &Point| Point::new(scale * p.x + x, scale * p.y - x);
            let moved: Vec<Point> = outline.points().iter().map(carry).collect();
            let point = outline.at(at * outline.length());
            let mark = Landmark::nearest(outline.points(), &point).unwrap();
            assert!((mark.on(outline.points()).unwrap() - point).norm() < 1e-9);
            assert!((mark.on(&moved).unwrap() - carry(&point)).norm() < 1e-9);
            assert!(mark.edge > 2 || mark.on(&moved[..mark.edge]).is_none());
        }

        #[test]
        fn one_fold_reaches_what_the_folded_outline_says(turn in 0.2..2.9_f64, at in 0.0..1.0_f64) {
            let (outline, _, _) = folded();
            let (s, c) = turn.sin_cos();
            let through = Point::new(20.0 + 3.0 * c, 10.0);
            let crease = [through - crate::Vector::new(c, s) * 60.0, through + crate::Vector::new(c, s) * 60.0];
            let point = outline.at(at * outline.length());
            let reached = reach(&outline, &[crease], &[point]).unwrap()[0];
            let once = fold(&outline, &crease).unwrap();
            let double = crate::model::Region::double_layer(&once);
            assert!((double.distance(&reached.place) - reached.to_double_layer).abs() < 1e-5);
        }
    }
}
