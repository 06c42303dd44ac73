//! The union of kept part and flap by a walk, where there can be no doubt about it.
//!
//! The pieces of a part do not overlap, and every piece has a crease in common with one of the other part. So one walks
//! along a piece to where it runs into the other part, goes over to the boundary met there, and so on until one is
//! back. Every such walk is the outline or a hole, and there are no others: the creases hold all pieces together.
//!
//! Vertices upon edges, edges upon each other, outlines that cross themselves: whatever is not clear by a wide margin
//! is no case for this, but for the overlay library.

use super::grid::Grid;
use super::rings::Rings;
use super::stops::stops;
use super::walks::walks;
use super::Piece;
use crate::outline::signed_area;

/// What is nearer than so many steps of the grid is not clear: far more than the library may move anything, so where
/// there is no doubt its union has the same vertices.
const CLEAR: f64 = 64.0;

/// The most edges; the comparison of every edge with all groups of edges grows faster than the library's sweep.
const MOST_EDGES: usize = 1536;

/// Outline of the union of all pieces with the number of its holes, or nothing if anything about it is unclear.
///
/// The outline does not tell which way it was made: its vertices lie on the grid, and the second is that farthest left
/// (the last but one if it is not wound positively), as the library has it.
pub(super) fn unite(kept: &[Piece], flap: &[Piece], positive: bool, grid: &Grid) -> Option<(Piece, usize)> {
    let rings = Rings::new(kept, flap, positive)?;
    if rings.count() > MOST_EDGES {
        return None;
    }
    let clear = CLEAR * grid.step();
    let stops = stops(&rings, grid, positive, clear)?;
    let (mut outline, mut holes) = (None, 0);
    for piece in walks(&rings, &stops, clear)? {
        if (signed_area(&piece.points) > 0.0) != positive {
            holes += 1;
        } else if outline.replace(piece).is_some() {
            return None;
        }
    }
    let mut outline = outline?;
    let places: Vec<_> = outline.points.iter().map(|p| grid.snap(p)).collect();
    for (point, place) in outline.points.iter_mut().zip(&places) {
        *point = grid.back(place);
    }
    let (leftmost, _) = places.iter().enumerate().min_by_key(|(_, p)| (p.x, p.y))?;
    let first = (leftmost + if positive { places.len() - 1 } else { 2 }) % places.len();
    outline.points.rotate_left(first);
    outline.sources.rotate_left(first);
    Some((outline, holes))
}

#[cfg(test)]
mod tests;
