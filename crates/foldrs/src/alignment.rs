//! Order-preserving matching of two closed outlines by dynamic programming.
//!
//! Ling & Jacobs 2007, section 4.3; the correspondences register folded outlines in Mariolis & Malassiotis
//! 2015, sections 2.1.2 and 2.2.

use crate::shape_context::CostMatrix;
use crate::wide::{widest, Kernel};

/// Starts tried at once; eight single-precision lanes fill the vector registers of common machines.
const LANES: usize = 8;

/// Rows between two looks whether the alignment can still beat the bound.
const ROWS_BETWEEN_LOOKS: usize = 8;

/// How two outlines are aligned.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct AlignmentParameters {
    /// Cost of leaving a point of either outline unmatched, in the unit of the cost matrix. Two points are
    /// matched if they cost less than two of it. Ling & Jacobs: 0.3 for the chi-squared statistic with the
    /// factor 1/2, hence 0.6 without.
    pub skip_penalty: f64,
    /// Points of the second outline, evenly spaced, that are tried first as partner of the first one's start
    /// (Ling & Jacobs: 4 to 8); eight are computed together. Any number leads to the same cost, but for rounding; of
    /// alignments that cost the same another may be found.
    pub starts: usize,
}

impl Default for AlignmentParameters {
    fn default() -> Self {
        Self {
            skip_penalty: 0.6,
            starts: 8,
        }
    }
}

/// The cheapest alignment found.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Alignment {
    /// Sum of the costs of matched pairs and of the penalties, per row.
    pub cost: f64,
    /// Matched points `(row, column)`, rows increasing, columns increasing cyclically.
    pub pairs: Vec<(u32, u32)>,
    /// The column where the second outline was cut open.
    pub start: usize,
}

/// Aligns the rows' outline with the columns' outline, at the cheapest of all starts.
///
/// Evenly spaced starts are tried first. Moving the start by `k` points breaks at most `k` pairs, so that every
/// total bounds those of its neighbours from below; the remaining starts are tried only where that leaves
/// a chance.
///
/// With a `bound` only an alignment that costs less is of interest; `None`: there is none, at any start, or
/// one of the outlines has no points.
#[must_use]
pub fn align(cost: &CostMatrix, parameters: &AlignmentParameters, bound: Option<f64>) -> Option<Alignment> {
    let (n, m) = (cost.rows, cost.columns);
    if n == 0 || m == 0 {
        return None;
    }
    let penalty = parameters.skip_penalty as f32;
    let limit = bound.map_or(f32::INFINITY, |bound| (bound * n as f64) as f32);
    let floor = Floor::new(cost, penalty);
    if floor.rest[0] >= limit {
        return None;
    }
    let mut search = Search {
        cost,
        penalty,
        floor,
        limit,
        total: vec![f32::INFINITY; m],
        at_least: vec![f32::NEG_INFINITY; m],
    };
    let best = search.run(parameters.starts.clamp(1, m))?;
    // Single precision decides it unless it is a close thing; nearly always the pairs need not be traced.
    if search.total[best] > limit * (1.0 + 1e-4) {
        return None;
    }
    let (pairs, total) = trace(cost, penalty, best);
    let cost = total / n as f64;
    bound.is_none_or(|bound| cost < bound).then_some(Alignment {
        cost,
        pairs,
        start: best,
    })
}

/// Costs of the best alignments from given starts (columns), per row; in the order of `starts`.
#[must_use]
pub fn alignment_costs(cost: &CostMatrix, parameters: &AlignmentParameters, starts: &[usize]) -> Vec<f64> {
    let (n, m) = (cost.rows, cost.columns);
    if n == 0 || m == 0 {
        return vec![0.0; starts.len()];
    }
    let penalty = parameters.skip_penalty as f32;
    let floor = Floor::new(cost, penalty);
    let mut sorted: Vec<usize> = starts.iter().map(|start| start % m).collect();
    sorted.sort_unstable();
    sorted.dedup();
    let mut costs = vec![0.0; m];
    for some in sorted.chunks(LANES) {
        let totals = totals(cost, penalty, &pad(some), &floor, f32::INFINITY);
        for (&start, total) in some.iter().zip(totals) {
            costs[start] = f64::from(total) / n as f64;
        }
    }
    starts.iter().map(|start| costs[start % m]).collect()
}

/// Lower bounds of what the remaining rows cost.
struct Floor {
    /// At `i`: of the rows `i, i + 1, ...`, each matched at its best or skipped.
    rest: Vec<f32>,
}

impl Floor {
    fn new(cost: &CostMatrix, penalty: f32) -> Self {
        let mut rest = vec![0.0; cost.rows + 1];
        for i in (0..cost.rows).rev() {
            rest[i] = rest[i + 1] + widest(Least(cost.row(i))).min(penalty);
        }
        Self { rest }
    }
}

