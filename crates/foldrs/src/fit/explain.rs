//! The joint fit of all templates to a seen outline, from the claims about its axis to explanations.

use super::draw::{self, Draw};
use super::picture::{Picture, PictureEvidence, Sight};
use super::{
    fit_starts, fit_unfolded, flap, stack, start_from, start_over, FlexibleTemplate, JointFit, SeenField,
    Start,
};
use crate::crease::Axis;
use crate::hypothesis::Face;
use crate::matching::{Claim, Seen};
use crate::parameters::{FitParameters, Parameters};
use crate::registration::PlaneMap;
use crate::{parallel, Outline, Point, Segment};
use nalgebra::Matrix2;
use std::borrow::Cow;

/// A template fitted jointly with its creases, in the units of the seen outline and of the template.
///
/// Creases and axes are in the frame of the part that no fold turns over: each lies where it did when its fold was made.
/// Of one fold the flap is the smaller part: which of the two was turned over cannot be seen.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointExplanation {
    /// Index of the template.
    pub template: usize,
    /// Corners of the fitted template in template units, in the order of the template given.
    pub outline: Vec<Point>,
    /// The fold axes on it, first made first; the flap is on their left.
    pub axes: Vec<Segment>,
    /// Map of the fitted template onto the seen outline; reflecting if the garment shows its other face.
    pub to_seen: PlaneMap,
    /// The creases on the seen outline, first made first; the flap was on their left.
    pub creases: Vec<Segment>,
    /// Minus log evidence, in nats; comparable between templates and numbers of folds.
    pub surprise: f64,
    /// The part of the evidence that comes from the picture.
    pub picture: PictureEvidence,
    /// Share of the cloth that the folds turn over, of each fold the smaller part.
    pub turned: f64,
    /// The same garment drawn from what is as likely; none of all but the best explanations
    /// ([`FitParameters::polished`] of them).
    pub draws: Vec<Draw>,
}

impl JointExplanation {
    /// The same with what is turned over and what is kept interchanged: folded, both look and lie the same.
    fn other_way_round(mut self) -> Option<Self> {
        let crease = Axis::new(self.creases.first()?).ok()?;
        let mirror = crease.direction * crease.direction.transpose() * 2.0 - Matrix2::identity();
        self.to_seen = PlaneMap {
            linear: mirror * self.to_seen.linear,
            offset: crease.reflect(&Point::from(self.to_seen.offset)).coords,
        };
        self.axes.iter_mut().for_each(|axis| axis.reverse());
        self.picture.flap_on_top = -self.picture.flap_on_top;
        Some(self)
    }
}

/// How many folds to undo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FoldCount {
    /// So many.
    Exactly(usize),
    /// As many as explain more than their freedom costs, at most so many.
    UpTo(usize),
}

/// What the joint fit found.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointFits {
    /// For every number of folds tried, from none on, what explains the outline, the best evidence first.
    pub by_folds: Vec<Vec<JointExplanation>>,
    /// Share of the cloth that folds must turn over for the garment to count as folded.
    pub least_turned: f64,
}

impl JointFits {
    /// Surprise of the best explanation by so many folds; infinite if there is none.
    #[must_use]
    pub fn surprise(&self, folds: usize) -> f64 {
        let best = self
            .by_folds
            .get(folds)
            .and_then(|explanations| explanations.first());
        best.map_or(f64::INFINITY, |best| best.surprise)
    }

    /// The number of folds that explain the outline best; further ones explain no more than their freedom costs.
    /// None where they turn over next to nothing: a corner turned in or a bent hem leaves a garment flat.
    #[must_use]
    pub fn enough(&self) -> usize {
        let tried = 0..self.by_folds.len();
        let likeliest = tried.min_by(|&a, &b| self.surprise(a).total_cmp(&self.surprise(b)));
        let turned = |folds: &usize| self.by_folds[*folds].first().map_or(0.0, |best| best.turned);
        likeliest
            .filter(|folds| turned(folds) >= self.least_turned)
            .unwrap_or(0)
    }
}

