//! A template that can bend: its corners with a Gaussian prior on how far they move.

use crate::outline::Outline;
use crate::parameters::FitParameters;
use crate::registration::PlaneMap;
use crate::{Point, Vector};
use nalgebra::{DMatrix, DVector, Matrix2};

/// How far a corner may lie from its partner's mirror image to be held alike, as a share of the square root of the
/// template's area: a centimetre of a shirt, more than hands and tracing leave of a symmetric template.
const MIRRORED: f64 = 0.02;

/// How nearly two points of a template mirror each other over the axis that fits all its pairs best.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Mirroring {
    /// Distance of either point from the mirror image of the other, in the template's units.
    pub off: f64,
    /// Whether that is so little that the joint fit holds corners there alike.
    pub held: bool,
}

/// How nearly the pairs of a template's points that are meant to mirror each other do so; infinitely far off if they tell
/// no axis.
///
/// ```
/// use foldrs::{fit::mirrorings, Outline, Point};
/// let corners = [[0.0, 0.0], [40.0, 0.0], [50.0, 30.0], [-10.0, 30.0]];
/// let outline = Outline::try_from(&corners[..])?;
/// let [a, b, c, d] = corners.map(|[x, y]| Point::new(x, y));
/// assert!(mirrorings(&outline, &[[a, b], [c, d]]).iter().all(|pair| pair.held));
/// assert!(!mirrorings(&outline, &[[a, c], [b, d]]).iter().any(|pair| pair.held));
/// # Ok::<(), foldrs::OutlineError>(())
/// ```
#[must_use]
pub fn mirrorings(outline: &Outline, pairs: &[[Point; 2]]) -> Vec<Mirroring> {
    let (map, unit) = (mirror_map(pairs), outline.signed_area().abs().sqrt());
    let told = pairs.iter().map(|[a, b]| {
        let off = map
            .as_ref()
            .map_or(f64::INFINITY, |map| (map.apply(a) - b).norm());
        Mirroring {
            off,
            held: off <= MIRRORED * unit,
        }
    });
    told.collect()
}

/// A template's corners about their centre, and the precision of their displacements.
///
/// Three things are expected of a real garment, in the template's units: its corners lie near the template's; short
/// edges keep their length and direction better than long ones (so curved hems and collars move as one); and
/// its two halves differ less from each other than from the template, as do the other two halves of one that is its own
/// mirror image twice (a towel).
#[derive(Debug, Clone)]
pub struct FlexibleTemplate {
    /// Corners of the simplified template relative to [`FlexibleTemplate::centre`], wound positively.
    pub(super) corners: Vec<Vector>,
    /// For every vertex of the template where it lies on the simplified one.
    vertices: Vec<Vertex>,
    /// What the corners are relative to, in template coordinates.
    pub(super) centre: Point,
    /// For every mirror axis the pairs of corners that are mirror images of each other.
    pub(super) mirrors: Vec<Vec<(usize, usize)>>,
    /// Whether the corners run the other way round than the outline given.
    pub(super) reversed: bool,
    /// Enclosed area.
    pub(super) area: f64,
    /// Precision of every corner's own displacement: what its spread leaves of it, without its neighbours.
    alone: Vec<f64>,
    /// Precision of the displacements (x, y of the first corner, of the second, ...).
    pub(super) precision: DMatrix<f64>,
    /// Its logarithmic determinant.
    pub(super) log_det: f64,
}

