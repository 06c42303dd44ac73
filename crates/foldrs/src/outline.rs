//! Outlines: closed polygons, their arc length and resampling; [`Outline::sides`] simplifies them (section 2.1).

mod sides;

pub use sides::Side;

use crate::{OutlineError, Point, Segment};

/// Coordinates may be no larger, and an outline no shorter than the reciprocal: products of four lengths, the most
/// that any stage forms, are then numbers with all their digits, whatever the unit.
const LARGEST: f64 = 1e50;

/// A closed polygon without its first point repeated, with the arc length of every vertex.
///
/// The winding is kept as given. Units are those of the points.
///
/// ```
/// use foldrs::{Outline, Point};
/// let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Point::new(x, y));
/// let outline = Outline::new(square.to_vec())?;
/// assert_eq!(outline.length(), 8.0);
/// assert_eq!(outline.resample(8)[1], Point::new(1.0, 0.0));
/// # Ok::<(), foldrs::OutlineError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<Point>", into = "Vec<Point>"))]
pub struct Outline {
    points: Vec<Point>,
    /// Arc length from the first vertex to every vertex, and back to the first: `points.len() + 1` values.
    arc: Vec<f64>,
}

impl TryFrom<Vec<Point>> for Outline {
    type Error = OutlineError;

    fn try_from(points: Vec<Point>) -> Result<Self, OutlineError> {
        Self::new(points)
    }
}

impl TryFrom<&[[f64; 2]]> for Outline {
    type Error = OutlineError;

    fn try_from(corners: &[[f64; 2]]) -> Result<Self, OutlineError> {
        Self::new(corners.iter().map(|&[x, y]| Point::new(x, y)).collect())
    }
}

impl From<Outline> for Vec<Point> {
    fn from(outline: Outline) -> Self {
        outline.points
    }
}

/// The nearest point of an outline to some other point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Nearest {
    /// The point on the outline.
    pub point: Point,
    /// Its distance.
    pub distance: f64,
    /// Its arc length from the first vertex.
    pub arc: f64,
}

