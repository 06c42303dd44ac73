//! Walks along the outer boundary of overlapping pieces, from stop to stop.

use super::rings::Rings;
use super::stops::Stop;
use super::{Layer, Piece, Source};
use crate::Point;

/// All walks, each once round; nothing if one arrives where it cannot be, or if two stops on an edge are nearer than
/// `clear` and so may come in either order.
pub(super) fn walks(rings: &Rings, stops: &[Stop], clear: f64) -> Option<Vec<Piece>> {
    let next = next_stops(rings, stops, clear)?;
    let mut walks = Vec::with_capacity(2);
    let mut passed = vec![false; stops.len()];
    for (first, stop) in stops.iter().enumerate() {
        let Some(mut from) = stop.on.filter(|_| !passed[first]) else {
            continue;
        };
        let most = rings.count() + stops.len();
        let mut piece = Piece {
            points: Vec::with_capacity(most),
            sources: Vec::with_capacity(most),
        };
        while !passed[first] {
            let to = next[from];
            stretch(rings, &mut piece, &stops[from], &stops[to]);
            from = stops[to].on.filter(|_| !passed[to])?;
            passed[to] = true;
        }
        walks.push(piece);
    }
    Some(walks)
}

/// For every stop the next one along its piece.
fn next_stops(rings: &Rings, stops: &[Stop], clear: f64) -> Option<Vec<usize>> {
    let mut order: Vec<usize> = (0..stops.len()).collect();
    order.sort_unstable_by(|&a, &b| {
        let (a, b) = (&stops[a], &stops[b]);
        a.edge.cmp(&b.edge).then(a.at.total_cmp(&b.at))
    });
    let mut next = vec![0; stops.len()];
    let piece = |stop: usize| rings.piece(stops[stop].edge);
    for of_piece in order.chunk_by(|&a, &b| piece(a) == piece(b)) {
        let following = of_piece.iter().skip(1).chain(of_piece.first());
        for (&stop, &then) in of_piece.iter().zip(following) {
            next[stop] = then;
            let (a, b) = (&stops[stop], &stops[then]);
            if a.edge == b.edge && (b.point - a.point).norm() <= clear {
                return None;
            }
        }
    }
    Some(next)
}

/// Adds the boundary of a piece from one stop up to the next.
fn stretch(rings: &Rings, walked: &mut Piece, from: &Stop, to: &Stop) {
    let first = &rings.sources[from.edge];
    if from.edge == to.edge && from.at < to.at {
        push(walked, from.point, first, [from.at, to.at]);
        return;
    }
    push(walked, from.point, first, [from.at, 1.0]);
    let (piece, start) = (rings.piece(from.edge), rings.after[from.edge]);
    let whole = if start <= to.edge {
        [start..to.edge, 0..0]
    } else {
        [start..piece.end, piece.start..to.edge]
    };
    for edges in whole {
        walked.points.extend_from_slice(&rings.points[edges.clone()]);
        walked.sources.extend_from_slice(&rings.sources[edges]);
    }
    if to.at > 0.0 {
        push(
            walked,
            rings.points[to.edge],
            &rings.sources[to.edge],
            [0.0, to.at],
        );
    }
}

/// Adds the part of an edge between two shares of its length.
fn push(piece: &mut Piece, point: Point, source: &Source, [from, to]: [f64; 2]) {
    let [start, end] = source.arc;
    let along = |share: f64| start + (end - start) * share;
    let arc = if source.layer == Layer::Crease {
        source.arc // always in one piece: nothing crosses it
    } else {
        [along(from), along(to)]
    };
    piece.push(point, source.layer, arc);
}
