//! The seen outline as the fit looks at it: sample points, and a signed distance field.

use crate::outline::{distance_to_segment, Outline};
use crate::{Point, Vector};

/// The seen outline, prepared once for all candidates. Wound positively, in the fit's working units.
#[derive(Debug, Clone)]
pub struct SeenField {
    /// Points at equal distances, with the direction of the outline there.
    pub(super) samples: Vec<(Point, Vector)>,
    /// Distance between two samples.
    pub(super) spacing: f64,
    /// Enclosed area.
    pub(super) area: f64,
    low: Point,
    cell: f64,
    columns: usize,
    rows: usize,
    /// Signed distances at the grid's nodes, row by row; positive outside.
    distance: Vec<f64>,
}

impl SeenField {
    /// Samples the outline at `n` points and its signed distance on a grid of about `nodes` x `nodes`.
    #[must_use]
    pub fn new(outline: &Outline, n: usize, nodes: usize) -> Self {
        let (mut low, mut high) = (outline.points()[0], outline.points()[0]);
        for p in outline.points() {
            low = low.inf(p);
            high = high.sup(p);
        }
        let extent = (high - low).max();
        let margin = 0.25 * extent;
        let cell = (extent + 2.0 * margin) / nodes as f64;
        let low = low - Vector::repeat(margin);
        let size = |k: usize| (((high - low)[k] + margin) / cell).ceil() as usize + 1;
        let (columns, rows) = (size(0), size(1));
        // Half a cell is as fine as the grid can tell: a coarser outline has the same distances.
        let coarse = outline.simplify(0.25 * cell);
        let ring: Vec<Point> = coarse.iter().map(|&i| outline.points()[i]).collect();
        let coarse = Outline::new(ring).unwrap_or_else(|_| outline.clone());
        let distance = distances(&coarse, low, cell, columns, rows);
        Self {
            samples: super::samples(outline, n),
            spacing: outline.length() / n as f64,
            area: outline.signed_area().abs(),
            low,
            cell,
            columns,
            rows,
            distance,
        }
    }

    /// The grid's nodes that lie at least `depth` within the outline.
    pub(super) fn nodes_within(&self, depth: f64) -> impl Iterator<Item = Point> + '_ {
        self.distance
            .iter()
            .enumerate()
            .filter(move |(_, d)| **d < -depth)
            .map(|(k, _)| {
                let node = Vector::new((k % self.columns) as f64, (k / self.columns) as f64);
                self.low + node * self.cell
            })
    }

    /// Distance of a point outside the outline and its gradient; `None` within.
    pub(super) fn outside(&self, p: &Point) -> Option<(f64, Vector)> {
        let (out, gradient) = self.at(p);
        (out > 0.0).then_some((out, gradient))
    }

    /// Distance from the outline, positive outside, and its gradient; far off the grid it grows on.
    #[inline]
    pub(super) fn at(&self, p: &Point) -> (f64, Vector) {
        let g = (p - self.low) / self.cell;
        let x = g.x.clamp(0.0, (self.columns - 1) as f64 - 1e-9);
        let y = g.y.clamp(0.0, (self.rows - 1) as f64 - 1e-9);
        let (i, j) = (x as usize, y as usize);
        let (u, v) = (x - i as f64, y - j as f64);
        let k = j * self.columns + i;
        let (a, b) = (self.distance[k], self.distance[k + 1]);
        let (c, d) = (
            self.distance[k + self.columns],
            self.distance[k + self.columns + 1],
        );
        let value = (a * (1.0 - u) + b * u) * (1.0 - v) + (c * (1.0 - u) + d * u) * v;
        let gradient = Vector::new(
            (b - a) * (1.0 - v) + (d - c) * v,
            (c - a) * (1.0 - u) + (d - b) * u,
        ) / self.cell;
        let beyond = Vector::new(g.x - x, g.y - y) * self.cell;
        let far = beyond.norm();
        if far > 1e-6 * self.cell {
            (value + far, beyond / far)
        } else {
            (value, gradient)
        }
    }
}

fn distances(outline: &Outline, low: Point, cell: f64, columns: usize, rows: usize) -> Vec<f64> {
    let edges: Vec<_> = (0..outline.points().len()).map(|i| outline.edge(i)).collect();
    let mut distance = Vec::with_capacity(columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let q = low + Vector::new(i as f64, j as f64) * cell;
            let d = edges
                .iter()
                .map(|e| distance_to_segment(e, &q))
                .fold(f64::INFINITY, f64::min);
            distance.push(if outline.contains(&q) { -d } else { d });
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_a_square_are_signed_and_continue_off_the_grid() {
        let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
        let square = Outline::new(corners.iter().map(|c| Point::new(c.0, c.1)).collect()).unwrap();
        let field = SeenField::new(&square, 40, 64);
        assert!((field.at(&Point::new(5.0, 2.0)).0 + 2.0).abs() < 0.3);
        let (d, g) = field.at(&Point::new(12.0, 5.0));
        assert!((d - 2.0).abs() < 0.1 && (g - Vector::x()).norm() < 0.1);
        assert!((field.at(&Point::new(40.0, 5.0)).0 - 30.0).abs() < 0.5);
    }
}
