//! The fold axis as a line: reflection, and the chords it cuts from an outline.

use crate::{FoldError, Outline, Point, Segment, Vector};

/// The line a garment is folded over, with a direction.
///
/// Places along it count from the first end of its segment, and are known to 1e-16 of how far off that lies: from some
/// 1e15 times an outline's size on its crossings are mere guesses, and soon nothing is creased.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Axis {
    /// A point on the line: the first end of the segment it was made from.
    pub origin: Point,
    /// Unit direction.
    pub direction: Vector,
    /// Length of the segment it was made from.
    pub length: f64,
}

/// A crossing of an axis with an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossing {
    /// Position along the axis from its origin, in the outline's units.
    pub position: f64,
    /// The edge that is crossed.
    pub edge: usize,
    /// Whether the outline passes from the right of the axis to its left (or to the axis itself, which counts as left).
    pub to_left: bool,
}

/// A piece of the axis inside the outline: where cloth would be creased.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Chord {
    /// Its two ends, in the order of the axis.
    pub ends: [Crossing; 2],
}

impl Chord {
    /// Length of the chord.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.ends[1].position - self.ends[0].position
    }

    /// Length of the part of the chord between two positions on the axis.
    #[must_use]
    pub fn overlap(&self, from: f64, to: f64) -> f64 {
        (self.ends[1].position.min(to) - self.ends[0].position.max(from)).max(0.0)
    }
}

impl Axis {
    /// The axis through a segment, in its direction.
    ///
    /// # Errors
    /// [`FoldError::NoDirection`] if the segment has no length or is not finite.
    pub fn new(segment: &Segment) -> Result<Self, FoldError> {
        let d = segment[1] - segment[0];
        let length = d.norm();
        if !(length.is_finite() && length > 0.0) {
            return Err(FoldError::NoDirection);
        }
        Ok(Self {
            origin: segment[0],
            direction: d / length,
            length,
        })
    }

    /// Unit vector at right angles to the line, to its left (from x towards y).
    #[must_use]
    pub fn normal(&self) -> Vector {
        Vector::new(-self.direction.y, self.direction.x)
    }

    /// The mirror image of a point.
    #[must_use]
    pub fn reflect(&self, p: &Point) -> Point {
        let v = p - self.origin;
        self.origin + self.direction * (2.0 * v.dot(&self.direction)) - v
    }

    /// Distance of a point from the line, positive on its left (from x towards y).
    #[must_use]
    pub fn side(&self, p: &Point) -> f64 {
        self.direction.perp(&(p - self.origin))
    }

    /// Position of a point's foot along the axis.
    #[must_use]
    pub fn position(&self, p: &Point) -> f64 {
        self.direction.dot(&(p - self.origin))
    }

    /// The point of the axis at a position.
    #[must_use]
    pub fn at(&self, position: f64) -> Point {
        self.origin + self.direction * position
    }

    /// All chords of the whole line inside the outline, in the order of the axis.
    ///
    /// A vertex exactly on the line counts as lying to its left, so every crossing is a real change of side.
    ///
    /// # Errors
    /// [`FoldError::Tangled`] if the crossings do not pair up, which only a self-crossing outline causes.
    pub fn chords(&self, outline: &Outline) -> Result<Vec<Chord>, FoldError> {
        self.chords_of(outline.points(), outline.signed_area() > 0.0)
    }

    /// As [`Axis::chords`], of a closed ring that may hold repeated points, wound positively or not.
    pub(crate) fn chords_of(&self, points: &[Point], positive: bool) -> Result<Vec<Chord>, FoldError> {
        let n = points.len();
        let side: Vec<f64> = points.iter().map(|p| self.side(p)).collect();
        let mut crossings: Vec<Crossing> = (0..n)
            .filter_map(|edge| {
                let (s, t) = (side[edge], side[(edge + 1) % n]);
                if (s >= 0.0) == (t >= 0.0) {
                    return None;
                }
                let (a, b) = (points[edge], points[(edge + 1) % n]);
                let position = self.position(&(a + (b - a) * (s / (s - t))));
                Some(Crossing {
                    position,
                    edge,
                    to_left: t >= 0.0,
                })
            })
            .collect();
        crossings.sort_by(|a, b| a.position.total_cmp(&b.position).then(a.edge.cmp(&b.edge)));
        alternate(&mut crossings, !positive)?;
        Ok(crossings
            .chunks_exact(2)
            .map(|c| Chord { ends: [c[0], c[1]] })
            .collect())
    }
}

/// Along a line the crossings with a simple outline change direction every time. Crossings at the same place
/// (the outline touches the line with a vertex) come out of the sort in any order: put them right.
///
/// `entering_to_left` is the direction in which the outline passes where the line enters it, as its winding tells.
fn alternate(crossings: &mut [Crossing], entering_to_left: bool) -> Result<(), FoldError> {
    let extent = match crossings {
        [first, .., last] => last.position - first.position,
        _ => 0.0,
    };
    for i in 0..crossings.len() {
        let wanted = if i == 0 {
            entering_to_left
        } else {
            !crossings[i - 1].to_left
        };
        if crossings[i].to_left != wanted {
            let same_place = |c: &&Crossing| c.position - crossings[i].position <= 1e-9 * extent;
            let mut others = crossings[i + 1..].iter().take_while(same_place);
            match others.position(|c| c.to_left == wanted) {
                Some(other) => crossings.swap(i, i + 1 + other),
                // An outline that crosses itself may be entered in either direction.
                None if i == 0 => {}
                None => return Err(FoldError::Tangled),
            }
        }
    }
    if crossings.len().is_multiple_of(2) {
        Ok(())
    } else {
        Err(FoldError::Tangled)
    }
}
