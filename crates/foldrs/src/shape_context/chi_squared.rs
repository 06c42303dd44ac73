//! Chi-squared distances between histograms.

use super::ShapeContexts;
use crate::wide::{widest, Kernel};

/// A matrix of matching costs, row-major.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CostMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The costs, `rows x columns`.
    pub values: Vec<f32>,
}

impl CostMatrix {
    /// One row.
    #[must_use]
    pub fn row(&self, i: usize) -> &[f32] {
        &self.values[i * self.columns..(i + 1) * self.columns]
    }
}

/// Chi-squared distances `sum (a - b)^2 / (a + b)` of all histograms of one outline to all of another, from
/// 0 to 2 (Ling & Jacobs 2007, section 4.2, without the factor 1/2).
///
/// Both must have the same bins; surplus ones of either are left out.
#[must_use]
pub fn chi_squared(a: &ShapeContexts, b: &ShapeContexts) -> CostMatrix {
    widest(Distances { a, b })
}

struct Distances<'a> {
    a: &'a ShapeContexts,
    b: &'a ShapeContexts,
}

impl Kernel for Distances<'_> {
    type Output = CostMatrix;

    #[inline(always)]
    fn run(self) -> CostMatrix {
        let Self { a, b } = self;
        // (a - b)^2 / (a + b) = a + b - 4 a b / (a + b): only bins that are filled in both histograms take work.
        // Counts are small, so many points of `a` share one, and with it the last term for all points of `b`.
        let (n, m) = (a.n, b.n);
        let bins = a.bins.min(b.bins);
        let mut common = vec![0.0_f32; n * m];
        let (mut mass_a, mut mass_b) = (vec![0.0_f32; n], vec![0.0_f32; m]);
        let (mut share_b, mut term) = (vec![0.0_f32; m], vec![0.0_f32; m]);
        let mut with_count: Vec<Vec<u32>> = vec![Vec::new(); n.max(1)];
        for bin in 0..bins {
            for ((share, mass), &count) in share_b.iter_mut().zip(&mut mass_b).zip(b.bin(bin)) {
                *share = f32::from(count) * b.share();
                *mass += *share;
            }
            for (i, &count) in a.bin(bin).iter().enumerate() {
                if count > 0 {
                    with_count[usize::from(count).min(n - 1)].push(i as u32);
                }
            }
            for (count, rows) in with_count.iter_mut().enumerate() {
                if rows.is_empty() {
                    continue;
                }
                let share_a = count as f32 * a.share();
                for (term, share) in term.iter_mut().zip(&share_b) {
                    *term = share_a * share / (share_a + share);
                }
                for i in rows.drain(..) {
                    let i = i as usize;
                    mass_a[i] += share_a;
                    for (sum, term) in common[i * m..(i + 1) * m].iter_mut().zip(&term) {
                        *sum += term;
                    }
                }
            }
        }
        for (row, mass) in common.chunks_exact_mut(m.max(1)).zip(&mass_a) {
            for (value, mass_b) in row.iter_mut().zip(&mass_b) {
                *value = (mass + mass_b - 4.0 * *value).max(0.0);
            }
        }
        CostMatrix {
            rows: n,
            columns: m,
            values: common,
        }
    }
}
