//! Joint fit: the template's corners and the crease, solved for together.
//!
//! What the published iteration of matching and fitting approximates (section 2.2) is here one least-squares problem
//! a candidate: in the image the crease is a side of the outline, known to a few millimetres; unknown are where the
//! template's corners lie, and a small shift and turn of the crease. Sought are the corners of least deviation from the
//! template's shape, mirror symmetry and size whose outline, folded, explains the seen one: every seen point lies near
//! an edge of the kept part, the turned flap or the crease, and no edge sticks out of the seen outline. The folded
//! outline's union is not needed for that, so a candidate costs about a millisecond and all of them can be tried.
//!
//! Candidates are ranked by evidence, the probability of the outline under a template and crease with the corners
//! integrated out (Laplace's approximation), not by residual: a template with more corners does not win for its
//! freedom.

mod draw;
mod explain;
mod field;
mod flap;
mod layers;
mod nearest;
mod normal;
mod picture;
mod place;
mod problem;
mod region;
mod rim;
mod shape;
mod solve;
mod stack;
mod view;
mod way;

pub use draw::Draw;
pub use explain::{explain_from, explain_jointly, FoldCount, JointExplanation, JointFits, KnownFold};
pub use field::SeenField;
pub use picture::{Looks, Picture, PictureEvidence};
pub use shape::{mirrorings, FlexibleTemplate, Mirroring};
pub use solve::{JointFit, Start};

use self::picture::Sight;
use crate::crease::Axis;
use crate::hypothesis::{Face, Hypothesis};
use crate::parameters::FitParameters;
use crate::{parallel, Point, Segment};

/// Fits a template from every start, coarsely, and the most promising ones to the end; the best evidence first.
///
/// Starts that lose their crease on the way are left out. The result does not depend on the number of threads.
#[must_use]
pub fn fit_jointly(
    field: &SeenField,
    templates: &[FlexibleTemplate],
    starts: &[(usize, Start)],
    parameters: &FitParameters,
) -> Vec<(usize, JointFit)> {
    fit_starts(field, templates, starts, None, parameters)
}

/// As [`fit_jointly`], with what the picture says of every fit added to its evidence, and the rims of the best ones
/// where it shows them.
fn fit_starts(
    field: &SeenField,
    templates: &[FlexibleTemplate],
    starts: &[(usize, Start)],
    sight: Option<&Sight>,
    parameters: &FitParameters,
) -> Vec<(usize, JointFit)> {
    let of = |t: usize| &templates[t];
    let coarse = best_first(parallel::map(starts, |(t, start)| {
        solve::coarse(field, of(*t), start, parameters).map(|fit| (*t, fit))
    }));
    let coarse = promising(coarse, templates.len(), parameters);
    let mut fine = best_first(parallel::map(&coarse, |(t, fit)| {
        solve::fine(field, of(*t), fit, parameters).map(|fit| (*t, fit))
    }));
    let again = parallel::map(&fine[..fine.len().min(parameters.retried)], |(t, fit)| {
        solve::retried(field, of(*t), fit, parameters)
    });
    replace_first(&mut fine, again.into_iter().map(Some).collect());
    fine.sort_by(|a, b| a.1.surprise.total_cmp(&b.1.surprise));
    way::tried(field, templates, &mut fine, parameters);
    fine.sort_by(|a, b| a.1.surprise.total_cmp(&b.1.surprise));
    if let Some(sight) = sight {
        fine = best_first(parallel::map(&fine, |(t, fit)| {
            solve::with_picture(field, of(*t), fit, sight, parameters).map(|fit| (*t, fit))
        }));
        let few = fine.len().min(sight.region.placed);
        let placed = parallel::map(&fine[..few], |(t, fit)| {
            place::placed(field, of(*t), fit, sight, parameters)
        });
        replace_first(&mut fine, placed);
        fine.sort_by(|a, b| a.1.surprise.total_cmp(&b.1.surprise));
    }
    // Only the first few are ever shown.
    let shown: Vec<Option<JointFit>> =
        parallel::map(&fine[..fine.len().min(parameters.polished)], |(t, fit)| {
            solve::polished(field, of(*t), fit, parameters)
        });
    replace_first(&mut fine, shown);
    fine
}