/// The least of some costs.
struct Least<'a>(&'a [f32]);

impl Kernel for Least<'_> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        // Several at a time, or each comparison would wait for the one before.
        let mut low = [f32::INFINITY; LANES];
        let (chunks, others) = self.0.as_chunks::<LANES>();
        for chunk in chunks {
            low = std::array::from_fn(|lane| least(low[lane], chunk[lane]));
        }
        low.iter().chain(others).copied().fold(f32::INFINITY, least)
    }
}

/// Search for the best start.
struct Search<'a> {
    cost: &'a CostMatrix,
    penalty: f32,
    floor: Floor,
    /// Totals from here on are of no interest.
    limit: f32,
    /// Total of every start tried; infinite for the others and those abandoned.
    total: Vec<f32>,
    /// What the total of every start cannot be below; infinite for those tried.
    at_least: Vec<f32>,
}

impl Search<'_> {
    fn run(&mut self, starts: usize) -> Option<usize> {
        let m = self.cost.columns;
        // Far enough beyond the limit that an abandoned start rules out its neighbours, too.
        let slack = 2.0 * self.penalty * m.div_ceil(2 * starts) as f32;
        let spread: Vec<usize> = (0..starts).map(|k| k * m / starts).collect();
        for starts in spread.chunks(LANES) {
            self.evaluate(starts, self.limit + slack);
        }
        loop {
            let best = self.best();
            let limit = best.map_or(self.limit, |best| self.total[best].min(self.limit));
            let mut open: Vec<usize> = (0..m).filter(|&start| self.at_least[start] < limit).collect();
            if open.is_empty() {
                return best;
            }
            open.sort_by(|&a, &b| self.at_least[a].total_cmp(&self.at_least[b]));
            open.truncate(LANES);
            open.sort_unstable();
            self.evaluate(&open, limit);
        }
    }

    fn evaluate(&mut self, starts: &[usize], limit: f32) {
        let m = self.cost.columns;
        let totals = totals(self.cost, self.penalty, &pad(starts), &self.floor, limit);
        for (&start, total) in starts.iter().zip(totals) {
            self.total[start] = total;
            // Cutting the outline k points further on breaks at most k pairs, each for two penalties.
            let known = total.min(limit);
            for (other, at_least) in self.at_least.iter_mut().enumerate() {
                let apart = start.abs_diff(other);
                let apart = apart.min(m - apart);
                *at_least = at_least.max(known - 2.0 * self.penalty * apart as f32);
            }
            self.at_least[start] = f32::INFINITY;
        }
    }

    /// The cheapest start so far, the first of equals; none if all were abandoned.
    fn best(&self) -> Option<usize> {
        (0..self.total.len())
            .filter(|&start| self.total[start] < f32::INFINITY)
            .reduce(|best, start| {
                if self.total[start] < self.total[best] {
                    start
                } else {
                    best
                }
            })
    }
}

/// Fills up to [`LANES`] starts by repeating the last one.
fn pad(starts: &[usize]) -> [usize; LANES] {
    std::array::from_fn(|lane| starts[lane.min(starts.len() - 1)])
}

/// Total costs from several starts in increasing order; infinite if none of them can stay below `limit`.
///
/// Every lane runs from its own start around to it again, row by row. All are at the same column at a time:
/// those past their start in the current row, the others still in the row before. So no costs need to be
/// gathered, and what a lane needs of its last row is always in the cell it is about to fill.
fn totals(cost: &CostMatrix, penalty: f32, starts: &[usize; LANES], floor: &Floor, limit: f32) -> Lanes {
    widest(Round {
        cost,
        penalty,
        starts,
        floor,
        limit,
    })
}

/// One round of the second outline, from several starts.
struct Round<'a> {
    cost: &'a CostMatrix,
    penalty: f32,
    starts: &'a [usize; LANES],
    floor: &'a Floor,
    limit: f32,
}

impl Kernel for Round<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run(self) -> Lanes {
        let Self {
            cost,
            penalty,
            starts,
            floor,
            limit,
        } = self;
        let (n, m) = (cost.rows, cost.columns);
        let mut front = Front::new(m, starts, penalty);
        let mut totals = [0.0; LANES];
        for i in 0..=n {
            // The pass after the last row serves the lanes that still finish it.
            let (row, before) = (cost.row(i.min(n - 1)), cost.row(i.saturating_sub(1)));
            let mut column = 0;
            for lane in 0..LANES {
                front.advance(lane, row, before, column..starts[lane]);
                column = starts[lane];
                totals[lane] = front.left[lane];
                front.left[lane] = (i + 1) as f32 * penalty;
                front.diagonal[lane] = i as f32 * penalty;
            }
            front.advance(LANES, row, before, column..m);
            let look = i % ROWS_BETWEEN_LOOKS == ROWS_BETWEEN_LOOKS - 1 && limit < f32::INFINITY;
            if look && i < n && front.least().min(i as f32 * penalty) + floor.rest[i + 1] >= limit {
                return [f32::INFINITY; LANES];
            }
        }
        totals
    }
}

