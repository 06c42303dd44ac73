//! The boundary of a folded template as the fit looks at it: which of its edges lie where, and which way they run.

use crate::crease::Axis;
use crate::fold::Layer;
use crate::stack::{fold_ring, Cloth, Crease, Source, Turns};
use crate::{Point, Segment, Vector};

/// A visible or hidden piece of the folded model's boundary.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Its layer, as the last fold has it.
    pub layer: Layer,
    /// What it is a piece of.
    pub source: Source,
    /// The folds that turned it over; a crease, since it was made.
    pub turned: Turns,
    /// The ends of the whole edge or crease where they lie now, folded.
    pub ends: [Point; 2],
    /// The share of it this piece begins and ends at.
    pub share: [f64; 2],
    /// Unit direction with the cloth on its left (from x towards y), as the seen outline runs.
    pub direction: Vector,
    /// Length of the whole edge or crease.
    pub length: f64,
}

/// A folded ring.
#[derive(Debug)]
pub(super) struct Layers {
    /// All pieces of the ring, in its order, and after them those of the creases.
    pub pieces: Vec<Piece>,
    /// All creases, in the order they were made.
    pub creases: Vec<Crease>,
    /// The layers of cloth.
    pub cloths: Vec<Cloth>,
    /// The fold made last, if there is any.
    pub last: Option<usize>,
}

impl Piece {
    /// Places at about equal distances along it: shares of its source, and the length that each stands for.
    pub(super) fn places(&self, spacing: f64) -> impl Iterator<Item = (f64, f64)> {
        let [from, to] = self.share;
        let visible = self.length * (to - from);
        let count = (visible / spacing).ceil().max(1.0);
        (0..count as usize).map(move |k| (from + (to - from) * (k as f64 + 0.5) / count, visible / count))
    }

    /// Unit normal on the cloth's side.
    pub(super) fn across(&self) -> Vector {
        Vector::new(-self.direction.y, self.direction.x)
    }
}

impl Layers {
    /// The rims of all layers of cloth where they lie now.
    pub(super) fn rings(&self) -> Vec<Vec<Point>> {
        self.cloths.iter().map(Cloth::ring).collect()
    }

    /// The part of a fold's axis between the first and the last point it creases.
    pub(super) fn creased(&self, fold: usize, axis: &Axis) -> Segment {
        let ends = self
            .creases
            .iter()
            .filter(|c| c.fold == fold)
            .flat_map(|c| c.ends);
        let extent = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), end| {
            let position = axis.position(&end);
            (from.min(position), to.max(position))
        });
        [axis.at(extent.0), axis.at(extent.1)]
    }
}

/// Folds a ring over axes that have the flap on their left, the first made first; see [`crate::stack`].
pub(super) fn fold_layers(ring: &[Point], axes: &[Axis], covered: f64) -> Option<Layers> {
    let (cloths, creases) = fold_ring(ring, axes, covered, &[]).ok()?;
    Some(Layers {
        pieces: pieces(ring, axes, &cloths, &creases),
        creases,
        cloths,
        last: axes.len().checked_sub(1),
    })
}

