//! Virtual folding: the part of an outline beyond the fold axis is turned over (section 2.1.2).
//!
//! A line may meet a concave outline in several chords. Only the pieces that hang on chords covered by the axis
//! segment are turned, so that one sleeve or one leg can be folded; an axis that spans both legs turns both.

use crate::crease::{Axis, Chord};
use crate::outline::{foot, signed_area};
use crate::{FoldError, Outline, Point, Segment};
use i_overlay::core::edge_data::{EdgeDataMerge, OverlayEdgeData};
use i_overlay::core::edge_overlay::{EdgeOverlay, InputEdge};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::ShapeType;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Precision;
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::segm::boolean::ShapeCountBoolean;

/// A chord is creased if at least this share of it lies on the axis segment.
pub(crate) const COVERED: f64 = 0.5;

/// Which layer a piece of the folded outline belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Layer {
    /// The part that stayed in place.
    Kept,
    /// The part that was turned over.
    Flap,
    /// The crease itself.
    Crease,
}

/// Where an edge or a point of the folded outline comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Source {
    /// Its layer.
    pub layer: Layer,
    /// Arc length on the unfolded outline at the edge's two ends; for a crease, at the ends of its chord.
    pub arc: [f64; 2],
}

/// A closed piece of cloth: its vertices, and where every edge (from vertex `i` to the next) comes from.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Piece {
    /// Vertices, closed implicitly, wound as the unfolded outline.
    pub points: Vec<Point>,
    /// One entry an edge.
    pub sources: Vec<Source>,
}

/// A point of the folded outline with its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoldedPoint {
    /// Its position, folded.
    pub point: Point,
    /// Its layer.
    pub layer: Layer,
    /// Its arc length on the unfolded outline. For a point of the crease, that of the nearer end of its chord.
    pub arc: f64,
}

/// An outline folded over an axis.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Folded {
    /// The line it was folded over.
    pub axis: Axis,
    /// The creased chords, in the order of the axis.
    pub creases: Vec<Segment>,
    /// The pieces that stayed in place.
    pub kept: Vec<Piece>,
    /// The pieces that were turned, where they lie now.
    pub flap: Vec<Piece>,
    /// Outline of the union of all pieces, wound as the unfolded outline.
    pub outline: Piece,
    /// Holes enclosed by the outline (the table seen through, for instance, between a body and a folded sleeve).
    pub holes: usize,
    /// Further polygons apart from the outline; 0 unless pieces only touch.
    pub apart: usize,
}

impl Folded {
    /// `n` points at equal arc length of the folded outline, with their origin.
    #[must_use]
    pub fn resample(&self, n: usize) -> Vec<FoldedPoint> {
        self.outline.resample(n)
    }

    /// Whether the point of the unfolded outline at an arc length lies on the flap.
    #[must_use]
    pub fn is_turned(&self, arc: f64) -> bool {
        let on = |s: &Source| {
            s.layer != Layer::Crease && arc >= s.arc[0].min(s.arc[1]) && arc <= s.arc[0].max(s.arc[1])
        };
        self.flap.iter().any(|p| p.sources.iter().any(on))
    }

    /// Area of all pieces turned over.
    #[must_use]
    pub fn flap_area(&self) -> f64 {
        self.flap.iter().map(|p| signed_area(&p.points).abs()).sum()
    }
}

impl Piece {
    fn resample(&self, n: usize) -> Vec<FoldedPoint> {
        let count = self.points.len();
        let edge = |i: usize| [self.points[i], self.points[(i + 1) % count]];
        let length: f64 = (0..count).map(|i| (edge(i)[1] - edge(i)[0]).norm()).sum();
        let step = length / n as f64;
        let (mut i, mut start, mut span) = (0, 0.0, (edge(0)[1] - edge(0)[0]).norm());
        (0..n)
            .map(|k| {
                let s = k as f64 * step;
                while i + 1 < count && start + span <= s {
                    start += span;
                    i += 1;
                    span = (edge(i)[1] - edge(i)[0]).norm();
                }
                let t = if span > 0.0 {
                    ((s - start) / span).min(1.0)
                } else {
                    0.0
                };
                let [a, b] = edge(i);
                let Source { layer, arc } = self.sources[i];
                let arc = match layer {
                    Layer::Crease if t < 0.5 => arc[0],
                    Layer::Crease => arc[1],
                    _ => arc[0] + (arc[1] - arc[0]) * t,
                };
                FoldedPoint {
                    point: a + (b - a) * t,
                    layer,
                    arc,
                }
            })
            .collect()
    }

    /// The piece turned over the axis, its winding kept.
    fn turned(mut self, axis: &Axis) -> Self {
        for p in &mut self.points {
            *p = axis.reflect(p);
        }
        self.points.reverse();
        // Edge i now runs from old vertex n-1-i to old vertex n-2-i: old edge n-2-i backwards.
        self.sources.rotate_right(1);
        self.sources.reverse();
        for s in &mut self.sources {
            s.arc.reverse();
            if s.layer != Layer::Crease {
                s.layer = Layer::Flap;
            }
        }
        self
    }
}