impl Outline {
    /// An outline of at least three finite points that enclose an area.
    ///
    /// Repeated neighbours are dropped. Crossing edges are not looked for: see [`Outline::check_simple`].
    ///
    /// # Errors
    /// [`OutlineError::TooFewPoints`], [`OutlineError::NotFinite`], [`OutlineError::OutOfRange`] or
    /// [`OutlineError::NoArea`].
    pub fn new(mut points: Vec<Point>) -> Result<Self, OutlineError> {
        if let Some(i) = points.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
            return Err(OutlineError::NotFinite(i));
        }
        let farthest = points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        if farthest > LARGEST {
            return Err(OutlineError::OutOfRange(farthest));
        }
        points.dedup();
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            return Err(OutlineError::TooFewPoints(points.len()));
        }
        let arc = arc_lengths(&points);
        let outline = Self { points, arc };
        let extent = outline.length();
        if extent < 1.0 / LARGEST {
            return Err(OutlineError::OutOfRange(extent));
        }
        // Below this the area is rounding noise of the coordinates.
        if outline.signed_area().abs() <= 1e-12 * extent * extent {
            return Err(OutlineError::NoArea);
        }
        Ok(outline)
    }

    /// Checks that no two edges cross or touch except neighbours at their common vertex.
    ///
    /// # Errors
    /// [`OutlineError::Crossing`] with the indices of the first two edges that meet.
    pub fn check_simple(&self) -> Result<(), OutlineError> {
        let n = self.points.len();
        for i in 0..n {
            for j in i + 1..n {
                let neighbours = j == i + 1 || (i == 0 && j == n - 1);
                if !neighbours && segments_meet(self.edge(i), self.edge(j)) {
                    return Err(OutlineError::Crossing(i, j));
                }
            }
        }
        // Neighbours share a vertex; they cross only by running back over each other.
        for i in 0..n {
            let ([a, b], [_, c]) = (self.edge(i), self.edge((i + 1) % n));
            if orientation(&a, &b, &c) == 0.0 && (a - b).dot(&(c - b)) > 0.0 {
                return Err(OutlineError::Crossing(i, (i + 1) % n));
            }
        }
        Ok(())
    }

    /// The vertices.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Arc length from the first vertex to vertex `i`.
    #[must_use]
    pub fn arc_of_vertex(&self, i: usize) -> f64 {
        self.arc[i]
    }

    /// Edge `i`, from vertex `i` to the next.
    #[must_use]
    pub fn edge(&self, i: usize) -> Segment {
        [self.points[i], self.points[(i + 1) % self.points.len()]]
    }

    /// Length of the whole outline.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.arc[self.points.len()]
    }

    /// Enclosed area, positive if the points run from the x axis towards the y axis.
    #[must_use]
    pub fn signed_area(&self) -> f64 {
        signed_area(&self.points)
    }

    /// Centre of gravity of the enclosed area.
    #[must_use]
    pub fn centroid(&self) -> Point {
        let o = self.points[0];
        let (mut sum, mut area) = (nalgebra::Vector2::zeros(), 0.0);
        for i in 0..self.points.len() {
            let [a, b] = self.edge(i);
            let (u, v) = (a - o, b - o);
            let w = u.perp(&v);
            sum += (u + v) * w;
            area += w;
        }
        o + sum / (3.0 * area)
    }

    /// The same outline run the other way round, starting at the same vertex.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut points = self.points.clone();
        points[1..].reverse();
        Self {
            arc: arc_lengths(&points),
            points,
        }
    }

    /// The same outline, reversed if need be so that its signed area is positive.
    #[must_use]
    pub fn positive(self) -> Self {
        if self.signed_area() < 0.0 {
            self.reversed()
        } else {
            self
        }
    }

    /// The mirror image over the y axis, winding kept: what is seen when the garment lies on its other face.
    ///
    /// Point `i` of the result is the image of point `-i` (modulo the number of points) of this outline.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut points: Vec<Point> = self.points.iter().map(|p| Point::new(-p.x, p.y)).collect();
        points[1..].reverse();
        Self {
            arc: arc_lengths(&points),
            points,
        }
    }

    /// The point at arc length `s`, which is taken modulo the length.
    #[must_use]
    pub fn at(&self, s: f64) -> Point {
        let s = s.rem_euclid(self.length());
        let i = (self.arc.partition_point(|&a| a <= s).max(1) - 1).min(self.points.len() - 1);
        let [a, b] = self.edge(i);
        let span = self.arc[i + 1] - self.arc[i];
        a + (b - a) * ((s - self.arc[i]) / span)
    }

    /// `n` points at equal arc length, the first at the first vertex.
    #[must_use]
    pub fn resample(&self, n: usize) -> Vec<Point> {
        let step = self.length() / n as f64;
        let mut edge = 0;
        (0..n)
            .map(|k| {
                let s = k as f64 * step;
                while edge + 1 < self.points.len() && self.arc[edge + 1] <= s {
                    edge += 1;
                }
                let [a, b] = self.edge(edge);
                a + (b - a) * ((s - self.arc[edge]) / (self.arc[edge + 1] - self.arc[edge]))
            })
            .collect()
    }

    /// The point of the outline nearest to `q`.
    #[must_use]
    pub fn nearest(&self, q: &Point) -> Nearest {
        let (edge, share, distance) = nearest_edge(&self.points, q);
        let [a, b] = self.edge(edge);
        Nearest {
            point: a + (b - a) * share,
            distance,
            arc: self.arc[edge] + share * (self.arc[edge + 1] - self.arc[edge]),
        }
    }

    /// Whether `q` lies inside (even-odd rule; on the outline itself either answer may come).
    #[must_use]
    pub fn contains(&self, q: &Point) -> bool {
        even_odd(&self.points, q)
    }
}

/// Whether a point lies inside a closed ring by the even-odd rule.
pub(crate) fn even_odd(ring: &[Point], q: &Point) -> bool {
    let mut inside = false;
    for (i, a) in ring.iter().enumerate() {
        let b = &ring[(i + 1) % ring.len()];
        if (a.y > q.y) != (b.y > q.y) {
            inside ^= (orientation(a, b, q) > 0.0) == (b.y > a.y);
        }
    }
    inside
}

/// Whether a closed ring winds around a point. Where the ring overlaps itself there is cloth, unlike by the even-odd rule.
pub(crate) fn encloses(ring: &[Point], q: &Point) -> bool {
    let mut winding = 0;
    for (k, b) in ring.iter().enumerate() {
        let a = &ring[(k + ring.len() - 1) % ring.len()];
        if (a.y > q.y) != (b.y > q.y) && (orientation(a, b, q) > 0.0) == (b.y > a.y) {
            winding += if b.y > a.y { 1 } else { -1 };
        }
    }
    winding != 0
}