impl FlexibleTemplate {
    /// Prepares a template. `mirror` holds pairs of points that are mirror images of each other (may be empty).
    #[must_use]
    pub fn new(outline: &Outline, mirror: &[[Point; 2]], parameters: &FitParameters) -> Self {
        let reversed = outline.signed_area() < 0.0;
        let outline = outline.clone().positive();
        let centre = outline.centroid();
        let unit = outline.signed_area().sqrt();
        // A traced outline has hundreds of vertices; what bends is its corners.
        let knots = outline.simplify(parameters.simplify * unit);
        let vertices = vertices(outline.points(), &knots);
        let points: Vec<Point> = knots.iter().map(|&k| outline.points()[k]).collect();
        let points = points.as_slice();
        let n = points.len();
        let mut precision = DMatrix::zeros(2 * n, 2 * n);

        let shape = (parameters.shape * unit).powi(-2);
        for k in 0..2 * n {
            precision[(k, k)] += shape;
        }
        for i in 0..n {
            let j = (i + 1) % n;
            let length = (points[j] - points[i]).norm();
            let spread = parameters.edge_floor * unit + parameters.edge * length;
            add_difference(&mut precision, i, j, &Matrix2::identity(), spread.powi(-2));
        }
        let asymmetry = (parameters.asymmetry * unit).powi(-2);
        let mut mirrors = Vec::new();
        if let Some(map) = mirror_map(mirror) {
            let tolerance = MIRRORED * unit;
            let pairs = mirror_vertices(points, &map, tolerance);
            add_mirrored(&mut precision, &pairs, &map, asymmetry);
            mirrors.push(pairs);
            // What is its own mirror image across this axis as well, a rectangle, keeps that too.
            let other = across(&map, &centre);
            let pairs = mirror_vertices(points, &other, tolerance);
            let paired: usize = pairs.iter().map(|(i, j)| if i == j { 1 } else { 2 }).sum();
            if paired == n {
                add_mirrored(&mut precision, &pairs, &other, asymmetry);
                mirrors.push(pairs);
            }
        }
        let mut mirrors: Vec<_> = mirrors.iter().map(|pairs| across_alike(pairs, points)).collect();
        mirrors.retain(|pairs| !pairs.is_empty());
        let log_det = log_determinant(&precision).unwrap_or(0.0);
        let corners = points.iter().map(|p| p - centre).collect();
        Self {
            corners,
            vertices,
            centre,
            mirrors,
            reversed,
            area: outline.signed_area(),
            alone: vec![shape; n],
            precision,
            log_det,
        }
    }

    /// What the corners are relative to: the centre of gravity of the outline given.
    #[must_use]
    pub fn centre(&self) -> Point {
        self.centre
    }

    /// The same template with a spread of its own for every corner, in the template's units, instead of the one of
    /// all corners ([`FitParameters::shape`]).
    ///
    /// `spread` holds one value a vertex of the outline given. `None` unless there are so many, all positive and finite.
    #[must_use]
    pub fn with_spread(mut self, spread: &[f64]) -> Option<Self> {
        let count = self.vertices.len();
        if spread.len() != count || !spread.iter().all(|s| s.is_finite() && *s > 0.0) {
            return None;
        }
        for (i, vertex) in self.vertices.iter().enumerate() {
            // Vertices between the corners move along with them.
            if vertex.along == 0.0 && vertex.across == 0.0 {
                let given = if self.reversed { (count - i) % count } else { i };
                let alone = spread[given].powi(-2);
                for k in [2 * vertex.edge, 2 * vertex.edge + 1] {
                    self.precision[(k, k)] += alone - self.alone[vertex.edge];
                }
                self.alone[vertex.edge] = alone;
            }
        }
        self.log_det = log_determinant(&self.precision)?;
        Some(self)
    }

    /// All vertices of the template when its corners are moved, in the order of the outline given.
    pub(super) fn bent(&self, corners: &[Point]) -> Vec<Point> {
        let mut bent: Vec<Point> = self
            .vertices
            .iter()
            .map(|v| {
                let (a, b) = (corners[v.edge], corners[(v.edge + 1) % corners.len()]);
                let along = b - a;
                a + along * v.along + Vector::new(-along.y, along.x) * v.across
            })
            .collect();
        if self.reversed {
            bent[1..].reverse();
        }
        bent
    }

    /// Minus log of the prior density of displacements, without its constant.
    pub(super) fn cost(&self, displacement: &DVector<f64>) -> f64 {
        0.5 * displacement.dot(&(&self.precision * displacement))
    }
}

/// A vertex relative to an edge of the simplified template, in shares of that edge's length.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    edge: usize,
    along: f64,
    across: f64,
}

/// Every vertex relative to the edge between the two knots around it.
fn vertices(points: &[Point], knots: &[usize]) -> Vec<Vertex> {
    let count = knots.len();
    (0..points.len())
        .map(|i| {
            let edge = (knots.partition_point(|&k| k <= i) + count - 1) % count;
            let (a, b) = (points[knots[edge]], points[knots[(edge + 1) % count]]);
            let (along, v) = (b - a, points[i] - a);
            let squared = along.norm_squared();
            Vertex {
                edge,
                along: along.dot(&v) / squared,
                across: along.perp(&v) / squared,
            }
        })
        .collect()
}

