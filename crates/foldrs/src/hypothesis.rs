//! Hypotheses about where the fold axis lies on the template, and their aggregation (section 2.1.2).

use crate::crease::Axis;
use crate::outline::Side;
use crate::parameters::{HypothesisParameters, PartialMatchParameters};
use crate::partial_match::{affinity, piece_difference, ChordAngles, PartialMatch};
use crate::registration::{roundness, PlaneMap};
use crate::{Outline, Point, Segment};
use std::collections::BTreeMap;

/// Which way up the garment is compared with the template.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Face {
    /// As it is seen.
    Seen,
    /// Mirrored (see [`Outline::mirrored`]).
    Mirrored,
}

/// A fold axis on the template, claimed by a side of the outline.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hypothesis {
    /// The axis, in template units.
    pub axis: Segment,
    /// Confidence Cs = As Rs; summed after aggregation.
    pub confidence: f64,
    /// The side of the outline that is claimed to be the crease.
    pub side: usize,
    /// The face that was matched.
    pub face: Face,
    /// Map of the seen outline, turned to that face, onto the template.
    pub map: PlaneMap,
}

/// An outline of one face, sampled for partial matching, with its candidate creases.
#[derive(Debug, Clone)]
pub struct SampledFace {
    /// Which face.
    pub face: Face,
    /// Equally spaced points.
    pub points: Vec<Point>,
    /// Their chord angles.
    pub angles: ChordAngles,
    /// The candidate creases, in this face's frame; empty for a template.
    pub sides: Vec<Side>,
    /// Length of the outline.
    pub length: f64,
}

impl SampledFace {
    /// Samples an outline with `n` points.
    #[must_use]
    pub fn new(face: Face, outline: &Outline, sides: Vec<Side>, n: usize, delta: usize) -> Self {
        let points = outline.resample(n);
        Self {
            face,
            angles: ChordAngles::new(&points, delta),
            points,
            sides,
            length: outline.length(),
        }
    }

    /// Whether point `i` lies within the side (ends excluded).
    fn on_side(&self, side: &Side, i: usize) -> bool {
        let s = i as f64 * self.length / self.points.len() as f64;
        let ahead = (s - side.arc[0]).rem_euclid(self.length);
        ahead > 0.0 && ahead < (side.arc[1] - side.arc[0]).rem_euclid(self.length)
    }

    /// The longest part of a match without points of the side: first point (counted from the match's start), length.
    fn part_beside(&self, m: &PartialMatch, side: &Side) -> (usize, usize) {
        let (mut best, mut from) = ((0, 0), 0);
        for k in 0..=m.length {
            if k == m.length || self.on_side(side, (m.start + k) % self.points.len()) {
                if k - from > best.1 {
                    best = (from, k - from);
                }
                from = k + 1;
            }
        }
        best
    }
}

/// Share of an axis that lies inside the template, as the paper's Rs = exp(-L_out / L_in) (eq. 1).
#[must_use]
pub fn inside_score(axis: &Segment, template: &Outline) -> f64 {
    let Ok(line) = Axis::new(axis) else {
        return 0.0;
    };
    let Ok(chords) = line.chords(template) else {
        return 0.0;
    };
    let inside: f64 = chords.iter().map(|c| c.overlap(0.0, line.length)).sum();
    if inside > 0.0 {
        (-(line.length - inside).max(0.0) / inside).exp()
    } else {
        0.0
    }
}

/// One hypothesis for every match and every side it can speak for.
///
/// `scale` is the expected factor from seen units to template units.
#[must_use]
pub fn hypotheses(
    seen: &SampledFace,
    template: &Outline,
    sampled: &SampledFace,
    matches: &[PartialMatch],
    scale: f64,
    matching: &PartialMatchParameters,
    parameters: &HypothesisParameters,
) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    for m in matches {
        for (index, side) in seen.sides.iter().enumerate() {
            let (skip, length) = seen.part_beside(m, side);
            if length < matching.shortest {
                continue;
            }
            let (start, template_start) = (m.start + skip, m.template_start + skip);
            let a_s = if length == m.length {
                m.affinity
            } else {
                let d = piece_difference(
                    &seen.angles,
                    start % seen.points.len(),
                    &sampled.angles,
                    template_start,
                    length,
                );
                affinity(length, d, matching)
            };
            let from: Vec<Point> = (0..length)
                .map(|k| seen.points[(start + k) % seen.points.len()])
                .collect();
            let to: Vec<Point> = (0..length)
                .map(|k| sampled.points[(template_start + k) % sampled.points.len()])
                .collect();
            let Some(map) = map_piece(&from, &to, scale, parameters) else {
                continue;
            };
            let axis = side.segment.map(|p| map.apply(&p));
            let confidence = a_s * inside_score(&axis, template);
            if confidence > 0.0 {
                found.push(Hypothesis {
                    axis,
                    confidence,
                    side: index,
                    face: seen.face,
                    map,
                });
            }
        }
    }
    found
}

