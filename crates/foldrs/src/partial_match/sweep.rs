//! The sweep over all pairs of pieces: summed differences from an integral image, streamed.
//!
//! Along one offset the differences of all pairs of points form a matrix, and a piece is a block on its diagonal. The
//! block of `l` points from a point on is that of `l - 1` points from the next one, and the point's own row. So the
//! points are gone through backwards, with one running sum a length. Neighbouring offsets are swept side by side: what
//! one reads from the template is what the next one reads a place further, and every arithmetic step is the same.

use super::chord_angles::{square_wrapped, ChordAngles};
use super::{angles_within, PartialMatchParameters};
use crate::wide::{widest, Kernel};

/// Offsets swept side by side: two of the widest common vector registers.
const LANES: usize = 16;

type Lanes = [f32; LANES];

/// The piece of greatest affinity at a pair of starting points.
#[derive(Clone, Copy, Default)]
pub(super) struct Best {
    /// Its points; 0 if none reaches the threshold.
    pub length: u32,
    /// Logarithm of its affinity.
    pub log_affinity: f32,
    /// Summed difference of its chord angles.
    pub sum: f32,
}

/// Which lengths are tried, and what of their affinity depends on the length alone.
pub(super) struct Lengths {
    longest: usize,
    terms: Vec<Term>,
    floor: f32,
}

/// The logarithm of the affinity of a piece is its weight minus its summed difference times `per_difference`.
#[derive(Clone, Copy)]
struct Term {
    /// Logarithm of the length's own factor; minus infinity for lengths that are not tried.
    weight: f32,
    /// 1 / (angles within, times likeness squared).
    per_difference: f32,
}

impl Lengths {
    /// `None` if outlines of `points` points have no piece that is long enough.
    pub fn new(points: usize, delta: usize, parameters: &PartialMatchParameters) -> Option<Self> {
        let longest = ((points as f64 * parameters.longest) as usize).min(points);
        let shortest = parameters.shortest.max(delta + 2);
        let likeness_squared = parameters.likeness * parameters.likeness;
        let term = |l: usize| Term {
            weight: if l < shortest {
                f32::NEG_INFINITY
            } else {
                (1.0 - (-(l as f64) / parameters.length).exp()).ln() as f32
            },
            per_difference: (1.0 / (angles_within(l, delta).max(1) as f64 * likeness_squared)) as f32,
        };
        (shortest <= longest).then(|| Self {
            longest,
            terms: (0..=longest).map(term).collect(),
            floor: parameters.affinity.ln() as f32,
        })
    }

    /// Mean squared difference of the chord angles of a piece.
    pub fn difference(&self, best: &Best, parameters: &PartialMatchParameters) -> f64 {
        let log_likeness = best.sum * self.terms[best.length as usize].per_difference;
        f64::from(log_likeness) * (parameters.likeness * parameters.likeness)
    }
}

/// Chord angles of a template, those of all points at one distance along the outline side by side.
struct Columns {
    /// Half of a row holds one angle of all points, then of the first ones again; the other half the other angle.
    half: usize,
    rows: Vec<f32>,
}

impl Columns {
    fn new(template: &ChordAngles, longest: usize) -> Self {
        let n = template.len();
        let half = n + LANES;
        let mut rows = vec![0.0; 2 * half * longest];
        for j in 0..half {
            let angles = template.row(j % n);
            for (row, [end, start]) in rows.chunks_exact_mut(2 * half).zip(angles) {
                row[j] = *end;
                row[half + j] = *start;
            }
        }
        Self { half, rows }
    }
}

/// The best piece at every pair of starting points, row by row of the seen outline's points.
pub(super) fn best_pieces(seen: &ChordAngles, template: &ChordAngles, lengths: &Lengths) -> Vec<Best> {
    widest(Sweep {
        seen,
        n: template.len(),
        columns: &Columns::new(template, lengths.longest),
        lengths,
        sums: vec![[0.0; LANES]; lengths.longest + 1],
        best: vec![Best::default(); seen.len() * template.len()],
    })
}

struct Sweep<'a> {
    seen: &'a ChordAngles,
    /// Points of the template.
    n: usize,
    columns: &'a Columns,
    lengths: &'a Lengths,
    /// For every length the summed difference of the piece of that length from the current points on.
    sums: Vec<Lanes>,
    best: Vec<Best>,
}

impl Kernel for Sweep<'_> {
    type Output = Vec<Best>;

    #[inline(always)]
    fn run(mut self) -> Vec<Best> {
        for first in (0..self.n).step_by(LANES) {
            self.offsets(first);
        }
        self.best
    }
}

impl Sweep<'_> {
    /// Sweeps the offsets from `first` on, as many as there are lanes; those beyond the last are repetitions.
    #[inline(always)]
    fn offsets(&mut self, first: usize) {
        let (m, n, longest) = (self.seen.len(), self.n, self.lengths.longest);
        self.sums.fill([0.0; LANES]);
        // Pieces run over the start, so the sums are first built up over the points behind it.
        for i in (0..m + longest).rev() {
            let known = if i >= m { longest - (i - m) } else { longest };
            let at = (i + first) % n;
            let (log_affinity, length) = self.step(i % m, at, known);
            if i >= m {
                continue;
            }
            for lane in 0..LANES.min(n - first) {
                self.best[i * n + (at + lane) % n] = Best {
                    length: length[lane],
                    log_affinity: log_affinity[lane],
                    sum: self.sums[length[lane] as usize][lane],
                };
            }
        }
    }

    /// Puts the pair of points before all pieces of up to `known` points; the greatest affinities, and their lengths.
    #[inline(always)]
    fn step(&mut self, i: usize, at: usize, known: usize) -> (Lanes, [u32; LANES]) {
        let (mut best, mut length) = ([self.lengths.floor; LANES], [0; LANES]);
        let (mut added, mut shorter) = ([0.0; LANES], [0.0; LANES]);
        // Nearer pairs of points have no angles, shorter pieces no pairs.
        let k = self.seen.delta + 1;
        let Columns { half, rows } = self.columns;
        // Slices of known length: other iterators are called, not inlined.
        let (Some(pairs), Some(sums), Some(terms)) = (
            self.seen.row(i).get(k..known),
            self.sums.get_mut(k + 1..=known),
            self.lengths.terms.get(k + 1..=known),
        ) else {
            return (best, length);
        };
        let columns = rows[k * 2 * half..].chunks_exact(2 * half);
        let mut l = k as u32;
        // Counted beside: with the number as a further iterator, or read from the term, the loop is not vectorised.
        #[allow(clippy::explicit_counter_loop)]
        for (((&[end, start], row), term), sums) in pairs.iter().zip(columns).zip(terms).zip(sums) {
            l += 1;
            let (Some(ends), Some(starts)) = (row[at..].first_chunk(), row[half + at..].first_chunk()) else {
                break;
            };
            let (ends, starts): (&Lanes, &Lanes) = (ends, starts);
            for lane in 0..LANES {
                added[lane] += square_wrapped(end - ends[lane]) + square_wrapped(start - starts[lane]);
            }
            for lane in 0..LANES {
                let sum = shorter[lane] + added[lane];
                shorter[lane] = sums[lane];
                sums[lane] = sum;
            }
            for lane in 0..LANES {
                let log = term.weight - sums[lane] * term.per_difference;
                let better = log > best[lane];
                best[lane] = if better { log } else { best[lane] };
                length[lane] = if better { l } else { length[lane] };
            }
        }
        (best, length)
    }
}