/// Adds `weight |d_j - M d_i|^2` to the quadratic form.
fn add_difference(precision: &mut DMatrix<f64>, i: usize, j: usize, m: &Matrix2<f64>, weight: f64) {
    add_form(precision, i, m, weight);
    add_form(precision, j, &Matrix2::identity(), weight);
    for r in 0..2 {
        for c in 0..2 {
            precision[(2 * j + r, 2 * i + c)] -= weight * m[(r, c)];
            precision[(2 * i + c, 2 * j + r)] -= weight * m[(r, c)];
        }
    }
}

/// Adds, with a weight, that pairs of corners move as mirror images of each other.
fn add_mirrored(precision: &mut DMatrix<f64>, pairs: &[(usize, usize)], mirror: &PlaneMap, weight: f64) {
    for &(i, j) in pairs {
        if i == j {
            // A corner on the mirror axis should stay there.
            let off = (Matrix2::identity() - mirror.linear) / 2.0;
            add_form(precision, i, &off, 2.0 * weight);
        } else {
            add_difference(precision, i, j, &mirror.linear, weight);
        }
    }
}

/// Adds `weight |M d_i|^2` to the quadratic form.
fn add_form(precision: &mut DMatrix<f64>, i: usize, m: &Matrix2<f64>, weight: f64) {
    let form = m.transpose() * m * weight;
    for r in 0..2 {
        for c in 0..2 {
            precision[(2 * i + r, 2 * i + c)] += form[(r, c)];
        }
    }
}

/// The reflection that best maps every point of the pairs onto its partner.
fn mirror_map(pairs: &[[Point; 2]]) -> Option<PlaneMap> {
    let flip = |p: &Point| Point::new(-p.x, p.y);
    let from: Vec<Point> = pairs.iter().flat_map(|[a, b]| [flip(a), flip(b)]).collect();
    let to: Vec<Point> = pairs.iter().flat_map(|[a, b]| [*b, *a]).collect();
    let mut map = PlaneMap::similarity(&from, &to, None)?;
    map.linear.column_mut(0).neg_mut();
    Some(map)
}

/// The reflection at right angles to another, over an axis through a point.
fn across(mirror: &PlaneMap, through: &Point) -> PlaneMap {
    let linear = -mirror.linear;
    PlaneMap {
        linear,
        offset: through.coords - linear * through.coords,
    }
}

/// Pairs of corners that the reflection maps onto each other; a corner on its axis is paired with itself.
fn mirror_vertices(points: &[Point], map: &PlaneMap, tolerance: f64) -> Vec<(usize, usize)> {
    let partner = |i: usize| {
        let image = map.apply(&points[i]);
        let distance = |j: usize| (points[j] - image).norm();
        let j = (0..points.len()).fold(0, |best, j| if distance(j) < distance(best) { j } else { best });
        (distance(j) <= tolerance).then_some(j)
    };
    (0..points.len())
        .filter_map(|i| partner(i).filter(|&j| i <= j).map(|j| (i, j)))
        .collect()
}

/// The pairs of two corners, each from the same side of the mirror axis to the other.
fn across_alike(pairs: &[(usize, usize)], points: &[Point]) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(usize, usize)> = pairs.iter().copied().filter(|(i, j)| i != j).collect();
    let across = |&(i, j): &(usize, usize)| points[j] - points[i];
    if let Some(first) = pairs.first().map(across) {
        for pair in &mut pairs {
            if across(pair).dot(&first) < 0.0 {
                *pair = (pair.1, pair.0);
            }
        }
    }
    pairs
}