/// The affine map of a piece, or its similarity where the piece is too straight to tell more, or the affine map
/// stretches too much; `None` if the similarity does so as well.
fn map_piece(
    from: &[Point],
    to: &[Point],
    scale: f64,
    parameters: &HypothesisParameters,
) -> Option<PlaneMap> {
    let fits = |map: &PlaneMap| {
        let [most, least] = map.stretch();
        most <= scale * parameters.stretch
            && least >= scale / parameters.stretch
            && map.linear.determinant() > 0.0
    };
    if roundness(from) >= parameters.affine_spread {
        if let Some(map) = PlaneMap::affine(from, to, None).filter(fits) {
            return Some(map);
        }
    }
    PlaneMap::similarity(from, to, None).filter(fits)
}

/// Hypotheses by the bin (direction, distance) of their axes.
type Image = BTreeMap<(i64, i64), Vec<usize>>;

/// Merges like hypotheses of the same side and face; the most confident first.
///
/// Axes are points of an image over direction and distance from the template's centre. The image closes on itself:
/// half a turn on, the same line has the opposite distance. Connected components are merged into their mean, weighted
/// by confidence.
#[must_use]
pub fn aggregate(
    found: &[Hypothesis],
    template: &Outline,
    parameters: &HypothesisParameters,
) -> Vec<Hypothesis> {
    let centre = template.centroid();
    let width = parameters.distance_bin * template.signed_area().abs().sqrt();
    let bins = parameters.angle_bins as i64;
    let mut images: BTreeMap<(Face, usize), Image> = BTreeMap::new();
    for (k, h) in found.iter().enumerate() {
        let mut d = h.axis[1] - h.axis[0];
        // Of a line's two directions, the one from 0 to half a turn.
        if d.y < 0.0 || (d.y == 0.0 && d.x < 0.0) {
            d = -d;
        }
        let angle = d.y.atan2(d.x);
        let distance = d
            .normalize()
            .perp(&(centre - nalgebra::center(&h.axis[0], &h.axis[1])));
        let column = ((angle / std::f64::consts::PI * bins as f64) as i64).min(bins - 1);
        let row = (distance / width).floor() as i64;
        images
            .entry((h.face, h.side))
            .or_default()
            .entry((column, row))
            .or_default()
            .push(k);
    }
    let mut merged: Vec<Hypothesis> = images
        .into_values()
        .flat_map(|image| components(image, bins))
        .filter_map(|members| mean_hypothesis(found, &members))
        .collect();
    merged.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    merged
}

/// Members of the 8-connected components of occupied bins.
fn components(mut image: Image, bins: i64) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    while let Some((bin, members)) = image.pop_first() {
        let mut component = members;
        let mut open = vec![bin];
        while let Some((column, row)) = open.pop() {
            for (dc, dr) in (-1..=1).flat_map(|dc| (-1..=1).map(move |dr| (dc, dr))) {
                let (c, r) = (column + dc, row + dr);
                // Half a turn on, distance d falls into the bin of -d: row r becomes -r - 1.
                let next = if (0..bins).contains(&c) {
                    (c, r)
                } else {
                    (c.rem_euclid(bins), -r - 1)
                };
                if let Some(members) = image.remove(&next) {
                    component.extend(members);
                    open.push(next);
                }
            }
        }
        component.sort_unstable();
        all.push(component);
    }
    all
}

/// The mean axis weighted by confidence; the map is that of the most confident member.
fn mean_hypothesis(found: &[Hypothesis], members: &[usize]) -> Option<Hypothesis> {
    let best = members.iter().copied().reduce(|a, b| {
        if found[b].confidence > found[a].confidence {
            b
        } else {
            a
        }
    })?;
    let direction = found[best].axis[1] - found[best].axis[0];
    let mut ends = [nalgebra::Vector2::zeros(); 2];
    let mut total = 0.0;
    for &k in members {
        let Hypothesis {
            axis: [a, b],
            confidence,
            ..
        } = found[k];
        let (a, b) = if (b - a).dot(&direction) >= 0.0 {
            (a, b)
        } else {
            (b, a)
        };
        ends[0] += a.coords * confidence;
        ends[1] += b.coords * confidence;
        total += confidence;
    }
    let axis = ends.map(|e| Point::from(e / total));
    Some(Hypothesis {
        axis,
        confidence: total,
        ..found[best]
    })
}