/// Puts better fits, where there are any, in the place of the first ones.
fn replace_first(fits: &mut [(usize, JointFit)], better: Vec<Option<JointFit>>) {
    for (fit, better) in fits.iter_mut().zip(better) {
        if let Some(better) = better {
            fit.1 = better;
        }
    }
}

/// The fits that led anywhere, the best evidence first.
fn best_first(fits: Vec<Option<(usize, JointFit)>>) -> Vec<(usize, JointFit)> {
    let mut fits: Vec<(usize, JointFit)> = fits.into_iter().flatten().collect();
    fits.sort_by(|a, b| a.1.surprise.total_cmp(&b.1.surprise));
    fits
}

/// The best of every template, for templates are compared only when they are fitted; starts that came to lie where a
/// better one does would end there as well, and leave no room for others.
fn promising(
    sorted: Vec<(usize, JointFit)>,
    templates: usize,
    parameters: &FitParameters,
) -> Vec<(usize, JointFit)> {
    let mut kept: Vec<Vec<JointFit>> = vec![Vec::new(); templates];
    for (t, fit) in sorted {
        let of_template = &mut kept[t];
        let room = of_template.len() < parameters.refined;
        if room
            && !of_template
                .iter()
                .any(|other| fit.lies_as(other, parameters.alike))
        {
            of_template.push(fit);
        }
    }
    let of_all = kept.into_iter().enumerate();
    of_all
        .flat_map(|(t, fits)| fits.into_iter().map(move |fit| (t, fit)))
        .collect()
}

/// The start a hypothesis about the axis gives: the template laid so that its axis covers the side that claims it.
///
/// `side` is that side of the seen outline, `scale` the expected number of seen units a template unit.
#[must_use]
pub fn start_from(hypothesis: &Hypothesis, side: &Segment, scale: f64) -> Option<Start> {
    start_over(&hypothesis.axis, hypothesis.face, side, scale)
}

/// The same of an axis, with the kept part on its left, and a face.
fn start_over(on_template: &Segment, face: Face, side: &Segment, scale: f64) -> Option<Start> {
    let axis = Axis::new(on_template).ok()?;
    let crease = Axis::new(side).ok()?;
    let reflected = face == Face::Mirrored;
    // The mirrored outline runs the other way round, and with it its sides.
    let direction = if reflected {
        -crease.direction
    } else {
        crease.direction
    };
    let template = if reflected {
        nalgebra::Vector2::new(-axis.direction.x, axis.direction.y)
    } else {
        axis.direction
    };
    let turn = direction.y.atan2(direction.x) - template.y.atan2(template.x);
    let middle = |s: &Segment| nalgebra::center(&s[0], &s[1]);
    Some(Start {
        sides: vec![*side],
        anchor: middle(on_template),
        target: middle(side),
        turn,
        scale,
        reflected,
    })
}

/// The template unfolded, fitted from all directions and both faces; the best evidence.
///
/// What a fold has to beat: the seen outline explained without any.
#[must_use]
pub fn fit_unfolded(
    field: &SeenField,
    template: &FlexibleTemplate,
    target: Point,
    scale: f64,
    parameters: &FitParameters,
) -> Option<JointFit> {
    let steps = parameters.directions;
    let start = |k: usize| Start {
        sides: Vec::new(),
        anchor: template.centre,
        target,
        turn: std::f64::consts::TAU * (k / 2) as f64 / steps as f64,
        scale,
        reflected: k % 2 == 1,
    };
    let starts: Vec<(usize, Start)> = (0..2 * steps).map(|k| (0, start(k))).collect();
    let few = FitParameters {
        refined: 3,
        ..parameters.clone()
    };
    let fits = fit_jointly(field, std::slice::from_ref(template), &starts, &few);
    fits.into_iter().next().map(|(_, fit)| fit)
}

/// The points of a closed ring at equal distances with the directions of the ring there.
pub(crate) fn samples(outline: &crate::Outline, n: usize) -> Vec<(Point, nalgebra::Vector2<f64>)> {
    let step = outline.length() / n as f64;
    (0..n)
        .map(|k| {
            let s = (k as f64 + 0.5) * step;
            let d = outline.at(s + 0.5 * step) - outline.at(s - 0.5 * step);
            (
                outline.at(s),
                d.try_normalize(0.0).unwrap_or_else(nalgebra::Vector2::x),
            )
        })
        .collect()
}
