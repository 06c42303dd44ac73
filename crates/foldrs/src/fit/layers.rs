//! Which pieces of the template's edges belong to the kept part and which to the flap, for a given crease.

use crate::crease::{Axis, Crossing};
use crate::fold::Layer;
use crate::outline::Outline;
use crate::{Point, Vector};

/// A visible or hidden piece of the folded model's boundary.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Its layer.
    pub layer: Layer,
    /// The template corners its edge joins (equal for the crease).
    pub corners: [usize; 2],
    /// The edge's ends where they lie now, folded.
    pub ends: [Point; 2],
    /// The share of the edge this piece begins and ends at.
    pub share: [f64; 2],
    /// Unit direction with the cloth on its left (from x towards y), as the seen outline runs.
    pub direction: Vector,
    /// Length of the whole edge.
    pub length: f64,
}

/// The pieces of the folded model: every edge of the ring cut at the creased chords, and the creases.
///
/// `axis` has the flap on its left and creases the chords of which it covers the share `covered`; without such a share
/// the ring is left unfolded. `None` if the axis creases no chord.
pub(super) fn pieces(ring: &[Point], axis: &Axis, covered: Option<f64>) -> Option<Vec<Piece>> {
    let outline = Outline::new(ring.to_vec())
        .ok()
        .filter(|o| o.points().len() == ring.len())?;
    let mut chords = Vec::new();
    if let Some(covered) = covered {
        chords = axis.chords(&outline).ok()?;
        chords.retain(|c| c.length() > 0.0 && c.overlap(0.0, axis.length) >= covered * c.length());
        if chords.is_empty() {
            return None;
        }
    }
    let crossings: Vec<&Crossing> = chords.iter().flat_map(|c| &c.ends).collect();
    let n = ring.len();
    // Before its first creased crossing the ring is on the layer opposite to the one it then enters.
    let first = (0..n).find_map(|i| crossings.iter().find(|c| c.edge == i));
    let mut layer = if first.is_some_and(|c| !c.to_left) {
        Layer::Flap
    } else {
        Layer::Kept
    };
    let after = |c: &Crossing| if c.to_left { Layer::Flap } else { Layer::Kept };

    let forward = outline.signed_area() > 0.0;
    let mut pieces = Vec::with_capacity(n + 2 * chords.len());
    for i in 0..n {
        let j = (i + 1) % n;
        let (a, b) = (ring[i], ring[j]);
        let length = (b - a).norm();
        let mut push = |layer: Layer, share: [f64; 2]| {
            let ends = if layer == Layer::Flap {
                [axis.reflect(&a), axis.reflect(&b)]
            } else {
                [a, b]
            };
            // Turned over, the ring runs the other way round.
            let direction = (ends[1] - ends[0]) / length.max(f64::MIN_POSITIVE);
            let direction = if forward == (layer == Layer::Kept) {
                direction
            } else {
                -direction
            };
            pieces.push(Piece {
                layer,
                corners: [i, j],
                ends,
                share,
                direction,
                length,
            });
        };
        match crossings.iter().find(|c| c.edge == i) {
            Some(c) => {
                let t = ((axis.at(c.position) - a).norm() / length).clamp(0.0, 1.0);
                push(layer, [0.0, t]);
                layer = after(c);
                push(layer, [t, 1.0]);
            }
            None => push(layer, [0.0, 1.0]),
        }
    }
    for chord in &chords {
        let ends = [axis.at(chord.ends[0].position), axis.at(chord.ends[1].position)];
        // The flap lies on the axis's right once turned, as the kept part does: the outline runs against the axis.
        pieces.push(Piece {
            layer: Layer::Crease,
            corners: [0, 0],
            ends,
            share: [0.0, 1.0],
            direction: -axis.direction,
            length: chord.length(),
        });
    }
    Some(pieces)
}
