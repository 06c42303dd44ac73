//! The polygon model of a folded garment: where its layers lie over each other (section 3.2).

use crate::fold::{Folded, Piece};
use crate::outline::{distance_to_segment, even_odd};
use crate::{Outline, Point, Segment};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;

/// A region of the plane: rings under the even-odd rule, holes among them.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Region {
    /// The rings, closed implicitly.
    pub rings: Vec<Vec<Point>>,
}

impl Region {
    /// Where two layers of a folded outline lie over each other.
    #[must_use]
    pub fn double_layer(folded: &Folded) -> Self {
        overlay(&rings(&folded.kept), &rings(&folded.flap), OverlayRule::Intersect)
    }

    /// What any of some rings covers.
    #[must_use]
    pub fn union(rings: &[Vec<Point>]) -> Self {
        // One by one: rings that run opposite ways would cancel out where they overlap.
        let mut covered = Self::default();
        for one in rings {
            covered = overlay(&covered.plain(), &vec![ring(one)], OverlayRule::Union);
        }
        covered
    }

    /// What two or more of some rings cover.
    #[must_use]
    pub fn doubled(rings: &[Vec<Point>]) -> Self {
        let (mut covered, mut doubled) = (Vec::new(), Vec::new());
        for one in rings {
            let one = vec![ring(one)];
            let again = overlay(&covered, &one, OverlayRule::Intersect).plain();
            doubled = overlay(&doubled, &again, OverlayRule::Union).plain();
            covered = overlay(&covered, &one, OverlayRule::Union).plain();
        }
        overlay(&doubled, &Vec::new(), OverlayRule::Union)
    }

    /// The ring that encloses most, if there is one.
    #[must_use]
    pub fn largest(&self) -> Option<Vec<Point>> {
        let area = |r: &Vec<Point>| crate::outline::signed_area(r).abs();
        self.rings
            .iter()
            .max_by(|a, b| area(a).total_cmp(&area(b)))
            .cloned()
    }

    fn plain(&self) -> Vec<Vec<[f64; 2]>> {
        self.rings.iter().map(|r| ring(r)).collect()
    }

    /// Area of the region.
    #[must_use]
    pub fn area(&self) -> f64 {
        // Holes run the other way round than what encloses them.
        self.rings
            .iter()
            .map(|r| crate::outline::signed_area(r))
            .sum::<f64>()
            .abs()
    }

    /// Distance of a point from the region; 0 within it, infinite if the region is empty.
    #[must_use]
    pub fn distance(&self, q: &Point) -> f64 {
        let around = self.rings.iter().filter(|r| even_odd(r, q)).count();
        if around % 2 == 1 {
            return 0.0;
        }
        let edges = self
            .rings
            .iter()
            .flat_map(|r| (0..r.len()).map(|i| [r[i], r[(i + 1) % r.len()]]));
        edges
            .map(|e| distance_to_segment(&e, q))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Share of the union of two outlines that both cover: 1 for equal ones, 0 for disjoint ones.
///
/// Areas are taken on a grid of up to 2^30 steps over the extent of both; where neither has an area on it, only equal
/// outlines have anything in common.
#[must_use]
pub fn intersection_over_union(a: &Outline, b: &Outline) -> f64 {
    let rings = [a, b].map(|outline| vec![ring(outline.points())]);
    let union = overlay(&rings[0], &rings[1], OverlayRule::Union).area();
    if union == 0.0 {
        return if a == b { 1.0 } else { 0.0 };
    }
    overlay(&rings[0], &rings[1], OverlayRule::Intersect).area() / union
}

/// Area between two axes: of the convex hull of their four end points (the paper's measure dA times the area).
#[must_use]
pub fn axis_difference(a: &Segment, b: &Segment) -> f64 {
    // The hull of four points is the largest of the triangles and quadrilaterals they form.
    let [p, q, r, s] = [a[0], a[1], b[0], b[1]];
    let orders = [[p, q, r, s], [p, r, q, s], [p, q, s, r]];
    let quads = orders.iter().map(|o| crate::outline::signed_area(o).abs());
    let triples = [[p, q, r], [p, q, s], [p, r, s], [q, r, s]];
    let triangles = triples.iter().map(|t| crate::outline::signed_area(t).abs());
    quads.chain(triangles).fold(0.0, f64::max)
}

fn rings(pieces: &[Piece]) -> Vec<Vec<[f64; 2]>> {
    pieces.iter().map(|p| ring(&p.points)).collect()
}

fn ring(points: &[Point]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p.x, p.y]).collect()
}