/// Fits every template jointly with its creases, from all claims; the best evidence first.
///
/// `scale` is the number of seen units a template unit, if known; `picture` what was seen within the outline, in the
/// same coordinates, if there is a picture.
#[must_use]
pub fn explain_jointly(
    seen: &Seen,
    templates: &[FlexibleTemplate],
    claims: &[Claim],
    scale: Option<f64>,
    picture: Option<&Picture>,
    folds: FoldCount,
    parameters: &Parameters,
) -> JointFits {
    let Some(search) = Search::new(seen, templates, scale, &parameters.fit) else {
        return JointFits::default();
    };
    let sight = search.sight(picture, parameters);
    let mut found = JointFits {
        by_folds: vec![search.told(&search.unfolded(), 0)],
        least_turned: parameters.fit.least_turned,
    };
    let (most, all) = match folds {
        FoldCount::Exactly(count) => (count, true),
        FoldCount::UpTo(most) => (most, false),
    };
    let mut starts = search.starts(claims);
    for count in 1..=most {
        let fits = search.fits(&starts, sight.as_ref());
        found.by_folds.push(search.told(&fits, count));
        // One fold alone may explain little of a garment folded twice, so two are always tried.
        if count == most || !(all || count == 1 || found.enough() == count) {
            break;
        }
        starts = search.further(&starts, &fits);
    }
    found
}

/// A fold that is known beforehand, for instance because the garment was folded on purpose.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KnownFold {
    /// Index of the template.
    pub template: usize,
    /// The axis on it, with the kept part on its left.
    pub axis: Segment,
    /// The crease on the seen outline, with the cloth on its left.
    pub crease: Segment,
    /// Whether the garment shows its other face.
    pub face: Face,
}

/// As [`explain_jointly`], from folds known beforehand instead of claims; the best evidence first.
///
/// If one of them ends better than anything that was found without, the search has missed it.
#[must_use]
pub fn explain_from(
    seen: &Seen,
    templates: &[FlexibleTemplate],
    known: &[KnownFold],
    scale: Option<f64>,
    picture: Option<&Picture>,
    parameters: &Parameters,
) -> Vec<JointExplanation> {
    let Some(search) = Search::new(seen, templates, scale, &parameters.fit) else {
        return Vec::new();
    };
    let sight = search.sight(picture, parameters);
    let start = |fold: &KnownFold| {
        if !search.may_be(fold.template) {
            return None;
        }
        let crease = fold.crease.map(|p| p / search.working);
        let start = start_over(&fold.axis, fold.face, &crease, search.expected(fold.template, 1))?;
        Some((fold.template, start))
    };
    let starts: Vec<(usize, Start)> = known.iter().filter_map(start).collect();
    search.told(&search.fits(&starts, sight.as_ref()), 1)
}

/// The joint fit of one seen outline, in working units: template units, as far as the scale is known.
struct Search<'a> {
    /// As they look from where the picture may have been taken.
    templates: Cow<'a, [FlexibleTemplate]>,
    scale: Option<f64>,
    parameters: FitParameters,
    /// Seen units a working unit.
    working: f64,
    field: SeenField,
    centroid: Point,
    /// The candidate creases.
    sides: Vec<Segment>,
}

impl<'a> Search<'a> {
    fn new(
        seen: &Seen,
        templates: &'a [FlexibleTemplate],
        scale: Option<f64>,
        parameters: &FitParameters,
    ) -> Option<Self> {
        if templates.is_empty() {
            return None;
        }
        let area = seen.outline().signed_area().abs();
        let mean_unit = templates.iter().map(|t| t.area.sqrt()).sum::<f64>() / templates.len() as f64;
        let working = scale.unwrap_or((parameters.hidden * area).sqrt() / mean_unit);
        let outline = scaled(seen.outline(), 1.0 / working)?;
        let growth = match scale {
            Some(_) => parameters.growth,
            None => parameters.free_growth,
        };
        // A scale is that of one distance: the picture was then taken from straight above, or made so.
        let templates = match scale {
            Some(_) => Cow::Borrowed(templates),
            None => templates
                .iter()
                .map(|t| t.clone().seen_at_an_angle(parameters.view))
                .collect(),
        };
        Some(Self {
            templates,
            scale,
            working,
            field: SeenField::new(&outline, parameters.samples, parameters.nodes),
            centroid: outline.centroid(),
            sides: seen
                .sides()
                .iter()
                .map(|s| s.segment.map(|p| p / working))
                .collect(),
            parameters: FitParameters {
                growth,
                ..parameters.clone()
            },
        })
    }