/// Logarithmic determinant of a positive definite matrix.
pub(super) fn log_determinant(matrix: &DMatrix<f64>) -> Option<f64> {
    let factor = matrix.clone().cholesky()?;
    Some(2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trapezium() -> FlexibleTemplate {
        let p = [(-20.0, 0.0), (20.0, 0.0), (30.0, 50.0), (-30.0, 50.0)].map(|(x, y)| Point::new(x, y));
        let outline = Outline::new(p.to_vec()).unwrap();
        FlexibleTemplate::new(&outline, &[[p[0], p[1]], [p[3], p[2]]], &FitParameters::default())
    }

    #[test]
    fn one_sided_changes_cost_more_than_mirrored_ones() {
        let template = trapezium();
        let wider = DVector::from_vec(vec![-2.0, 0.0, 2.0, 0.0, 2.0, 0.0, -2.0, 0.0]);
        let skewed = DVector::from_vec(vec![2.0, 0.0, 2.0, 0.0, -2.0, 0.0, -2.0, 0.0]);
        assert!(template.cost(&wider) < template.cost(&skewed));
        assert_eq!(template.cost(&DVector::zeros(8)), 0.0);
    }

    #[test]
    fn what_is_symmetric_twice_keeps_both() {
        let template = |top: f64| {
            let p = [(-20.0, 0.0), (20.0, 0.0), (top, 50.0), (-top, 50.0)].map(|(x, y)| Point::new(x, y));
            let outline = Outline::new(p.to_vec()).unwrap();
            FlexibleTemplate::new(&outline, &[[p[0], p[1]], [p[3], p[2]]], &FitParameters::default())
        };
        // Mirrored changes: of a side's both ends alike, and of one of them alone, of the same length in all.
        let stretched = DVector::from_vec(vec![-2.0, 0.0, 2.0, 0.0, 2.0, 0.0, -2.0, 0.0]);
        let slanted = DVector::from_vec(vec![-2.0, 0.0, 2.0, 0.0, -2.0, 0.0, 2.0, 0.0]);
        let more = |top: f64| {
            let template = template(top);
            template.cost(&slanted) - template.cost(&stretched)
        };
        // A rectangle would rather stay one; a trapezium, of all but the same size, has nothing to keep.
        assert!(more(20.0) > 2.0 * more(22.0), "{} {}", more(20.0), more(22.0));
        assert!(template(20.0).cost(&stretched) < 1.1 * template(22.0).cost(&stretched));
    }

    #[test]
    fn a_corner_of_larger_spread_moves_for_less() {
        let parameters = FitParameters::default();
        let moved = |corner: usize| {
            let mut d = DVector::zeros(8);
            d[2 * corner] = 3.0;
            d
        };
        let usual = parameters.shape * trapezium().area.sqrt();
        let same = trapezium().with_spread(&[usual; 4]).unwrap();
        assert!((same.cost(&moved(0)) - trapezium().cost(&moved(0))).abs() < 1e-9);
        assert!((same.log_det - trapezium().log_det).abs() < 1e-9);
        let loose = trapezium()
            .with_spread(&[4.0 * usual, usual, usual, usual])
            .unwrap();
        assert!(loose.cost(&moved(0)) < trapezium().cost(&moved(0)));
        assert!((loose.cost(&moved(1)) - trapezium().cost(&moved(1))).abs() < 1e-9);
        // The last one given counts, alone.
        let back = loose.with_spread(&[usual; 4]).unwrap();
        assert!((back.precision - trapezium().precision).norm() < 1e-9);
    }

    #[test]
    fn spreads_follow_their_vertices_whichever_way_round() {
        let parameters = FitParameters::default();
        let p = [(-20.0, 0.0), (20.0, 0.0), (30.0, 50.0), (-30.0, 50.0)].map(|(x, y)| Point::new(x, y));
        let spread = [1.0, 2.0, 4.0, 8.0];
        let one = FlexibleTemplate::new(&Outline::new(p.to_vec()).unwrap(), &[], &parameters);
        let other = [0, 3, 2, 1];
        let turned = Outline::new(other.map(|k| p[k]).to_vec()).unwrap();
        let turned = FlexibleTemplate::new(&turned, &[], &parameters);
        let one = one.with_spread(&spread).unwrap();
        let turned = turned.with_spread(&other.map(|k| spread[k])).unwrap();
        assert!((one.precision - turned.precision).norm() < 1e-9);
    }

    #[test]
    fn spreads_that_cannot_be_are_refused() {
        assert!(trapezium().with_spread(&[1.0; 3]).is_none());
        assert!(trapezium().with_spread(&[1.0, 1.0, 0.0, 1.0]).is_none());
    }

    proptest::proptest! {
        #[test]
        fn every_displacement_costs_something(d in proptest::collection::vec(-30.0..30.0_f64, 8)) {
            let (template, d) = (trapezium(), DVector::from_vec(d));
            let cost = template.cost(&d);
            // No corner leaves its place for less than its own spread allows.
            let spread = FitParameters::default().shape * template.area.sqrt();
            assert!(cost >= 0.5 * d.norm_squared() / (spread * spread) * (1.0 - 1e-9));
            assert!((template.cost(&(&d * 2.0)) - 4.0 * cost).abs() <= 1e-9 * cost);
        }
    }
}