/// Arc length from the first point to every point and back to the first.
fn arc_lengths(points: &[Point]) -> Vec<f64> {
    let mut arc = Vec::with_capacity(points.len() + 1);
    let mut s = 0.0;
    arc.push(s);
    for i in 0..points.len() {
        s += (points[(i + 1) % points.len()] - points[i]).norm();
        arc.push(s);
    }
    arc
}

/// Area enclosed by a closed ring, positive if it runs from the x axis towards the y axis.
#[must_use]
pub fn signed_area(ring: &[Point]) -> f64 {
    let Some(&o) = ring.first() else { return 0.0 };
    (1..ring.len().saturating_sub(1))
        .map(|i| (ring[i] - o).perp(&(ring[i + 1] - o)))
        .sum::<f64>()
        / 2.0
}

/// Sign of the turn a, b, c, exact for any coordinates: positive to the left in a y-up frame.
pub(crate) fn orientation(a: &Point, b: &Point, c: &Point) -> f64 {
    let coord = |p: &Point| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Position of the foot of `q` on the segment's line: 0 at its first point, 1 at its second.
pub(crate) fn foot(segment: &Segment, q: &Point) -> f64 {
    let d = segment[1] - segment[0];
    let n = d.norm_squared();
    if n > 0.0 {
        (q - segment[0]).dot(&d) / n
    } else {
        0.0
    }
}

/// The edge of a closed polygon nearest to `q`, where on it as a share of its length, and how far off that is; infinitely
/// far without corners.
pub(crate) fn nearest_edge(corners: &[Point], q: &Point) -> (usize, f64, f64) {
    let mut best = (0, 0.0, f64::INFINITY);
    for (edge, a) in corners.iter().enumerate() {
        let b = corners[(edge + 1) % corners.len()];
        let share = foot(&[*a, b], q).clamp(0.0, 1.0);
        let distance = (q - (a + (b - a) * share)).norm();
        if distance < best.2 {
            best = (edge, share, distance);
        }
    }
    best
}

pub(crate) fn distance_to_segment(segment: &Segment, q: &Point) -> f64 {
    let t = foot(segment, q).clamp(0.0, 1.0);
    (q - (segment[0] + (segment[1] - segment[0]) * t)).norm()
}

/// Whether two closed segments have a point in common (exact).
fn segments_meet([a, b]: Segment, [c, d]: Segment) -> bool {
    let within = |p: &Point, [u, v]: [&Point; 2]| {
        p.x >= u.x.min(v.x) && p.x <= u.x.max(v.x) && p.y >= u.y.min(v.y) && p.y <= u.y.max(v.y)
    };
    let (c1, c2) = (orientation(&a, &b, &c), orientation(&a, &b, &d));
    let (d1, d2) = (orientation(&c, &d, &a), orientation(&c, &d, &b));
    if c1 * c2 < 0.0 && d1 * d2 < 0.0 {
        return true;
    }
    (c1 == 0.0 && within(&c, [&a, &b]))
        || (c2 == 0.0 && within(&d, [&a, &b]))
        || (d1 == 0.0 && within(&a, [&c, &d]))
        || (d2 == 0.0 && within(&b, [&c, &d]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cloth_is_where_a_ring_overlaps_itself_whichever_way_it_runs() {
        // A strip that turns back over itself: it winds around (4, 1) twice, around (8, 1) once.
        let strip = [
            (0.0, 0.0),
            (10.0, 0.0),
            (10.0, 2.0),
            (3.0, 2.0),
            (3.0, 0.0),
            (6.0, 0.0),
            (6.0, 2.0),
            (0.0, 2.0),
        ];
        let mut ring = strip.map(|(x, y)| Point::new(x, y)).to_vec();
        for _ in 0..2 {
            assert!(encloses(&ring, &Point::new(4.0, 1.0)));
            assert!(encloses(&ring, &Point::new(8.0, 1.0)));
            assert!(!encloses(&ring, &Point::new(11.0, 1.0)));
            assert!(!encloses(&ring, &Point::new(4.0, 3.0)));
            ring.reverse();
        }
    }
}
