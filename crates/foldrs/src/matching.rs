//! The matching stage (section 2.1): from an outline and templates to the fold axis.
//!
//! [`match_folded`] is its table of contents.

use crate::alignment::{align, Alignment};
use crate::crease::Axis;
use crate::fold::{creased_chords, fold, FoldedPoint};
use crate::hypothesis::{aggregate, hypotheses, Face, Hypothesis, SampledFace};
use crate::inner_distance::inner_distances;
use crate::outline::Side;
use crate::parameters::{Parameters, LEAST_POINTS};
use crate::partial_match::partial_matches;
use crate::registration::PlaneMap;
use crate::shape_context::{chi_squared, mirrored_shape_contexts, shape_contexts, ShapeContexts};
use crate::{parallel, Outline, Point, Segment};
use std::sync::atomic::{AtomicU64, Ordering};

/// All that depends on the seen outline alone, prepared once for all templates and iterations.
#[derive(Debug, Clone)]
pub struct Seen {
    outline: Outline,
    points: Vec<Point>,
    contexts: ShapeContexts,
    mirrored_contexts: ShapeContexts,
    faces: [SampledFace; 2],
}

/// A hypothesis about the fold axis of one of several templates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Claim {
    /// Index of the template.
    pub template: usize,
    /// The hypothesis.
    pub hypothesis: Hypothesis,
}

/// A fold of a template compared with the seen outline.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Candidate {
    /// Index of the template.
    pub template: usize,
    /// The hypothesis tested.
    pub hypothesis: Hypothesis,
    /// Matching cost: the cheapest alignment of the folded template with the seen outline, either face up.
    pub cost: f64,
    /// The face of the cheapest alignment.
    pub face: Face,
}

/// What the matching stage found.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Matching {
    /// All tested hypotheses of all templates, the cheapest first.
    pub candidates: Vec<Candidate>,
    /// For every template the cost of matching it unfolded: a fold is accepted only if it costs less.
    pub unfolded: Vec<f64>,
}

/// A candidate laid over the seen outline.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Explanation {
    /// Equally spaced points of the folded template, with their origin on the unfolded one.
    pub folded: Vec<FoldedPoint>,
    /// For every one of them the index of its partner among the seen points, if it has one.
    pub partner: Vec<Option<usize>>,
    /// Least-squares map of the folded template onto the seen outline; reflecting if the garment shows its other face.
    pub to_seen: PlaneMap,
    /// The crease on the seen outline: the mapped axis, laid on the side that claims it.
    pub crease: Segment,
    /// Matching cost.
    pub cost: f64,
}

/// Matches a seen outline to templates (section 2.1).
///
/// `scale` is the number of seen units (px) a template unit; `None` if unknown, then several are tried.
/// The result does not depend on the number of threads.
#[must_use]
pub fn match_folded(
    seen: &Seen,
    templates: &[Outline],
    scale: Option<f64>,
    parameters: &Parameters,
) -> Matching {
    let claims = claims_to_test(seen, templates, scale, parameters);
    let mut candidates: Vec<Candidate> = parallel::map(&claims, |claim| {
        test(seen, &templates[claim.template], claim, None, parameters)
    })
    .into_iter()
    .flatten()
    .collect();
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost)); // stable: like costs keep the order of confidence
    Matching {
        candidates,
        unfolded: unfolded_costs(seen, templates, parameters),
    }
}

/// As [`match_folded`], but of every template only the cheapest candidate, the most confident of equals.
///
/// Much faster: what a fold found so far costs bounds the others of its template, and most of them are given up early.
#[must_use]
pub fn cheapest_folds(
    seen: &Seen,
    templates: &[Outline],
    scale: Option<f64>,
    parameters: &Parameters,
) -> Matching {
    let claims = claims_to_test(seen, templates, scale, parameters);
    let bounds: Vec<LeastCost> = templates.iter().map(|_| LeastCost::default()).collect();
    let costs = parallel::map(&claims, |claim| {
        let (template, bound) = (&templates[claim.template], &bounds[claim.template]);
        let candidate = test(seen, template, claim, Some(bound.with_margin()), parameters)?;
        bound.lower_to(candidate.cost);
        Some(candidate.cost)
    });
    // Which candidates were given up depends on the threads' luck, the best of those that were not does not.
    let best: Vec<Claim> = claims
        .into_iter()
        .zip(costs)
        .filter(|(claim, cost)| cost.is_some_and(|cost| cost <= bounds[claim.template].with_margin()))
        .map(|(claim, _)| claim)
        .collect();
    let tested = parallel::map(&best, |claim| {
        test(seen, &templates[claim.template], claim, None, parameters)
    });
    let mut candidates: Vec<Candidate> = tested.into_iter().flatten().collect();
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut found = vec![false; templates.len()];
    candidates.retain(|c| !std::mem::replace(&mut found[c.template], true));
    Matching {
        candidates,
        unfolded: unfolded_costs(seen, templates, parameters),
    }
}

