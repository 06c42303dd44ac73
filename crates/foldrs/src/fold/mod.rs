//! Virtual folding: the part of an outline beyond the fold axis is turned over (section 2.1.2).
//!
//! A line may meet a concave outline in several chords. Only the pieces that hang on chords covered by the axis
//! segment are turned, so that one sleeve or one leg can be folded; an axis that spans both legs turns both.

mod cut;
mod grid;
mod meeting;
mod near;
mod overlay;
mod rings;
mod stops;
mod union;
mod walks;

use crate::crease::{Axis, Chord};
use crate::outline::signed_area;
use crate::{FoldError, Outline, Point, Segment};
use cut::cut;
pub(crate) use cut::{longest, turned_across};
use grid::Grid;

/// A chord is creased if at least this share of it lies on the axis segment.
pub const COVERED: f64 = 0.5;

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

    /// Whether the point of the unfolded outline at an arc length, taken modulo its length, lies on the flap.
    #[must_use]
    pub fn is_turned(&self, arc: f64) -> bool {
        // The last edge ends at the length.
        let sources = self.kept.iter().chain(&self.flap).flat_map(|p| &p.sources);
        let length = sources.fold(0.0_f64, |most, s| most.max(s.arc[0]).max(s.arc[1]));
        let arc = arc.rem_euclid(length);
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
/// image over the axis. A chord counts as covered if half of it lies on the segment, whose first end should not lie
/// 1e15 times the outline's size away (see [`Axis`]).
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
    let chords = creased_chords(outline, &axis)?;
    let (kept, flap) = cut(outline, &axis, &chords);
    let flap: Vec<Piece> = flap.into_iter().map(|p| p.turned(&axis)).collect();
    let smallest = 1e-9 * outline.signed_area().abs();
    let turned: f64 = flap.iter().map(|p| signed_area(&p.points).abs()).sum();
    if turned.is_nan() || turned <= smallest {
        return Err(FoldError::EmptyFlap);
    }
    let positive = outline.signed_area() > 0.0;
    let grid = Grid::around(kept.iter().chain(&flap).flat_map(|p| &p.points));
    let (union, holes, apart) = match union::unite(&kept, &flap, positive, &grid) {
        Some((union, holes)) => (union, holes, 0),
        None => overlay::unite(&kept, &flap, positive, &grid).ok_or(FoldError::EmptyFlap)?,
    };
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

/// The chords of an outline that the axis segment covers, in the order of the axis: where it is creased.
///
/// # Errors
/// [`FoldError::NoCrease`] or [`FoldError::Tangled`].
pub fn creased_chords(outline: &Outline, axis: &Axis) -> Result<Vec<Chord>, FoldError> {
    let mut chords = axis.chords(outline)?;
    chords.retain(|c| c.length() > 0.0 && c.overlap(0.0, axis.length) >= COVERED * c.length());
    if chords.is_empty() {
        Err(FoldError::NoCrease)
    } else {
        Ok(chords)
    }
}

impl Piece {
    fn push(&mut self, point: Point, layer: Layer, arc: [f64; 2]) {
        self.points.push(point);
        self.sources.push(Source { layer, arc });
    }
}