    /// What the picture shows, if there is one.
    fn sight<'b>(&self, picture: Option<&'b Picture>, parameters: &'b Parameters) -> Option<Sight<'b>> {
        Sight::new(picture?, self.working, &self.field, parameters)
    }

    /// The fits from starts, the best evidence first.
    fn fits(&self, starts: &[(usize, Start)], sight: Option<&Sight>) -> Vec<(usize, JointFit)> {
        fit_starts(&self.field, &self.templates, starts, sight, &self.parameters)
    }

    /// Expected number of working units a unit of a template folded so many times.
    fn expected(&self, template: usize, folds: i32) -> f64 {
        let whole = self.parameters.hidden.powi(folds) * self.field.area;
        self.scale
            .map_or(ratio(whole, self.templates[template].area), |_| 1.0)
    }

    /// Whether what is seen may be this template, by its size where the scale is known. Others would cost as much time as
    /// they are larger.
    fn may_be(&self, template: usize) -> bool {
        self.templates.get(template).is_some_and(|t| {
            let larger = ratio(t.area, self.field.area);
            let most = self.parameters.most_larger;
            self.scale.is_none() || (1.0 / most..=most).contains(&larger)
        })
    }

    /// Every template unfolded: what a fold has to beat. The picture has nothing to say there: chance made its edges.
    fn unfolded(&self) -> Vec<(usize, JointFit)> {
        let fit = |t: usize| {
            let expected = self.expected(t, 0);
            let fit = fit_unfolded(
                &self.field,
                &self.templates[t],
                self.centroid,
                expected,
                &self.parameters,
            );
            Some((t, fit?))
        };
        let mut fits: Vec<(usize, JointFit)> = (0..self.templates.len())
            .filter(|&t| self.may_be(t))
            .filter_map(fit)
            .collect();
        fits.sort_by(|a, b| a.1.surprise.total_cmp(&b.1.surprise));
        fits
    }

    /// The starts the claims about the axis of one fold give.
    fn starts(&self, claims: &[Claim]) -> Vec<(usize, Start)> {
        let mut starts = Vec::with_capacity(claims.len());
        let mut tried = vec![0; self.templates.len()];
        for claim in claims {
            let t = claim.template;
            if !self.may_be(t) {
                continue;
            }
            tried[t] += 1;
            if tried[t] > self.parameters.starts {
                continue;
            }
            let side = self.sides.get(claim.hypothesis.side);
            let start = side.and_then(|side| start_from(&claim.hypothesis, side, self.expected(t, 1)));
            starts.extend(start.map(|start| (t, start)));
        }
        starts
    }

    /// Starts with one more fold than others and what was fitted from them.
    fn further(&self, starts: &[(usize, Start)], fits: &[(usize, JointFit)]) -> Vec<(usize, Start)> {
        let mut known = starts.to_vec();
        known.extend(
            fits.iter()
                .map(|(t, fit)| (*t, stack::start_of(fit, &self.templates[*t]))),
        );
        let growth = self.scale.map_or(self.parameters.hidden.sqrt(), |_| 1.0);
        let more = stack::extended(&known, &self.sides, growth, &self.parameters);
        stack::promising(&self.field, &self.templates, more, &self.parameters)
    }