/// The claims of every template that are tested.
fn claims_to_test(
    seen: &Seen,
    templates: &[Outline],
    scale: Option<f64>,
    parameters: &Parameters,
) -> Vec<Claim> {
    let mut claims = claim_axes(seen, templates, scale, parameters);
    let mut tested = vec![0; templates.len()];
    claims.retain(|claim| {
        tested[claim.template] += 1;
        tested[claim.template] <= parameters.hypothesis.most
    });
    claims
}

/// For every template the cost of matching it unfolded.
fn unfolded_costs(seen: &Seen, templates: &[Outline], parameters: &Parameters) -> Vec<f64> {
    parallel::map(templates, |t| {
        let points = t.clone().positive().resample(parameters.shape_context.n_points);
        compare(seen, &points, None, parameters).map_or(f64::INFINITY, |(_, a)| a.cost)
    })
}

/// The least cost that any thread found.
struct LeastCost(AtomicU64);

impl Default for LeastCost {
    fn default() -> Self {
        Self(AtomicU64::new(f64::INFINITY.to_bits()))
    }
}

impl LeastCost {
    /// Costs are not negative, so they are ordered as their bits are.
    fn lower_to(&self, cost: f64) {
        self.0.fetch_min(cost.to_bits(), Ordering::Relaxed);
    }

    /// Alignments are bounded in single precision: what is no dearer than this may be the cheapest.
    fn with_margin(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed)) * (1.0 + 1e-4) + 1e-6
    }
}

impl Seen {
    /// Prepares an outline, in any units, for stages that are given the same parameters: what is prepared with some and
    /// compared with others cannot be compared.
    #[must_use]
    pub fn new(outline: Outline, parameters: &Parameters) -> Self {
        let outline = outline.positive();
        let points = outline.resample(parameters.shape_context.n_points);
        let inner = inner_distances(&points);
        let sides = creases_of(&outline, parameters);
        let mirror_sides = sides.iter().map(|s| mirrored_side(s, outline.length())).collect();
        let (n, delta) = (parameters.partial_match.points, parameters.partial_match.delta);
        let faces = [
            SampledFace::new(Face::Seen, &outline, sides, n, delta),
            SampledFace::new(Face::Mirrored, &outline.mirrored(), mirror_sides, n, delta),
        ];
        Self {
            contexts: shape_contexts(&points, &inner, &parameters.shape_context),
            mirrored_contexts: mirrored_shape_contexts(&points, &inner, &parameters.shape_context),
            points,
            faces,
            outline,
        }
    }

    /// The outline, wound positively.
    #[must_use]
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The equally spaced points that are aligned.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The candidate creases.
    #[must_use]
    pub fn sides(&self) -> &[Side] {
        &self.faces[0].sides
    }

    /// A mapped axis laid on the line of the side it lies along, if there is one: the outline knows the crease better
    /// than the map.
    fn snapped_crease(&self, mapped: &Segment) -> Segment {
        let Ok(axis) = Axis::new(mapped) else {
            return *mapped;
        };
        let reach = 0.15 * axis.length;
        let apart = |side: &Side| {
            let off = side.segment.map(|p| axis.side(&p).abs());
            let middle = axis.position(&nalgebra::center(&side.segment[0], &side.segment[1]));
            let beyond = (middle - axis.length / 2.0).abs() - axis.length / 2.0;
            off[0].max(off[1]).max(beyond)
        };
        let nearest = self.sides().iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        match nearest
            .filter(|side| apart(side) <= reach)
            .and_then(|side| Axis::new(&side.segment).ok())
        {
            Some(line) => mapped.map(|p| line.at(line.position(&p))),
            None => *mapped,
        }
    }
}