type Lanes = [f32; LANES];

/// Where the dynamic programme has got to, for several starts.
struct Front {
    /// For every column the least cost up to the last cell computed there.
    line: Vec<Lanes>,
    /// Least costs up to the cell before the next one, in the same row and in the row before.
    left: Lanes,
    diagonal: Lanes,
    penalty: f32,
}

impl Front {
    /// Before the first row. Lanes short of their start finish a row that skips all columns.
    fn new(m: usize, starts: &[usize; LANES], penalty: f32) -> Self {
        let skipped = |count: usize| count as f32 * penalty;
        let line = (0..m)
            .map(|j| starts.map(|s| if j < s { f32::INFINITY } else { skipped(j + 1 - s) }))
            .collect();
        Self {
            line,
            left: starts.map(|s| skipped(m - s)),
            diagonal: [f32::INFINITY; LANES],
            penalty,
        }
    }

    /// Moves over some columns; the first `ahead` lanes are in `row`, the others in the one `before`.
    #[inline(always)]
    fn advance(&mut self, ahead: usize, row: &[f32], before: &[f32], columns: std::ops::Range<usize>) {
        let mask: [u32; LANES] = std::array::from_fn(|lane| if lane < ahead { u32::MAX } else { 0 });
        let (mut left, mut diagonal, penalty) = (self.left, self.diagonal, self.penalty);
        let (row, before) = (&row[columns.clone()], &before[columns.clone()]);
        for ((cell, &ahead), &behind) in self.line[columns].iter_mut().zip(row).zip(before) {
            let above = *cell;
            for lane in 0..LANES {
                let cost = (ahead.to_bits() & mask[lane]) | (behind.to_bits() & !mask[lane]);
                let here = least(diagonal[lane] + f32::from_bits(cost), above[lane] + penalty);
                left[lane] = least(here, left[lane] + penalty);
            }
            *cell = left;
            diagonal = above;
        }
        self.left = left;
        self.diagonal = diagonal;
    }

    /// Lower bound of what any lane has cost so far, unless it skipped all rows.
    #[inline(always)]
    fn least(&self) -> f32 {
        self.line
            .iter()
            .fold(self.diagonal, |low, cell| {
                std::array::from_fn(|lane| least(low[lane], cell[lane]))
            })
            .into_iter()
            .fold(f32::INFINITY, least)
    }
}

/// The smaller one; unlike `f32::min` a single instruction.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b {
        a
    } else {
        b
    }
}

/// Pairs and total of the best alignment from one start.
fn trace(cost: &CostMatrix, penalty: f32, start: usize) -> (Vec<(u32, u32)>, f64) {
    #[derive(Clone, Copy)]
    enum Step {
        Match,
        SkipRow,
        SkipColumn,
    }
    let (n, m) = (cost.rows, cost.columns);
    let mut steps = vec![Step::SkipColumn; n * m];
    let mut line: Vec<f32> = (0..=m).map(|j| j as f32 * penalty).collect();
    for (i, steps) in steps.chunks_exact_mut(m).enumerate() {
        let mut diagonal = line[0];
        let mut left = (i + 1) as f32 * penalty;
        line[0] = left;
        let (head, tail) = cost.row(i).split_at(start);
        for ((cell, step), c) in line[1..].iter_mut().zip(steps).zip(tail.iter().chain(head)) {
            let (skip, which) = if *cell < left {
                (*cell, Step::SkipRow)
            } else {
                (left, Step::SkipColumn)
            };
            (left, *step) = if diagonal + c < skip + penalty {
                (diagonal + c, Step::Match)
            } else {
                (skip + penalty, which)
            };
            diagonal = *cell;
            *cell = left;
        }
    }
    let (mut i, mut j) = (n, m);
    let mut pairs = Vec::with_capacity(n.min(m));
    let mut total = 0.0;
    while i > 0 && j > 0 {
        match steps[(i - 1) * m + j - 1] {
            Step::Match => {
                (i, j) = (i - 1, j - 1);
                let column = (start + j) % m;
                total += f64::from(cost.row(i)[column]);
                pairs.push((i as u32, column as u32));
            }
            Step::SkipRow => i -= 1,
            Step::SkipColumn => j -= 1,
        }
    }
    pairs.reverse();
    total += f64::from(penalty) * (n + m - 2 * pairs.len()) as f64;
    (pairs, total)
}