fn overlay(a: &Vec<Vec<[f64; 2]>>, b: &Vec<Vec<[f64; 2]>>, rule: OverlayRule) -> Region {
    let shapes = a.overlay(b, rule, FillRule::NonZero);
    let point = |p: &[f64; 2]| Point::new(p[0], p[1]);
    Region {
        rings: shapes
            .iter()
            .flatten()
            .map(|ring| ring.iter().map(point).collect())
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64) -> Outline {
        let corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)];
        Outline::new(corners.iter().map(|(a, b)| Point::new(x + a, *b)).collect()).unwrap()
    }

    #[test]
    fn half_overlapping_squares_share_a_third() {
        assert!((intersection_over_union(&square(0.0, 2.0), &square(1.0, 2.0)) - 1.0 / 3.0).abs() < 1e-6);
        assert!(intersection_over_union(&square(0.0, 2.0), &square(5.0, 2.0)).abs() < 1e-6);
    }

    #[test]
    fn outlines_too_small_for_the_grid_are_equal_or_have_nothing_in_common() {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1e-10), (0.0, 1e-10)];
        let sliver = Outline::new(corners.map(|(x, y)| Point::new(x, y)).to_vec()).unwrap();
        assert_eq!(intersection_over_union(&sliver, &sliver), 1.0);
        assert_eq!(intersection_over_union(&sliver, &square(0.0, 1.0)), 0.0);
        assert_eq!(
            intersection_over_union(&square(0.0, 1.0), &square(1e10, 1.0)),
            0.0
        );
    }

    #[test]
    fn a_hole_is_no_part_of_a_region() {
        let rings = [square(0.0, 4.0), square(1.0, 2.0)].map(|o| o.points().to_vec());
        let mut holed = Region {
            rings: rings.to_vec(),
        };
        assert_eq!(holed.distance(&Point::new(0.5, 1.0)), 0.0);
        assert_eq!(holed.distance(&Point::new(2.0, 1.0)), 1.0);
        assert_eq!(holed.distance(&Point::new(6.0, 1.0)), 2.0);
        holed.rings.clear();
        assert_eq!(holed.distance(&Point::origin()), f64::INFINITY);
    }

    #[test]
    fn the_double_layer_of_a_square_folded_off_centre_is_the_flap() {
        let folded = crate::fold(&square(0.0, 2.0), &[Point::new(0.0, 1.5), Point::new(2.0, 1.5)]).unwrap();
        let double = Region::double_layer(&folded);
        assert!((double.area() - 1.0).abs() < 1e-6);
        assert_eq!(double.distance(&Point::new(1.0, 1.2)), 0.0);
        assert!((double.distance(&Point::new(1.0, 0.0)) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_difference_of_parallel_axes_is_the_area_between_them() {
        let axis = |y: f64| [Point::new(0.0, y), Point::new(4.0, y)];
        assert!((axis_difference(&axis(0.0), &axis(1.5)) - 6.0).abs() < 1e-12);
        let turned = [Point::new(4.0, 1.5), Point::new(0.0, 1.5)];
        assert!((axis_difference(&axis(0.0), &turned) - 6.0).abs() < 1e-12);
        assert_eq!(axis_difference(&axis(0.0), &axis(0.0)), 0.0);
    }
}