/// The pieces of all cloths; every crease once.
fn pieces(ring: &[Point], axes: &[Axis], cloths: &[Cloth], creases: &[Crease]) -> Vec<Piece> {
    let forward = crate::outline::signed_area(ring) > 0.0;
    let last = axes.len().wrapping_sub(1);
    let mut pieces = Vec::with_capacity(2 * ring.len() + 4 * creases.len());
    for cloth in cloths {
        for stretch in &cloth.rim {
            // A piece runs as its source does, whichever way the rim runs along it.
            let share = [
                stretch.share[0].min(stretch.share[1]),
                stretch.share[0].max(stretch.share[1]),
            ];
            let (ends, turned, layer, runs) = match stretch.source {
                Source::Edge(i) => {
                    let layer = if !axes.is_empty() && cloth.turned.by(last) {
                        Layer::Flap
                    } else {
                        Layer::Kept
                    };
                    let ends = [ring[i], ring[(i + 1) % ring.len()]];
                    (ends, cloth.turned, layer, forward)
                }
                // Both layers are creased together; once is enough. The flap lies on the axis's right once turned, as
                // the kept part does: the outline runs against the axis.
                Source::Crease(c) if cloth.turned.by(creases[c].fold) => continue,
                Source::Crease(c) => {
                    let turned = cloth.turned.after(creases[c].fold);
                    (creases[c].ends, turned, Layer::Crease, false)
                }
            };
            let folded = |p: Point| {
                let over = axes.iter().enumerate().filter(|(k, _)| turned.by(*k));
                over.fold(p, |p, (_, axis)| axis.reflect(&p))
            };
            let length = (ends[1] - ends[0]).norm();
            let ends = ends.map(folded);
            let direction = (ends[1] - ends[0]) / length.max(f64::MIN_POSITIVE);
            // Turned over, it runs the other way round.
            let direction = if runs != turned.over() {
                direction
            } else {
                -direction
            };
            pieces.push(Piece {
                layer,
                source: stretch.source,
                turned,
                ends,
                share,
                direction,
                length,
            });
        }
    }
    pieces.sort_by(|a, b| a.source.cmp(&b.source).then(a.share[0].total_cmp(&b.share[0])));
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn towel() -> Vec<Point> {
        [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)]
            .map(|(x, y)| Point::new(x, y))
            .to_vec()
    }

    fn axis(from: (f64, f64), to: (f64, f64)) -> Axis {
        Axis::new(&[Point::new(from.0, from.1), Point::new(to.0, to.1)]).unwrap()
    }

    fn extent(pieces: &[Piece]) -> [Point; 2] {
        let at = |p: &Piece, t: f64| p.ends[0] + (p.ends[1] - p.ends[0]) * t;
        let points: Vec<Point> = pieces.iter().flat_map(|p| p.share.map(|t| at(p, t))).collect();
        [
            points.iter().skip(1).fold(points[0], |a, b| a.inf(b)),
            points.iter().skip(1).fold(points[0], |a, b| a.sup(b)),
        ]
    }

    #[test]
    fn a_towel_folded_twice_is_a_quarter() {
        let halves = [axis((30.0, 40.0), (30.0, 0.0)), axis((0.0, 20.0), (30.0, 20.0))];
        let folded = fold_layers(&towel(), &halves, 0.5).unwrap();
        // The right half goes to the left, then the lower (y up to 40) onto the upper.
        let [low, high] = extent(&folded.pieces);
        assert!((low - Point::new(0.0, 0.0)).norm() < 1e-9);
        assert!((high - Point::new(30.0, 20.0)).norm() < 1e-9);
        // One crease of the first fold, one a layer of the second.
        assert_eq!(folded.creases.iter().filter(|c| c.fold == 0).count(), 1);
        assert_eq!(folded.creases.iter().filter(|c| c.fold == 1).count(), 2);
        // The second fold breaks the first crease in two.
        let broken = folded.pieces.iter().filter(|p| p.source == Source::Crease(0));
        assert_eq!(broken.count(), 2);
    }

    #[test]
    fn a_flap_that_the_next_fold_does_not_cut_goes_along() {
        // A corner is turned in, then the half it lies on is turned over.
        let folds = [axis((60.0, 10.0), (50.0, 0.0)), axis((30.0, 40.0), (30.0, 0.0))];
        let folded = fold_layers(&towel(), &folds, 0.5).unwrap();
        let [low, high] = extent(&folded.pieces);
        assert!((low - Point::new(0.0, 0.0)).norm() < 1e-9);
        assert!((high - Point::new(30.0, 40.0)).norm() < 1e-9);
        let corner = folded
            .pieces
            .iter()
            .find(|p| p.source == Source::Edge(0) && p.turned.by(0))
            .unwrap();
        assert!(corner.turned.by(1));
    }

    #[test]
    fn pieces_run_with_the_cloth_on_their_left() {
        let halves = [axis((30.0, 40.0), (30.0, 0.0)), axis((0.0, 20.0), (30.0, 20.0))];
        for piece in fold_layers(&towel(), &halves, 0.5).unwrap().pieces {
            let middle = nalgebra::center(&piece.ends[0], &piece.ends[1]);
            let inside = middle + piece.across();
            let within = (0.0..=30.0).contains(&inside.x) && (0.0..=20.0).contains(&inside.y);
            let half =
                piece.ends[0] + (piece.ends[1] - piece.ends[0]) * (0.5 * (piece.share[0] + piece.share[1]));
            let inside_half = half + piece.across();
            assert!(
                within || ((0.0..=30.0).contains(&inside_half.x) && (0.0..=20.0).contains(&inside_half.y))
            );
        }
    }

    #[test]
    fn an_axis_beside_the_ring_folds_nothing() {
        assert!(fold_layers(&towel(), &[axis((70.0, 0.0), (70.0, 40.0))], 0.5).is_none());
        assert_eq!(fold_layers(&towel(), &[], 0.5).unwrap().pieces.len(), 4);
    }
}
