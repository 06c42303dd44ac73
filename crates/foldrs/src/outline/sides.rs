//! Simplification of an outline to its sides, the candidate creases (section 2.1).

use super::distance_to_segment;
use crate::{Outline, Point, Segment, Vector};

/// Points of a side through which its line is laid.
const SAMPLES: usize = 24;

/// Share of a side left out at either end, where corners are rounded.
const LEFT_OUT: f64 = 0.1;

/// A side of the simplified outline: a candidate crease (section 2.1).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Side {
    /// The side itself, in the direction of the outline.
    pub segment: Segment,
    /// Arc length of its two ends on the outline; the second is smaller where the side runs over the first vertex.
    /// Where it spans two sides in one line, as some of [`Seen::sides`](crate::Seen::sides) do, those of the longer one.
    pub arc: [f64; 2],
}

impl Outline {
    /// Vertices kept by Douglas-Peucker simplification: no vertex lies farther than `tolerance` from the result.
    ///
    /// A closed outline has no natural end to start from: two vertices that are (nearly) as far apart as any are
    /// always corners. Indices in increasing order.
    #[must_use]
    pub fn simplify(&self, tolerance: f64) -> Vec<usize> {
        let n = self.points.len();
        let (a, b) = self.farthest_vertices();
        let mut keep = vec![false; n];
        keep[a] = true;
        keep[b] = true;
        let mut open = vec![(a, b), (b, a + n)];
        while let Some((from, to)) = open.pop() {
            let chord = [self.points[from % n], self.points[to % n]];
            let worst = (from + 1..to)
                .map(|k| (k, distance_to_segment(&chord, &self.points[k % n])))
                .fold((from, tolerance), |best, x| if x.1 > best.1 { x } else { best });
            if worst.0 != from {
                keep[worst.0 % n] = true;
                open.extend([(from, worst.0), (worst.0, to)]);
            }
        }
        (0..n).filter(|&i| keep[i]).collect()
    }

    /// The sides of the simplified outline, in order: the candidate creases (section 2.1).
    ///
    /// Every side is the straight line through the points it stands for, which lies truer than the chord between
    /// two corners that rounding may have moved.
    #[must_use]
    pub fn sides(&self, tolerance: f64) -> Vec<Side> {
        let corners = self.simplify(tolerance);
        (0..corners.len())
            .map(|k| {
                let (i, j) = (corners[k], corners[(k + 1) % corners.len()]);
                let arc = [self.arc[i], self.arc[j]];
                Side {
                    segment: self.straightened(arc),
                    arc,
                }
            })
            .collect()
    }

    /// The least-squares line through a stretch of the outline, from the foot of its first point to that of its last.
    fn straightened(&self, arc: [f64; 2]) -> Segment {
        let span = (arc[1] - arc[0]).rem_euclid(self.length());
        let ends = [self.at(arc[0]), self.at(arc[1])];
        let used = 1.0 - 2.0 * LEFT_OUT;
        let points: Vec<Point> = (0..SAMPLES)
            .map(|k| self.at(arc[0] + span * (LEFT_OUT + used * k as f64 / (SAMPLES - 1) as f64)))
            .collect();
        let mean = points.iter().fold(Vector::zeros(), |s, p| s + p.coords) / SAMPLES as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for p in &points {
            let d = p.coords - mean;
            xx += d.x * d.x;
            xy += d.x * d.y;
            yy += d.y * d.y;
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let direction = Vector::new(angle.cos(), angle.sin());
        ends.map(|e| Point::from(mean + direction * direction.dot(&(e.coords - mean))))
    }

    /// Indices of two vertices that are (nearly) as far apart as any: the smaller first.
    fn farthest_vertices(&self) -> (usize, usize) {
        let farthest = |from: usize| {
            let d = |i: usize| (self.points[i] - self.points[from]).norm_squared();
            (0..self.points.len()).fold(from, |best, i| if d(i) > d(best) { i } else { best })
        };
        // Two hops from any vertex end at a diameter or close to it.
        let start = farthest(0);
        let end = farthest(start);
        (start.min(end), start.max(end))
    }
}