/// The sides of the outline that are long enough to be a crease, at every tolerance, and pairs of them in one line.
fn creases_of(outline: &Outline, parameters: &Parameters) -> Vec<Side> {
    let unit = outline.signed_area().abs().sqrt();
    let length = |s: &Side| (s.segment[1] - s.segment[0]).norm();
    let mut sides: Vec<Side> = Vec::new();
    for tolerance in &parameters.side.tolerances {
        for side in outline.sides(tolerance * unit) {
            if length(&side) >= parameters.side.shortest * unit && !sides.iter().any(|s| s.arc == side.arc) {
                sides.push(side);
            }
        }
    }
    let mut spanning = Vec::new();
    for one in &sides {
        for other in &sides {
            if let Some(segment) = in_one_line(one, other, parameters.side.in_line * unit) {
                // What lies between the two is no part of the crease: the longer one stands for it on the outline.
                let arc = if length(one) >= length(other) {
                    one.arc
                } else {
                    other.arc
                };
                spanning.push(Side { segment, arc });
            }
        }
    }
    sides.extend(spanning);
    sides
}

/// The segment from the start of one side to the end of another that follows it in the same line and direction: the
/// crease of a fold over two legs.
fn in_one_line(one: &Side, other: &Side, tolerance: f64) -> Option<Segment> {
    let segment = [one.segment[0], other.segment[1]];
    let line = Axis::new(&segment).ok()?;
    let [b, c] = [one.segment[1], other.segment[0]];
    let straight = line.side(&b).abs() <= tolerance && line.side(&c).abs() <= tolerance;
    let ordered = 0.0 < line.position(&b) && line.position(&b) < line.position(&c);
    (straight && ordered && line.position(&c) < line.length).then_some(segment)
}

/// The side on the mirrored outline.
fn mirrored_side(side: &Side, length: f64) -> Side {
    let [a, b] = side.segment.map(|p| Point::new(-p.x, p.y));
    let back = |s: f64| (length - s).rem_euclid(length);
    Side {
        segment: [b, a],
        arc: [back(side.arc[1]), back(side.arc[0])],
    }
}

/// Partial matches of both faces at every scale (section 2.1.1), and the hypotheses they make about the axis,
/// aggregated (section 2.1.2): template by template, the most confident first.
#[must_use]
pub fn claim_axes(
    seen: &Seen,
    templates: &[Outline],
    scale: Option<f64>,
    parameters: &Parameters,
) -> Vec<Claim> {
    let face = &seen.faces[0]; // both have the same length and number of points
    let spacing = face.length / face.points.len() as f64;
    let mut sizes = Vec::new();
    for (t, template) in templates.iter().enumerate() {
        let equal_area = (seen.outline.signed_area() / template.signed_area()).abs().sqrt();
        let (base, ratios) = match scale {
            Some(scale) => (scale, &parameters.partial_match.sizes),
            None => (equal_area, &parameters.partial_match.scales),
        };
        sizes.extend(ratios.iter().map(|r| (t, template, r * base)));
    }
    let sampled = parallel::map(&sizes, |&(_, template, scale)| {
        // A template far larger or smaller than what is seen cannot be it; the bound keeps the cost bounded.
        let n = (template.length() * scale / spacing)
            .round()
            .clamp(LEAST_POINTS as f64, 4.0 * face.points.len() as f64) as usize;
        let delta = parameters.partial_match.delta;
        SampledFace::new(Face::Seen, &template.clone().positive(), Vec::new(), n, delta)
    });
    let mut jobs = Vec::new();
    for (size, sampled) in sizes.iter().zip(&sampled) {
        jobs.extend(seen.faces.iter().map(|face| (size, sampled, face)));
    }
    let found = parallel::map(&jobs, |&(&(t, template, scale), sampled, face)| {
        let matches = partial_matches(&face.angles, &sampled.angles, &parameters.partial_match);
        let claims = hypotheses(
            face,
            template,
            sampled,
            &matches,
            1.0 / scale,
            &parameters.partial_match,
            &parameters.hypothesis,
        );
        (t, claims)
    });
    let mut by_template = vec![Vec::new(); templates.len()];
    for (t, claims) in found {
        by_template[t].extend(claims);
    }
    let mut all = Vec::new();
    for (t, claims) in by_template.iter().enumerate() {
        let merged = aggregate(claims, &templates[t], &parameters.hypothesis);
        all.extend(merged.into_iter().map(|hypothesis| Claim {
            template: t,
            hypothesis,
        }));
    }
    all
}