    /// Fits as explanations by so many folds, the best evidence first.
    fn told(&self, fits: &[(usize, JointFit)], folds: usize) -> Vec<JointExplanation> {
        // Which side is the crease is one more thing to be told; of an earlier fold, also where it was seen.
        // A known fold may have none.
        let (sides, p) = ((self.sides.len().max(1) as f64).ln(), &self.parameters);
        let further = folds.saturating_sub(1) as f64 * (sides + stack::WAYS.ln() + p.further_fold);
        let choice = if folds > 0 {
            sides + p.first_fold + further
        } else {
            0.0
        };
        // Only the first few are ever told in full.
        let fits: Vec<(bool, &(usize, JointFit))> = fits
            .iter()
            .enumerate()
            .map(|(k, fit)| (k < p.polished, fit))
            .collect();
        let told = parallel::map(&fits, |(drawn, (t, fit))| self.explained(*t, fit, choice, *drawn));
        let mut told: Vec<JointExplanation> = told.into_iter().flatten().collect();
        told.sort_by(|a, b| a.surprise.total_cmp(&b.surprise));
        told
    }

    /// A fit as an explanation that costs so much more, with garments drawn from what is as likely or without.
    fn explained(&self, t: usize, fit: &JointFit, choice: f64, drawn: bool) -> Option<JointExplanation> {
        let (template, p) = (&self.templates[t], &self.parameters);
        let shares = flap::shares(&fit.ring, &fit.creases, p.covered).unwrap_or_default();
        let interchanged = matches!(shares[..], [turned] if turned > 0.5);
        let told = |fit: &JointFit| {
            let told = explanation(t, template, fit, self.working, self.scale.is_some())?;
            if interchanged {
                told.other_way_round()
            } else {
                Some(told)
            }
        };
        let one = told(fit)?;
        let draws = if drawn {
            draw::drawn(&self.field, template, fit, p)
        } else {
            Vec::new()
        };
        Some(JointExplanation {
            surprise: one.surprise + choice + flap::surprise(&shares, p.flap),
            turned: flap::smaller(&shares).sum(),
            draws: draws.iter().filter_map(told).map(|one| Draw::of(&one)).collect(),
            ..one
        })
    }
}

/// Ratio of lengths of two areas.
fn ratio(a: f64, b: f64) -> f64 {
    (a / b).sqrt()
}

fn scaled(outline: &Outline, factor: f64) -> Option<Outline> {
    Outline::new(outline.points().iter().map(|p| p * factor).collect()).ok()
}

fn explanation(
    template: usize,
    flexible: &FlexibleTemplate,
    fit: &JointFit,
    working: f64,
    known_scale: bool,
) -> Option<JointExplanation> {
    // With a known scale the garment's own size belongs to the fitted template, else to the map.
    let (own, map_scale) = if known_scale {
        (fit.scale, 1.0)
    } else {
        (1.0, fit.scale)
    };
    let corners: Vec<Point> = fit
        .corners
        .iter()
        .map(|c| flexible.centre + c.coords * own)
        .collect();
    let outline = flexible.bent(&corners);
    let (s, c) = fit.turn.sin_cos();
    let mirror = if fit.start.reflected { -1.0 } else { 1.0 };
    let linear = Matrix2::new(c * mirror, -s, s * mirror, c) * (map_scale * working);
    let first = fit.ring.first()? * working;
    let to_seen = PlaneMap {
        linear,
        offset: first.coords - linear * corners.first()?.coords,
    };
    let creases: Vec<Segment> = fit.creases.iter().map(|c| c.map(|p| p * working)).collect();
    let back = to_seen.inverse()?;
    let axis = |crease: &Segment| {
        let axis = crease.map(|p| back.apply(&p));
        // A reflection swaps left and right.
        if fit.start.reflected {
            [axis[1], axis[0]]
        } else {
            axis
        }
    };
    Some(JointExplanation {
        template,
        outline,
        axes: creases.iter().map(axis).collect(),
        to_seen,
        creases,
        surprise: fit.surprise,
        picture: fit.picture,
        turned: 0.0,
        draws: Vec::new(),
    })
}
