//! The pieces of kept part and flap as one list of edges, joined where they share a crease.

use super::{Layer, Piece, Source};
use crate::outline::signed_area;
use crate::{Point, Segment, Vector};
use std::ops::Range;

/// The edges of the kept pieces, then those of the flap's; each is told by the number of its first vertex.
pub(super) struct Rings {
    pub(super) points: Vec<Point>,
    pub(super) sources: Vec<Source>,
    /// For every edge the one after it in its piece.
    pub(super) after: Vec<usize>,
    /// The same place for the vertices of both pieces at the end of a crease, else different for all.
    place: Vec<usize>,
    /// The edges of every piece.
    pieces: Vec<Range<usize>>,
    first_of_flap: usize,
    /// The creases: the kept piece's edge and the flap's.
    pub(super) creases: Vec<[usize; 2]>,
}

impl Rings {
    /// Every piece must be wound as told, and every crease be an edge of one kept piece and of one of the flap.
    pub(super) fn new(kept: &[Piece], flap: &[Piece], positive: bool) -> Option<Self> {
        let count = kept.iter().chain(flap).map(|p| p.points.len()).sum();
        let mut rings = Self {
            points: Vec::with_capacity(count),
            sources: Vec::with_capacity(count),
            after: Vec::with_capacity(count),
            place: (0..count).collect(),
            pieces: Vec::with_capacity(kept.len() + flap.len()),
            first_of_flap: kept.iter().map(|p| p.points.len()).sum(),
            creases: Vec::with_capacity(4),
        };
        for piece in kept.iter().chain(flap) {
            let area = signed_area(&piece.points);
            if area == 0.0 || (area > 0.0) != positive {
                return None;
            }
            let start = rings.points.len();
            rings.points.extend_from_slice(&piece.points);
            rings.sources.extend_from_slice(&piece.sources);
            let end = rings.points.len();
            rings.after.extend(start + 1..end);
            rings.after.push(start);
            rings.pieces.push(start..end);
        }
        rings.join()?;
        Some(rings)
    }

    /// Lets the flap's creases end where the kept pieces' do: having been turned, they do only up to rounding.
    fn join(&mut self) -> Option<()> {
        let is_crease = |&e: &usize| self.sources[e].layer == Layer::Crease;
        let kept = (0..self.first_of_flap).filter(is_crease);
        let flap = (self.first_of_flap..self.points.len()).filter(is_crease);
        let (kept, flap): (Vec<_>, Vec<_>) = (kept.collect(), flap.collect());
        if kept.len() != flap.len() {
            return None;
        }
        for k in kept {
            let &f = flap
                .iter()
                .find(|&&f| self.sources[f].arc == self.sources[k].arc)?;
            for (of_flap, of_kept) in [(f, k), (self.after[f], self.after[k])] {
                self.points[of_flap] = self.points[of_kept];
                self.place[of_flap] = self.place[of_kept];
            }
            self.creases.push([k, f]);
        }
        Some(())
    }

    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    pub(super) fn segment(&self, edge: usize) -> Segment {
        [self.points[edge], self.points[self.after[edge]]]
    }

    pub(super) fn vector(&self, edge: usize) -> Vector {
        self.points[self.after[edge]] - self.points[edge]
    }

    /// Where an edge begins and ends: two edges have an end in common if these are equal.
    pub(super) fn places(&self, edge: usize) -> [usize; 2] {
        [self.place[edge], self.place[self.after[edge]]]
    }

    pub(super) fn is_crease(&self, edge: usize) -> bool {
        self.sources[edge].layer == Layer::Crease
    }

    pub(super) fn is_flap(&self, edge: usize) -> bool {
        edge >= self.first_of_flap
    }

    /// The edges of the piece that has this one.
    pub(super) fn piece(&self, edge: usize) -> Range<usize> {
        let piece = self.pieces.iter().find(|p| p.contains(&edge));
        piece.cloned().unwrap_or_default()
    }

    /// The edge before this one in its piece.
    pub(super) fn before(&self, edge: usize) -> usize {
        let piece = self.piece(edge);
        if edge > piece.start {
            edge - 1
        } else {
            piece.end - 1
        }
    }
}
