//! The seen outline as the fit looks at it: sample points, and a signed distance field.

use crate::outline::{distance_to_segment, Outline};
use crate::{Point, Vector};

/// The seen outline, prepared once for all candidates. Wound positively, in the fit's working units: those of the
/// templates, as far as the scale is known.
#[derive(Debug, Clone)]
pub struct SeenField {
    /// Points at equal distances, with the direction of the outline there.
    pub(super) samples: Vec<(Point, Vector)>,
    /// Distance between two samples.
    pub(super) spacing: f64,
    /// Enclosed area.
    pub(super) area: f64,
    grid: Grid,
}

/// Signed distances from the outline at the nodes of a grid.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// The first node.
    pub(super) low: Point,
    /// Distance of two nodes.
    pub(super) cell: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// The distances, row by row; positive outside.
    pub(super) distance: Vec<f64>,
}

impl Grid {
    /// Where a node lies.
    pub(super) fn node(&self, k: usize) -> Point {
        self.low + Vector::new((k % self.columns) as f64, (k / self.columns) as f64) * self.cell
    }
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
            grid: Grid {
                low,
                cell,
                columns,
                rows,
                distance,
            },
        }
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The grid's nodes that lie at least `depth` within the outline, with their indices.
    pub(super) fn nodes_within(&self, depth: f64) -> impl Iterator<Item = (usize, Point)> + '_ {
        let nodes = self.grid.distance.iter().enumerate();
        nodes
            .filter(move |(_, d)| **d < -depth)
            .map(|(k, _)| (k, self.grid.node(k)))
    }

    /// Distance from the outline, positive outside, and its gradient; far off the grid it grows on.
    #[inline]
    pub(super) fn at(&self, p: &Point) -> (f64, Vector) {
        let grid = &self.grid;
        let g = (p - grid.low) / grid.cell;
        let x = g.x.clamp(0.0, (grid.columns - 1) as f64 - 1e-9);
        let y = g.y.clamp(0.0, (grid.rows - 1) as f64 - 1e-9);
        let (i, j) = (x as usize, y as usize);
        let (u, v) = (x - i as f64, y - j as f64);
        let k = j * grid.columns + i;
        let (a, b) = (grid.distance[k], grid.distance[k + 1]);
        let (c, d) = (
            grid.distance[k + grid.columns],
            grid.distance[k + grid.columns + 1],
        );
        let value = (a * (1.0 - u) + b * u) * (1.0 - v) + (c * (1.0 - u) + d * u) * v;
        let gradient = Vector::new(
            (b - a) * (1.0 - v) + (d - c) * v,
            (c - a) * (1.0 - u) + (d - b) * u,
        ) / grid.cell;
        let beyond = Vector::new(g.x - x, g.y - y) * grid.cell;
        let far = beyond.norm();
        if far > 1e-6 * grid.cell {
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
