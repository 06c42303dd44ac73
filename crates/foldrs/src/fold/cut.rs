//! An outline cut along the chords that are creased.

use super::{Layer, Piece};
use crate::crease::{Axis, Chord};
use crate::{Outline, Point};

/// A vertex of the outline or an end of a creased chord, in the order of the outline.
struct Node {
    point: Point,
    arc: f64,
    /// For the end of a chord: the chord.
    chord: Option<usize>,
}

/// Cuts the outline along the chords; returns the kept pieces and those to be turned (not yet turned).
pub(super) fn cut(outline: &Outline, axis: &Axis, chords: &[Chord]) -> (Vec<Piece>, Vec<Piece>) {
    let nodes = nodes(outline, axis, chords);
    let mut ends = vec![Vec::with_capacity(2); chords.len()];
    for (k, node) in nodes.iter().enumerate() {
        if let Some(c) = node.chord {
            ends[c].push(k);
        }
    }
    let partner = |k: usize, c: usize| {
        if ends[c][0] == k {
            ends[c][1]
        } else {
            ends[c][0]
        }
    };

    let mut piece_after = vec![usize::MAX; nodes.len()]; // the piece the stretch from node k to the next belongs to
    let mut pieces = Vec::with_capacity(chords.len() + 1);
    for first in 0..nodes.len() {
        if piece_after[first] != usize::MAX {
            continue;
        }
        let mut piece = Piece {
            points: Vec::with_capacity(nodes.len() + chords.len()),
            sources: Vec::with_capacity(nodes.len() + chords.len()),
        };
        let mut k = first;
        loop {
            piece_after[k] = pieces.len();
            let next = (k + 1) % nodes.len();
            let end = if next == 0 {
                outline.length()
            } else {
                nodes[next].arc
            };
            piece.push(nodes[k].point, Layer::Kept, [nodes[k].arc, end]);
            k = next;
            if let Some(c) = nodes[k].chord {
                let other = partner(k, c);
                piece.push(nodes[k].point, Layer::Crease, [nodes[k].arc, nodes[other].arc]);
                k = other;
            }
            if k == first {
                break;
            }
        }
        pieces.push(piece);
    }

    let turned = turned_pieces(axis, chords, &ends, &piece_after, &nodes, pieces.len());
    let (mut kept, mut flap) = (Vec::new(), Vec::new());
    for (piece, turn) in pieces.into_iter().zip(turned) {
        if turn { &mut flap } else { &mut kept }.push(piece);
    }
    (kept, flap)
}

fn nodes(outline: &Outline, axis: &Axis, chords: &[Chord]) -> Vec<Node> {
    let mut at_edge: Vec<(usize, usize, f64)> = Vec::with_capacity(2 * chords.len());
    for (c, chord) in chords.iter().enumerate() {
        at_edge.extend(chord.ends.iter().map(|e| (e.edge, c, e.position)));
    }
    let mut nodes = Vec::with_capacity(outline.points().len() + at_edge.len());
    for (i, &point) in outline.points().iter().enumerate() {
        let arc = outline.arc_of_vertex(i);
        nodes.push(Node {
            point,
            arc,
            chord: None,
        });
        if let Some(&(_, c, position)) = at_edge.iter().find(|e| e.0 == i) {
            let crossing = axis.at(position);
            let arc = arc + (crossing - point).norm();
            nodes.push(Node {
                point: crossing,
                arc,
                chord: Some(c),
            });
        }
    }
    nodes
}

/// Which pieces are turned: across every creased chord the layer changes, and the piece on the right of the longest
/// chord stays. (Nearly always that is simply all pieces on the left.)
fn turned_pieces(
    axis: &Axis,
    chords: &[Chord],
    ends: &[Vec<usize>],
    piece_after: &[usize],
    nodes: &[Node],
    count: usize,
) -> Vec<bool> {
    // At a chord end the outline passes from one piece to the other.
    let across: Vec<[usize; 2]> = ends
        .iter()
        .map(|e| {
            let k = e[0];
            [piece_after[(k + nodes.len() - 1) % nodes.len()], piece_after[k]]
        })
        .collect();
    let longest = longest(chords);
    let k = ends[longest][0];
    let goes_left = chords[longest]
        .ends
        .iter()
        .find(|e| axis.at(e.position) == nodes[k].point)
        .is_some_and(|e| e.to_left);
    turned_across(&across, across[longest][usize::from(!goes_left)], count)
}

/// The longest of some chords, the first if several are.
pub(crate) fn longest(chords: &[Chord]) -> usize {
    (0..chords.len()).fold(0, |best, c| {
        if chords[c].length() > chords[best].length() {
            c
        } else {
            best
        }
    })
}

/// Which pieces are turned if one stays, and across every crease, each between two of them, that changes.
pub(crate) fn turned_across(across: &[[usize; 2]], stays: usize, count: usize) -> Vec<bool> {
    let mut turned = vec![None; count];
    turned[stays] = Some(false);
    // The pieces form a tree over the creases, so this many rounds reach them all.
    for _ in 0..across.len() {
        for &[a, b] in across {
            match (turned[a], turned[b]) {
                (Some(t), None) => turned[b] = Some(!t),
                (None, Some(t)) => turned[a] = Some(!t),
                _ => {}
            }
        }
    }
    turned.into_iter().map(|t| t.unwrap_or(false)).collect()
}
