//! The sweep over all pairs of pieces: summed differences from an integral image, streamed.
//!
//! Along one offset the differences of all pairs of points form a matrix, and a piece is a block on its diagonal. The
//! block of `l` points from a point on is that of `l - 1` points from the next one, and the point's own row. So the
//! points are gone through backwards, with one running sum a length. Neighbouring offsets are swept side by side: what
//! one reads from the template is what the next one reads a place further, and every arithmetic step is the same.

use super::chord_angles::{square_wrapped, ChordAngles};
use super::{angles_within, PartialMatchParameters};

/// Offsets swept side by side: two of the widest common vector registers.
const LANES: usize = 16;

type Lanes = [f32; LANES];

/// The piece of greatest affinity at a pair of starting points.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub start: u32,
    pub template_start: u32,
    pub length: u32,
    /// Logarithm of its affinity.
    pub log_affinity: f32,
    /// Summed difference of its chord angles.
    pub sum: f32,
}

/// Which lengths are tried, and what of their affinity depends on the length alone.
pub(super) struct Lengths {
    shortest: usize,
    longest: usize,
    /// 1 / (angles within, times likeness squared), a length.
    likeness: Vec<f32>,
    /// Logarithm of the length's own factor.
    weight: Vec<f32>,
    floor: f32,
}

impl Lengths {
    /// `None` if outlines of `points` points have no piece that is long enough.
    pub fn new(points: usize, delta: usize, parameters: &PartialMatchParameters) -> Option<Self> {
        let longest = ((points as f64 * parameters.longest) as usize).min(points);
        let shortest = parameters.shortest.max(delta + 2);
        let likeness_squared = parameters.likeness * parameters.likeness;
        (shortest <= longest).then(|| Self {
            shortest,
            longest,
            likeness: (0..=longest)
                .map(|l| (1.0 / (angles_within(l, delta).max(1) as f64 * likeness_squared)) as f32)
                .collect(),
            weight: (0..=longest)
                .map(|l| (1.0 - (-(l as f64) / parameters.length).exp()).ln() as f32)
                .collect(),
            floor: parameters.affinity.ln() as f32,
        })
    }

    /// Mean squared difference of the chord angles of a piece.
    pub fn difference(&self, best: &Best, parameters: &PartialMatchParameters) -> f64 {
        f64::from(best.sum * self.likeness[best.length as usize]) * parameters.likeness * parameters.likeness
    }
}

/// Chord angles of a template, those of one distance along the outline side by side.
struct Columns {
    /// A row holds the angles of all points, then the first ones again.
    width: usize,
    at_end: Vec<f32>,
    at_start: Vec<f32>,
}

impl Columns {
    fn new(template: &ChordAngles, longest: usize) -> Self {
        let n = template.n;
        let width = n + LANES;
        let columns = |angles: &[f32]| {
            let mut rows = Vec::with_capacity(longest * width);
            for k in 0..longest {
                rows.extend((0..width).map(|j| angles[(j % n) * n + k]));
            }
            rows
        };
        Self {
            width,
            at_end: columns(&template.at_end),
            at_start: columns(&template.at_start),
        }
    }
}

/// The best piece at every pair of starting points that reaches the threshold, in no particular order.
pub(super) fn best_pieces(seen: &ChordAngles, template: &ChordAngles, lengths: &Lengths) -> Vec<Best> {
    let columns = Columns::new(template, lengths.longest);
    let mut found = Vec::new();
    let mut sweep = Sweep {
        seen,
        columns: &columns,
        lengths,
        sums: vec![[0.0; LANES]; lengths.longest + 1],
    };
    for first in (0..template.n).step_by(LANES) {
        sweep.offsets(first, template.n, &mut found);
    }
    found
}

struct Sweep<'a> {
    seen: &'a ChordAngles,
    columns: &'a Columns,
    lengths: &'a Lengths,
    /// For every length the summed difference of the piece of that length from the current points on.
    sums: Vec<Lanes>,
}

impl Sweep<'_> {
    /// Sweeps the offsets from `first` on, as many as there are lanes; those beyond `n` are repetitions.
    fn offsets(&mut self, first: usize, n: usize, found: &mut Vec<Best>) {
        let (m, longest) = (self.seen.n, self.lengths.longest);
        let lanes = LANES.min(n - first);
        self.sums.fill([0.0; LANES]);
        // Pieces run over the start, so the sums are first built up over the points behind it.
        for i in (0..m + longest).rev() {
            let known = if i >= m { longest - (i - m) } else { longest };
            let at = (i + first) % n;
            let (log, length) = self.step(i % m, at, known);
            if i >= m {
                continue;
            }
            for lane in 0..lanes {
                if length[lane] > 0 {
                    found.push(Best {
                        start: i as u32,
                        template_start: ((at + lane) % n) as u32,
                        length: length[lane],
                        log_affinity: log[lane],
                        sum: self.sums[length[lane] as usize][lane],
                    });
                }
            }
        }
    }

    /// Puts the pair of points before all pieces of up to `known` points; the greatest affinities, and their lengths.
    #[inline(always)]
    fn step(&mut self, i: usize, at: usize, known: usize) -> (Lanes, [u32; LANES]) {
        let (delta, shortest) = (self.seen.delta, self.lengths.shortest);
        let seen_end = &self.seen.at_end[i * self.seen.n..][..known];
        let seen_start = &self.seen.at_start[i * self.seen.n..][..known];
        let (mut best, mut length) = ([self.lengths.floor; LANES], [0; LANES]);
        let mut pairs = [0.0; LANES];
        let mut shorter = [0.0; LANES];
        for k in delta + 1..known {
            let from = k * self.columns.width + at;
            let (Some(ends), Some(starts)) = (
                self.columns.at_end[from..].first_chunk::<LANES>(),
                self.columns.at_start[from..].first_chunk::<LANES>(),
            ) else {
                break;
            };
            let l = k + 1;
            let (end, start) = (seen_end[k], seen_start[k]);
            let sums = &mut self.sums[l];
            for lane in 0..LANES {
                pairs[lane] += square_wrapped(end - ends[lane]) + square_wrapped(start - starts[lane]);
                let sum = shorter[lane] + pairs[lane];
                shorter[lane] = sums[lane];
                sums[lane] = sum;
            }
            if l >= shortest {
                let (weight, likeness) = (self.lengths.weight[l], self.lengths.likeness[l]);
                for lane in 0..LANES {
                    let log = weight - sums[lane] * likeness;
                    let better = log > best[lane];
                    best[lane] = if better { log } else { best[lane] };
                    length[lane] = if better { l as u32 } else { length[lane] };
                }
            }
        }
        (best, length)
    }
}
