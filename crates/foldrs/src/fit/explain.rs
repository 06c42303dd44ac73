//! The joint fit of all templates to a seen outline, from the claims about its axis to explanations.

use super::rim::{Picture, RimEvidence, Rims};
use super::{fit_starts, fit_unfolded, start_from, FlexibleTemplate, JointFit, SeenField, Start};
use crate::matching::{Claim, Seen};
use crate::parameters::{FitParameters, Parameters};
use crate::registration::PlaneMap;
use crate::{Outline, Point, Segment};
use nalgebra::Matrix2;

/// A template fitted jointly with its crease, in the units of the seen outline and of the template.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointExplanation {
    /// Index of the template.
    pub template: usize,
    /// Index of the claim it started from.
    pub claim: usize,
    /// Corners of the fitted template in template units, in the order of the template given.
    pub outline: Vec<Point>,
    /// The fold axis on it; the flap is on its left.
    pub axis: Segment,
    /// Map of the fitted template onto the seen outline; reflecting if the garment shows its other face.
    pub to_seen: PlaneMap,
    /// The crease on the seen outline; the flap was on its left.
    pub crease: Segment,
    /// Minus log evidence, in nats; comparable between templates.
    pub surprise: f64,
    /// The part of the evidence that comes from the picture.
    pub rim: RimEvidence,
}

/// What the joint fit found.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointFits {
    /// The folds that explain the outline, the best evidence first.
    pub folds: Vec<JointExplanation>,
    /// Surprise of the best fold's template unfolded: a fold is accepted only if its own is less.
    pub unfolded: f64,
}

/// Fits every template jointly with the crease, from all claims; the best evidence first.
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
    parameters: &Parameters,
) -> JointFits {
    let (parameters, rim) = (&parameters.fit, &parameters.rim);
    let mut found = JointFits {
        folds: Vec::new(),
        unfolded: f64::INFINITY,
    };
    if templates.is_empty() {
        return found;
    }
    let area = seen.outline().signed_area().abs();
    let mean_unit = templates.iter().map(|t| t.area.sqrt()).sum::<f64>() / templates.len() as f64;
    let working = scale.unwrap_or((parameters.hidden * area).sqrt() / mean_unit);
    let Some(outline) = scaled(seen.outline(), 1.0 / working) else {
        return found;
    };
    let field = SeenField::new(&outline, parameters.samples, parameters.nodes);
    let parameters = match scale {
        Some(_) => parameters.clone(),
        None => FitParameters {
            growth: parameters.free_growth,
            ..parameters.clone()
        },
    };

    let mut starts: Vec<(usize, Start)> = Vec::with_capacity(claims.len());
    let mut from = Vec::with_capacity(claims.len());
    let mut tried = vec![0; templates.len()];
    for (index, claim) in claims.iter().enumerate() {
        let t = claim.template;
        tried[t] += 1;
        if tried[t] > parameters.starts {
            continue;
        }
        let expected = scale.map_or(ratio(parameters.hidden * field.area, templates[t].area), |_| 1.0);
        let Some(side) = seen.sides().get(claim.hypothesis.side) else {
            continue;
        };
        let side = side.segment.map(|p| p / working);
        if let Some(start) = start_from(&claim.hypothesis, &side, expected) {
            starts.push((t, start));
            from.push((start, index));
        }
    }
    let rims = picture.and_then(|picture| Rims::new(picture, working, &field, rim));
    let fits = fit_starts(&field, templates, &starts, rims.as_ref(), &parameters);
    if let Some((t, _)) = fits.first() {
        let expected = scale.map_or(ratio(field.area, templates[*t].area), |_| 1.0);
        let unfolded = fit_unfolded(&field, &templates[*t], outline.centroid(), expected, &parameters);
        // Where nothing is folded the picture has nothing to say: chance made its edges.
        found.unfolded = unfolded.map_or(f64::INFINITY, |fit| fit.surprise);
    }
    // Which side is the crease is one more thing to be told.
    let choice = (seen.sides().len() as f64).ln();
    found.folds = fits
        .into_iter()
        .filter_map(|(t, fit)| {
            let same = |(start, i): &&(Start, usize)| *start == fit.start && claims[*i].template == t;
            let claim = from.iter().find(same)?.1;
            let told = explanation(t, claim, &templates[t], &fit, working, scale.is_some())?;
            Some(JointExplanation {
                surprise: told.surprise + choice,
                ..told
            })
        })
        .collect();
    found
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
    claim: usize,
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
    let crease = fit.crease.map(|p| p * working);
    let back = to_seen.inverse()?;
    let axis = crease.map(|p| back.apply(&p));
    // A reflection swaps left and right.
    let axis = if fit.start.reflected {
        [axis[1], axis[0]]
    } else {
        axis
    };
    Some(JointExplanation {
        template,
        claim,
        outline,
        axis,
        to_seen,
        crease,
        surprise: fit.surprise,
        rim: fit.rim,
    })
}
