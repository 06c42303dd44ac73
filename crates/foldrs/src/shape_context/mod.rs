//! Inner-distance shape contexts and their chi-squared distances.
//!
//! Every point of an outline is described by where the others lie: a histogram over the logarithm of the
//! inner distance and the direction of the first leg of the shortest path, measured from the tangent
//! (Ling & Jacobs 2007, sections 4.1 and 4.2). Folded outlines are compared by it in Mariolis & Malassiotis
//! 2015, section 2.1.2.

mod bins;
mod chi_squared;

pub use chi_squared::{chi_squared, CostMatrix};

use crate::inner_distance::InnerDistances;
use crate::wide::{widest, Kernel};
use crate::Point;
use bins::{Rings, Sectors};

/// Resolution of the shape contexts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct ShapeContextParameters {
    /// Points an outline is resampled to (Ling & Jacobs: 100). Two shape contexts are compared at
    /// `n_points^2` pairs of points.
    pub n_points: usize,
    /// Distance bins (Ling & Jacobs: 5); the last one is open.
    pub n_dist: usize,
    /// Angle bins over the full turn (Ling & Jacobs: 12).
    pub n_theta: usize,
}

impl Default for ShapeContextParameters {
    fn default() -> Self {
        Self {
            n_points: 100,
            n_dist: 5,
            n_theta: 12,
        }
    }
}

/// Histograms of all points of an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeContexts {
    n: usize,
    bins: usize,
    /// How many other points fall into a bin; `bins x n`, so that one bin of all points is contiguous.
    counts: Vec<u16>,
}

impl ShapeContexts {
    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Number of bins of a histogram, `n_dist * n_theta`.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// The histograms, row-major `n x bins`; a bin is `distance * n_theta + angle`. They are shares of the
    /// `n - 1` other points, and sum to 1 unless some of these are unreachable.
    #[must_use]
    pub fn histograms(&self) -> Vec<f32> {
        let share = self.share();
        (0..self.n * self.bins)
            .map(|k| f32::from(self.counts[k % self.bins * self.n + k / self.bins]) * share)
            .collect()
    }

    /// What one point contributes to a histogram.
    fn share(&self) -> f32 {
        1.0 / self.n.saturating_sub(1).max(1) as f32
    }

    /// Counts of one bin for all points.
    #[inline(always)]
    fn bin(&self, bin: usize) -> &[u16] {
        &self.counts[bin * self.n..(bin + 1) * self.n]
    }
}

/// Inner-distance shape contexts of an outline.
///
/// `points` are the vertices of a closed outline at equal distances, `inner` their inner distances. The
/// distance bin is `floor(log_1.5(a d + 1))` with `a = (1.5^(0.75 n_dist) - 1) / mean`, the tangent at a
/// point goes from its predecessor to its successor. Pairs at infinite distance are not counted.
#[must_use]
pub fn shape_contexts(
    points: &[Point],
    inner: &InnerDistances,
    parameters: &ShapeContextParameters,
) -> ShapeContexts {
    described(points, inner, parameters, false)
}

/// The shape contexts of the mirrored outline, from points and inner distances of the outline as it is.
///
/// Mirroring turns the winding over, so the points are taken in reversed order: point `i` of the
/// result is the mirror image of point `n - 1 - i`. All axes of reflection give the same.
#[must_use]
pub fn mirrored_shape_contexts(
    points: &[Point],
    inner: &InnerDistances,
    parameters: &ShapeContextParameters,
) -> ShapeContexts {
    described(points, inner, parameters, true)
}

fn described(
    points: &[Point],
    inner: &InnerDistances,
    parameters: &ShapeContextParameters,
    mirrored: bool,
) -> ShapeContexts {
    let n = points.len().min(inner.n);
    let (n_dist, n_theta) = (parameters.n_dist.max(1), parameters.n_theta.max(1));
    widest(Describer {
        points: &points[..n],
        inner,
        mirrored,
        rings: Rings::new(n, n_dist, n_theta, inner.mean()),
        sectors: Sectors::new(n, n_theta),
        contexts: ShapeContexts {
            n,
            bins: n_dist * n_theta,
            counts: vec![0; n * n_dist * n_theta],
        },
        // One ring more than there are bins takes what is out of reach.
        histogram: vec![0; (n_dist + 1) * n_theta],
    })
}

/// Fills in the histograms of an outline, point by point.
struct Describer<'a> {
    points: &'a [Point],
    inner: &'a InnerDistances,
    mirrored: bool,
    rings: Rings,
    sectors: Sectors,
    contexts: ShapeContexts,
    histogram: Vec<u16>,
}

impl Kernel for Describer<'_> {
    type Output = ShapeContexts;

    #[inline(always)]
    fn run(mut self) -> ShapeContexts {
        for i in 0..self.points.len() {
            self.describe(i);
        }
        self.contexts
    }
}

impl Describer<'_> {
    #[inline(always)]
    fn describe(&mut self, i: usize) {
        let n = self.points.len();
        let tangent = self.points[(i + 1) % n] - self.points[(i + n - 1) % n];
        self.sectors
            .look(self.points, self.points[i], tangent, self.mirrored);
        self.rings.look(&self.inner.distance[i * self.inner.n..][..n]);
        self.histogram.fill(0);
        let first_steps = &self.inner.first_step[i * self.inner.n..][..n];
        for (&step, &ring) in first_steps.iter().zip(&self.rings.first_bin) {
            if let Some(&sector) = self.sectors.passed.get(step as usize) {
                self.histogram[(ring + sector) as usize] += 1;
            }
        }
        // The point itself was met, too.
        let own = &mut self.histogram[(self.rings.first_bin[i] + self.sectors.passed[i]) as usize];
        *own = own.saturating_sub(1);
        let column = if self.mirrored { n - 1 - i } else { i };
        for (row, &count) in self.contexts.counts.chunks_exact_mut(n).zip(&self.histogram) {
            row[column] = count;
        }
    }
}
