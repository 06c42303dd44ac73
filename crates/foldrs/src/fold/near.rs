//! Which edges are near each other: their boxes, eight compared at a time.
//!
//! The corners of a box are told in steps of a 125th of the extent, so that a number is seven bits: eight numbers fit
//! into a word, and one subtraction compares eight pairs of them. Eight successive edges form a group with a box of its
//! own, and eight groups are compared at a time, too: few edges are near more than their own group and its neighbours.

use super::grid::Grid;
use crate::Point;

const LANES: usize = 8;
/// One in each of eight bytes.
const ONES: u64 = 0x0101_0101_0101_0101;
/// The bit of each byte that no number has.
const FREE: u64 = 0x80 * ONES;
const LARGEST: u8 = 127;

/// Where a point lies, in steps along both axes.
pub(super) fn steps(p: &Point, grid: &Grid) -> [u8; 2] {
    let p = grid.snap(p);
    // The high side of a box may be a step farther, and still is below what is around nothing.
    [p.x, p.y].map(|v| {
        let up = (i64::from(v) + i64::from(Grid::HALF)) * i64::from(LARGEST - 2);
        (up / (2 * i64::from(Grid::HALF))) as u8 & LARGEST
    })
}

/// The box of an edge or of a group.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    low: [u8; 2],
    high: [u8; 2],
}

impl Frame {
    /// Around nothing: no box overlaps it.
    pub(super) const EMPTY: Self = Self {
        low: [LARGEST; 2],
        high: [0; 2],
    };

    /// The box of an edge, wider by up to a step: edges with boxes that do not overlap are clear of each other.
    pub(super) fn of(a: [u8; 2], b: [u8; 2]) -> Self {
        Self {
            low: [a[0].min(b[0]), a[1].min(b[1])],
            high: [a[0].max(b[0]) + 1, a[1].max(b[1]) + 1],
        }
    }

    fn and(self, other: &Self) -> Self {
        Self {
            low: [self.low[0].min(other.low[0]), self.low[1].min(other.low[1])],
            high: [self.high[0].max(other.high[0]), self.high[1].max(other.high[1])],
        }
    }
}

/// Eight boxes side by side, a number a byte.
struct Lanes {
    low: [u64; 2],
    /// With the free bits set.
    high: [u64; 2],
}

impl Lanes {
    fn of(frames: &[Frame]) -> Self {
        let word = |number: fn(&Frame) -> u8| {
            let bytes = frames.iter().take(LANES).enumerate();
            bytes.fold(0, |word, (lane, frame)| {
                word | u64::from(number(frame)) << (8 * lane)
            })
        };
        // The lanes beyond the last are to be empty.
        let beyond = |frames: usize| {
            if frames < LANES {
                u64::MAX << (8 * frames)
            } else {
                0
            }
        };
        let none = beyond(frames.len()) & (u64::from(LARGEST) * ONES);
        Self {
            low: [word(|f| f.low[0]) | none, word(|f| f.low[1]) | none],
            high: [word(|f| f.high[0]) | FREE, word(|f| f.high[1]) | FREE],
        }
    }

    /// Which boxes from lane `first` on, there are fewer than eight before it, overlap another one.
    #[inline]
    fn overlapping(&self, frame: &Frame, first: usize) -> Overlapping {
        let all = |number: u8| u64::from(number) * ONES;
        // A free bit survives where what is taken away is not larger.
        let along = |axis: usize| {
            (self.high[axis] - all(frame.low[axis])) & ((all(frame.high[axis]) | FREE) - self.low[axis])
        };
        Overlapping(along(0) & along(1) & (FREE << (8 * first)))
    }
}

/// Lanes, told by the free bits of their bytes.
struct Overlapping(u64);

impl Iterator for Overlapping {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        (self.0 != 0).then(|| {
            let lane = self.0.trailing_zeros() as usize / 8;
            self.0 &= self.0 - 1;
            lane
        })
    }
}

/// Calls `visit` for every pair of edges with boxes that overlap, until it returns `None`.
pub(super) fn near_pairs(frames: &[Frame], mut visit: impl FnMut(usize, usize) -> Option<()>) -> Option<()> {
    let groups: Vec<Lanes> = frames.chunks(LANES).map(Lanes::of).collect();
    let around = |frames: &[Frame]| frames.iter().fold(Frame::EMPTY, Frame::and);
    let around: Vec<Frame> = frames.chunks(LANES).map(around).collect();
    let supergroups: Vec<Lanes> = around.chunks(LANES).map(Lanes::of).collect();
    for (i, frame) in frames.iter().enumerate() {
        // Only edges that come later: this one's own group may have none.
        let group = (i + 1) / LANES;
        for (s, supergroup) in supergroups.iter().enumerate().skip(group / LANES) {
            for lane in supergroup.overlapping(frame, group.saturating_sub(s * LANES)) {
                let g = s * LANES + lane;
                for lane in groups
                    .get(g)?
                    .overlapping(frame, (i + 1).saturating_sub(g * LANES))
                {
                    visit(i, g * LANES + lane)?;
                }
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::cases;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(cases(300))]

        #[test]
        fn every_pair_that_overlaps_is_visited_once(
            points in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 3..300),
            // Edges of all lengths; the longest are as long as the extent.
            length in 0.0..1.0_f64,
        ) {
            let ends = [Point::new(-1.0, -1.0), Point::new(1.0, 1.0)];
            let grid = Grid::around(ends.iter());
            let mut frames: Vec<Frame> = points.windows(2).map(|p| {
                let a = Point::new(p[0].0, p[0].1);
                let b = a + (Point::new(p[1].0, p[1].1) - a) * length;
                Frame::of(steps(&a, &grid), steps(&b, &grid))
            }).collect();
            frames.push(Frame::of(steps(&ends[0], &grid), steps(&ends[1], &grid)));
            frames[0] = Frame::EMPTY;
            let mut expected = Vec::new();
            for i in 0..frames.len() {
                for j in i + 1..frames.len() {
                    let (a, b) = (frames[i], frames[j]);
                    if (0..2).all(|axis| a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis]) {
                        expected.push((i, j));
                    }
                }
            }
            let mut visited = Vec::new();
            near_pairs(&frames, |i, j| { visited.push((i, j)); Some(()) }).unwrap();
            prop_assert!(visited.iter().all(|&(i, j)| i > 0 && j > i));
            prop_assert_eq!(visited, expected);
        }
    }
}