/// Folds the template over the axis and compares the outlines; `None` if the axis does not fold it, or the outlines
/// cost no less than the bound.
fn test(
    seen: &Seen,
    template: &Outline,
    claim: &Claim,
    bound: Option<f64>,
    parameters: &Parameters,
) -> Option<Candidate> {
    let axis = creased_extent(template, &claim.hypothesis.axis)?;
    let hypothesis = Hypothesis {
        axis,
        ..claim.hypothesis
    };
    let points: Vec<Point> = folded_points(template, &axis, parameters)?
        .iter()
        .map(|p| p.point)
        .collect();
    let (face, alignment) = compare(seen, &points, bound, parameters)?;
    Some(Candidate {
        template: claim.template,
        hypothesis,
        cost: alignment.cost,
        face,
    })
}

/// The axis cut to what it creases: from where it enters the outline first to where it leaves it last.
fn creased_extent(template: &Outline, axis: &Segment) -> Option<Segment> {
    let axis = Axis::new(axis).ok()?;
    let chords = creased_chords(template, &axis).ok()?;
    let (first, last) = (chords.first()?, chords.last()?);
    Some([axis.at(first.ends[0].position), axis.at(last.ends[1].position)])
}

/// Equally spaced points of the folded template, wound positively; `None` if the axis does not fold it.
fn folded_points(template: &Outline, axis: &Segment, parameters: &Parameters) -> Option<Vec<FoldedPoint>> {
    let mut points = fold(template, axis)
        .ok()?
        .resample(parameters.shape_context.n_points);
    if template.signed_area() < 0.0 {
        points.reverse();
    }
    Some(points)
}

/// The cheapest alignment of equally spaced points with the seen outline, either face up; `None` if it costs no less
/// than the bound.
fn compare(
    seen: &Seen,
    points: &[Point],
    bound: Option<f64>,
    parameters: &Parameters,
) -> Option<(Face, Alignment)> {
    let contexts = shape_contexts(points, &inner_distances(points), &parameters.shape_context);
    let mut best: Option<(Face, Alignment)> = None;
    for (face, other) in [
        (Face::Seen, &seen.contexts),
        (Face::Mirrored, &seen.mirrored_contexts),
    ] {
        let bound = best.as_ref().map(|b| b.1.cost).or(bound);
        if let Some(alignment) = align(&chi_squared(&contexts, other), &parameters.alignment, bound) {
            best = Some((face, alignment));
        }
    }
    best
}

/// Lays a fold of a template over the seen outline: correspondences, map and crease.
///
/// `None` if the axis does not fold the template, or too few points correspond.
#[must_use]
pub fn explain(
    seen: &Seen,
    template: &Outline,
    axis: &Segment,
    parameters: &Parameters,
) -> Option<Explanation> {
    let folded = folded_points(template, axis, parameters)?;
    let points: Vec<Point> = folded.iter().map(|p| p.point).collect();
    let (face, alignment) = compare(seen, &points, None, parameters)?;
    let n = seen.points.len();
    let mut partner = vec![None; points.len()];
    for &(row, column) in &alignment.pairs {
        let j = column as usize;
        partner[row as usize] = Some(if face == Face::Seen { j } else { n - 1 - j });
    }
    let to_seen = map_to_seen(&points, &partner, seen, face)?;
    let crease = seen.snapped_crease(&axis.map(|p| to_seen.apply(&p)));
    Some(Explanation {
        folded,
        partner,
        to_seen,
        crease,
        cost: alignment.cost,
    })
}

/// The similarity of the folded template onto the seen outline, reflecting for the mirrored face.
fn map_to_seen(points: &[Point], partner: &[Option<usize>], seen: &Seen, face: Face) -> Option<PlaneMap> {
    let flip = |p: &Point| {
        if face == Face::Seen {
            *p
        } else {
            Point::new(-p.x, p.y)
        }
    };
    let (from, to): (Vec<Point>, Vec<Point>) = points
        .iter()
        .zip(partner)
        .filter_map(|(p, j)| Some((*p, flip(&seen.points[(*j)?]))))
        .unzip();
    let mut map = PlaneMap::similarity(&from, &to, None)?;
    if face == Face::Mirrored {
        map.linear.row_mut(0).neg_mut();
        map.offset.x = -map.offset.x;
    }
    Some(map)
}
