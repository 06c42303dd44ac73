//! Where a walk along the pieces' boundaries may go over from one to another.

use super::grid::Grid;
use super::meeting::{meet, part, Meeting};
use super::near::{near_pairs, steps, Frame};
use super::rings::Rings;
use crate::outline::foot;
use crate::Point;

/// A place on the boundary of a piece where a walk may go over to another piece.
pub(super) struct Stop {
    pub(super) edge: usize,
    /// Share of the edge's length.
    pub(super) at: f64,
    pub(super) point: Point,
    /// The stop, at the same place, from which the walk goes on; none if it cannot arrive here from outside.
    pub(super) on: Option<usize>,
}

impl Stop {
    /// Where an edge begins.
    fn before(rings: &Rings, edge: usize, on: Option<usize>) -> Self {
        Self {
            edge,
            at: 0.0,
            point: rings.points[edge],
            on,
        }
    }
}

/// All stops, in no order; nothing if anything is nearer than `clear` to what it does not belong to.
pub(super) fn stops(rings: &Rings, grid: &Grid, positive: bool, clear: f64) -> Option<Vec<Stop>> {
    let mut stops = crossings(rings, grid, positive, clear)?;
    crease_ends(rings, positive, &mut stops);
    Some(stops)
}

/// Two stops a crossing; nothing if any two edges meet in another way than pieces of different parts may.
fn crossings(rings: &Rings, grid: &Grid, positive: bool, clear: f64) -> Option<Vec<Stop>> {
    if !(0..rings.count()).all(|e| rings.vector(e).norm_squared() > clear * clear) {
        return None;
    }
    let mut stops: Vec<Stop> = Vec::with_capacity(32);
    near_pairs(&frames(rings, grid), |i, j| {
        let ([i0, i1], [j0, j1]) = (rings.places(i), rings.places(j));
        if i1 == j0 || i0 == j1 {
            return part(&rings.vector(i), &-rings.vector(j), clear).then_some(());
        }
        if i0 == j0 || i1 == j1 {
            return part(&rings.vector(i), &rings.vector(j), clear).then_some(());
        }
        let edges = [&rings.segment(i), &rings.segment(j)];
        match meet(edges, clear) {
            Meeting::Apart => return Some(()),
            Meeting::Crossing => {}
            Meeting::Unclear => return None,
        }
        if rings.is_flap(i) == rings.is_flap(j) || rings.is_crease(i) || rings.is_crease(j) {
            return None;
        }
        let point = grid.crossing(edges);
        let i_enters = (rings.vector(j).perp(&rings.vector(i)) > 0.0) == positive;
        let on = [stops.len() + 1, stops.len()];
        for (edge, on, enters) in [(i, on[0], i_enters), (j, on[1], !i_enters)] {
            stops.push(Stop {
                edge,
                at: foot(&rings.segment(edge), &point),
                point,
                on: enters.then_some(on),
            });
        }
        Some(())
    })?;
    Some(stops)
}

/// The boxes of all edges. The flap's creases have none: those of the kept part stand for both.
fn frames(rings: &Rings, grid: &Grid) -> Vec<Frame> {
    let steps: Vec<[u8; 2]> = rings.points.iter().map(|p| steps(p, grid)).collect();
    let mut frames: Vec<Frame> = steps
        .iter()
        .zip(&rings.after)
        .map(|(&start, &end)| Frame::of(start, steps[end]))
        .collect();
    for &[_, flap] in &rings.creases {
        frames[flap] = Frame::EMPTY;
    }
    frames
}

/// Two stops at each end of every crease. A walk arrives along the piece that lies farther out, follows the crease as
/// an edge of the kept piece, and leaves along the piece that lies farther out there.
fn crease_ends(rings: &Rings, positive: bool, stops: &mut Vec<Stop>) {
    let turns_in = |from: usize, to: usize| (rings.vector(from).perp(&rings.vector(to)) > 0.0) == positive;
    for &[kept, flap] in &rings.creases {
        let [at_kept, at_flap] = [stops.len(), stops.len() + 1];
        let kept_is_out = turns_in(rings.before(flap), rings.before(kept));
        let on = [kept_is_out, !kept_is_out].map(|out| out.then_some(at_kept));
        stops.push(Stop::before(rings, kept, on[0]));
        stops.push(Stop::before(rings, flap, on[1]));

        let [at_kept, at_flap] = [at_kept + 2, at_flap + 2];
        let [kept, flap] = [rings.after[kept], rings.after[flap]];
        let on = if turns_in(kept, flap) { at_kept } else { at_flap };
        stops.push(Stop::before(rings, kept, Some(on)));
        stops.push(Stop::before(rings, flap, None));
    }
}
