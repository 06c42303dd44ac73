//! The union of kept part and flap, each edge telling where it comes from: the seam to the overlay library.

use super::grid::Grid;
use super::{Layer, Piece, Source};
use crate::outline::{foot, signed_area};
use crate::{Point, Segment};
use i_overlay::core::edge_data::{EdgeDataMerge, OverlayEdgeData};
use i_overlay::core::edge_overlay::{EdgeOverlay, InputEdge};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::ShapeType;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Precision;
use i_overlay::segm::boolean::ShapeCountBoolean;

/// Index of the input edge an edge of the union comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct EdgeId(u32);

impl OverlayEdgeData for EdgeId {
    type Store = ();

    /// Edges on top of each other: the first given names the result, whatever the order they are met in.
    fn merge(ctx: EdgeDataMerge<ShapeCountBoolean, Self>, _: &mut ()) -> Self {
        Self(ctx.lhs_data.0.min(ctx.rhs_data.0))
    }
}

/// Outline of the union of all pieces, with the number of its holes and of polygons apart.
///
/// The overlay works on the integer grid: vertices move by about 1e-9 of the extent.
pub(super) fn unite(
    kept: &[Piece],
    flap: &[Piece],
    positive: bool,
    grid: &Grid,
) -> Option<(Piece, usize, usize)> {
    let mut overlay = EdgeOverlay::<i32, EdgeId>::new(256);
    // Crossings are rounded to the grid, which may make new ones: the coarsest rounding, still some 1e-9 of the extent
    // at first, ends that soonest. With the finest a tangle of thirty edges can take seconds.
    overlay.solver.precision = Precision::LOW;
    let mut inputs: Vec<(Segment, Source)> = Vec::with_capacity(256);
    for (pieces, shape) in [(kept, ShapeType::Subject), (flap, ShapeType::Clip)] {
        for piece in pieces {
            let n = piece.points.len();
            for i in 0..n {
                let (a, b) = (piece.points[i], piece.points[(i + 1) % n]);
                let data = EdgeId(inputs.len() as u32);
                overlay.add_edge(
                    InputEdge {
                        a: grid.snap(&a),
                        b: grid.snap(&b),
                        data,
                    },
                    shape,
                );
                inputs.push(([a, b], piece.sources[i]));
            }
        }
    }
    let shapes = overlay.build_vector_shapes(OverlayRule::Union, FillRule::NonZero);
    let mut rings: Vec<(Vec<Point>, f64, usize)> = Vec::with_capacity(shapes.len());
    for (k, shape) in shapes.iter().enumerate() {
        if let Some(outer) = shape.first() {
            let ring: Vec<Point> = outer.iter().map(|e| grid.back(&e.a)).collect();
            let area = signed_area(&ring);
            rings.push((ring, area, k));
        }
    }
    let larger = |a: &usize, b: &usize| rings[*a].1.abs().total_cmp(&rings[*b].1.abs());
    let largest = (0..rings.len()).max_by(larger)?;
    let apart = rings.len() - 1;
    let (mut ring, area, shape) = rings.swap_remove(largest);
    let holes = shapes[shape].len() - 1;
    let mut ids: Vec<EdgeId> = shapes[shape][0].iter().map(|e| e.data).collect();
    if (area > 0.0) != positive {
        // Every edge's data must follow its edge: edge i now runs from old vertex n-1-i to old vertex n-2-i.
        ring.reverse();
        ids.rotate_right(1);
        ids.reverse();
    }
    let n = ring.len();
    let mut piece = Piece {
        points: Vec::with_capacity(n),
        sources: Vec::with_capacity(n),
    };
    for i in 0..n {
        let (a, b) = (ring[i], ring[if i + 1 < n { i + 1 } else { 0 }]);
        let (edge, source) = &inputs[ids[i].0 as usize];
        let on = |p: &Point| {
            let t = foot(edge, p).clamp(0.0, 1.0);
            source.arc[0] + t * (source.arc[1] - source.arc[0])
        };
        let arc = if source.layer == Layer::Crease {
            crease_arc(edge, source, &a, &b)
        } else {
            [on(&a), on(&b)]
        };
        piece.push(a, source.layer, arc);
    }
    Some((piece, holes, apart))
}

/// The crease joins two far places of the unfolded outline: each end of a creased edge belongs to the nearer one.
fn crease_arc(edge: &Segment, source: &Source, a: &Point, b: &Point) -> [f64; 2] {
    let end = |p: &Point| source.arc[usize::from(foot(edge, p) > 0.5)];
    [end(a), end(b)]
}