/// Folds an outline over an axis segment: what hangs on the left of the chords it covers is turned over.
///
/// *Left* is the side towards which the direction x turns to y. Turning the other side instead gives the mirror
/// image over the axis. A chord counts as covered if half of it lies on the segment.
///
/// ```
/// use foldrs::{fold, Outline, Point};
/// let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Point::new(x, y));
/// let square = Outline::new(square.to_vec())?;
/// let folded = fold(&square, &[Point::new(0.0, 1.5), Point::new(2.0, 1.5)])?;
/// assert_eq!(folded.flap_area(), 1.0);
/// assert_eq!(folded.creases.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FoldError::NoDirection`], [`FoldError::NoCrease`], [`FoldError::EmptyFlap`] or [`FoldError::Tangled`].
pub fn fold(outline: &Outline, axis: &Segment) -> Result<Folded, FoldError> {
    let axis = Axis::new(axis)?;
    let mut chords = axis.chords(outline)?;
    chords.retain(|c| c.length() > 0.0 && c.overlap(0.0, axis.length) >= COVERED * c.length());
    if chords.is_empty() {
        return Err(FoldError::NoCrease);
    }
    let (kept, flap) = cut(outline, &axis, &chords);
    let flap: Vec<Piece> = flap.into_iter().map(|p| p.turned(&axis)).collect();
    let smallest = 1e-9 * outline.signed_area().abs();
    let turned: f64 = flap.iter().map(|p| signed_area(&p.points).abs()).sum();
    if turned.is_nan() || turned <= smallest {
        return Err(FoldError::EmptyFlap);
    }
    let (union, holes, apart) =
        unite(&kept, &flap, outline.signed_area() > 0.0).ok_or(FoldError::EmptyFlap)?;
    let creases = chords
        .iter()
        .map(|c| [axis.at(c.ends[0].position), axis.at(c.ends[1].position)])
        .collect();
    Ok(Folded {
        axis,
        creases,
        kept,
        flap,
        outline: union,
        holes,
        apart,
    })
}

/// A vertex of the outline or an end of a creased chord, in the order of the outline.
struct Node {
    point: Point,
    arc: f64,
    /// For the end of a chord: the chord.
    chord: Option<usize>,
}

/// Cuts the outline along the chords; returns the kept pieces and those to be turned (not yet turned).
fn cut(outline: &Outline, axis: &Axis, chords: &[Chord]) -> (Vec<Piece>, Vec<Piece>) {
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
            points: Vec::new(),
            sources: Vec::new(),
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
    let longest = (0..chords.len()).fold(0, |best, c| {
        if chords[c].length() > chords[best].length() {
            c
        } else {
            best
        }
    });
    let k = ends[longest][0];
    let goes_left = chords[longest]
        .ends
        .iter()
        .find(|e| axis.at(e.position) == nodes[k].point)
        .is_some_and(|e| e.to_left);
    let stays = across[longest][usize::from(!goes_left)];

    let mut turned = vec![None; count];
    turned[stays] = Some(false);
    // The pieces form a tree over the chords, so this many rounds reach them all.
    for _ in 0..chords.len() {
        for &[a, b] in &across {
            match (turned[a], turned[b]) {
                (Some(t), None) => turned[b] = Some(!t),
                (None, Some(t)) => turned[a] = Some(!t),
                _ => {}
            }
        }
    }
    turned.into_iter().map(|t| t.unwrap_or(false)).collect()
}

impl Piece {
    fn push(&mut self, point: Point, layer: Layer, arc: [f64; 2]) {
        self.points.push(point);
        self.sources.push(Source { layer, arc });
    }
}

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
/// The overlay works on an integer grid: vertices move by about 1e-9 of the extent.
fn unite(kept: &[Piece], flap: &[Piece], positive: bool) -> Option<(Piece, usize, usize)> {
    let grid = Grid::around(kept.iter().chain(flap).flat_map(|p| &p.points));
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
    let area = |ring: &[(Point, EdgeId)]| signed_area(&ring.iter().map(|e| e.0).collect::<Vec<_>>());
    let mut rings: Vec<(Vec<(Point, EdgeId)>, usize)> = shapes
        .iter()
        .filter_map(|shape| {
            let outer = shape.first()?;
            Some((
                outer.iter().map(|e| (grid.back(&e.a), e.data)).collect(),
                shape.len() - 1,
            ))
        })
        .collect();
    let largest =
        (0..rings.len()).max_by(|&a, &b| area(&rings[a].0).abs().total_cmp(&area(&rings[b].0).abs()))?;
    let apart = rings.len() - 1;
    let (mut ring, holes) = rings.swap_remove(largest);
    if (area(&ring) > 0.0) != positive {
        // Reverse the ring; every edge's data must follow its edge.
        let ids: Vec<EdgeId> = ring.iter().map(|e| e.1).collect();
        let n = ring.len();
        ring.reverse();
        for (i, e) in ring.iter_mut().enumerate() {
            e.1 = ids[(2 * n - 2 - i) % n];
        }
    }
    let n = ring.len();
    let mut piece = Piece {
        points: Vec::with_capacity(n),
        sources: Vec::with_capacity(n),
    };
    for i in 0..n {
        let (a, id) = ring[i];
        let b = ring[(i + 1) % n].0;
        let (edge, source) = &inputs[id.0 as usize];
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

/// An integer grid of some 2^30 steps over the pieces.
struct Grid {
    centre: Point,
    scale: f64,
}

impl Grid {
    fn around<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let (mut low, mut high) = (Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN));
        for p in points {
            low = Point::new(low.x.min(p.x), low.y.min(p.y));
            high = Point::new(high.x.max(p.x), high.y.max(p.y));
        }
        let half = ((high.x - low.x).max(high.y - low.y) / 2.0).max(f64::MIN_POSITIVE);
        Self {
            centre: nalgebra::center(&low, &high),
            scale: f64::from(1 << 29) / half,
        }
    }

    fn snap(&self, p: &Point) -> IntPoint<i32> {
        let v = (p - self.centre) * self.scale;
        IntPoint::new(v.x.round() as i32, v.y.round() as i32)
    }

    fn back(&self, p: &IntPoint<i32>) -> Point {
        self.centre + nalgebra::Vector2::new(f64::from(p.x), f64::from(p.y)) / self.scale
    }
}
