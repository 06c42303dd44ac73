//! Ways of folding: garments are folded along their mirror axis or at right angles to it, and in halves, more often than
//! anyhow.
//!
//! Where the flap is hidden its outline tells nothing, and how wide the garment is follows from how it is folded: in
//! halves it is twice as wide as what is seen. Every way is an explanation of its own, with a prior on how the crease
//! lies to the fitted corners, and competes by its evidence.

use super::normal::POSE;
use super::problem::{Problem, State};
use super::shape::FlexibleTemplate;
use super::solve::{self, JointFit};
use super::SeenField;
use crate::parameters::FitParameters;
use crate::{parallel, Vector};
use nalgebra::DVector;
use std::f64::consts::{PI, TAU};

/// How the first crease lies to the garment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Way {
    /// In any direction, at any place.
    #[default]
    Any,
    /// Along the mirror axis, beside it.
    Along,
    /// At right angles to the mirror axis.
    Across,
    /// On a mirror axis: the first, or the second of what is its own mirror image twice.
    Halves(usize),
}

/// A deviation of a crease from its way.
pub(super) struct Deviation {
    /// In radians or seen units.
    pub(super) value: f64,
    pub(super) spread: f64,
    /// How it changes with the variables, each of which occurs once.
    pub(super) row: Vec<(usize, f64)>,
}

impl Way {
    /// The ways of folding a template other than any.
    fn of(template: &FlexibleTemplate) -> Vec<Self> {
        let mut ways = Vec::new();
        if !template.mirrors.is_empty() {
            ways.extend([Self::Along, Self::Across]);
        }
        ways.extend((0..template.mirrors.len()).map(Self::Halves));
        ways
    }

    /// Minus log of how much likelier this way puts a crease where it expects it than if it lay anyhow within the
    /// garment.
    pub(super) fn surprise(self, template: &FlexibleTemplate, parameters: &FitParameters) -> f64 {
        let p = parameters;
        let mirrors = template.mirrors.len() as f64;
        if mirrors == 0.0 {
            return 0.0;
        }
        // The densities at their peaks, over those of any direction and of any place as wide as the garment.
        let turned = PI / (p.way_turn * TAU.sqrt());
        let shifted = 1.0 / (p.way_shift * TAU.sqrt());
        let likelier = match self {
            Self::Any => 1.0 - p.along - p.across - p.halves,
            Self::Along => p.along * turned,
            Self::Across => p.across * turned,
            Self::Halves(_) => p.halves / mirrors * turned * shifted,
        };
        -likelier.ln()
    }
}

impl Problem<'_> {
    /// How the first crease deviates from the way the garment is supposed to be folded: its turn from the pairs' common
    /// direction, of a fold in halves its distance from their middle as well.
    pub(super) fn deviations(&self, state: &State) -> Vec<Deviation> {
        let mirror = match self.way {
            Way::Any => return Vec::new(),
            Way::Halves(mirror) => mirror,
            Way::Along | Way::Across => 0,
        };
        let crease = self.axes(state).into_iter().next();
        let (Some(pairs), Some(crease)) = (self.template.mirrors.get(mirror), crease) else {
            return Vec::new();
        };
        let ring = self.ring(state);
        let across: Vector = pairs.iter().map(|&(i, j)| ring[j] - ring[i]).sum();
        let length = across.norm();
        if length <= 0.0 {
            return Vec::new();
        }
        let normal = crease.normal();
        let expected = if self.way == Way::Across {
            crease.direction
        } else {
            normal
        };
        // A line has no sense.
        let expected = expected * expected.dot(&across).signum();
        let n = state.displacement.len();
        let (shift, skew) = (n + POSE, n + POSE + 1);
        let back = self.linear(state.growth, state.turn).transpose();

        // Turned with the garment, less with the crease.
        let mut row = vec![(n + 1, 1.0), (skew, -1.0)];
        let by_corner = back * Vector::new(-across.y, across.x) / (length * length);
        for &(i, j) in pairs {
            row.extend(entries(j, by_corner));
            row.extend(entries(i, -by_corner));
        }
        let mut deviations = vec![Deviation {
            value: expected.perp(&across).atan2(expected.dot(&across)),
            spread: self.parameters.way_turn,
            row,
        }];
        if let Way::Halves(_) = self.way {
            let both = 2.0 * pairs.len() as f64;
            let middle: Vector = pairs
                .iter()
                .map(|&(i, j)| ring[i].coords + ring[j].coords)
                .sum::<Vector>()
                / both;
            let pivot = self.pivots(state)[0];
            let from_pivot = middle - pivot.coords;
            let v = middle - state.offset;
            let mut row = vec![
                (n, normal.dot(&v)),
                (n + 1, v.perp(&normal)),
                (n + 2, normal.x),
                (n + 3, normal.y),
                (shift, -normal.dot(&self.sides[0].0.normal())),
                (skew, -crease.direction.dot(&from_pivot)),
            ];
            for &(i, j) in pairs {
                row.extend(entries(i, back * normal / both));
                row.extend(entries(j, back * normal / both));
            }
            deviations.push(Deviation {
                value: normal.dot(&from_pivot),
                spread: self.parameters.way_shift * self.template.area.sqrt() * self.start.scale,
                row,
            });
        }
        deviations
    }
}

/// A row's entries of a corner.
fn entries(corner: usize, by: Vector) -> [(usize, f64); 2] {
    [(2 * corner, by.x), (2 * corner + 1, by.y)]
}

/// What the best fits become if their garments were folded in one of the ways they nearly lie in; the fits as they are
/// stay unless the same fold gets likelier.
pub(super) fn tried(
    field: &SeenField,
    templates: &[FlexibleTemplate],
    fits: &mut Vec<(usize, JointFit)>,
    parameters: &FitParameters,
) {
    let few = fits.len().min(parameters.ways_tried);
    let found = parallel::map(&fits[..few], |(t, fit)| {
        folded_so(field, &templates[*t], fit, parameters).unwrap_or_default()
    });
    for (k, found) in found.into_iter().enumerate() {
        for fit in found {
            let (t, first) = &mut fits[k];
            if !fit.lies_as(first, parameters.alike) {
                let t = *t;
                fits.push((t, fit));
            } else if fit.surprise < first.surprise {
                *first = fit;
            }
        }
    }
}

/// Nats by which a way may seem to fall short of the fit it starts from and still be tried.
const SHORT: f64 = 4.0;

/// The fit if its garment was folded in each of the ways that its crease lies near to; `None` if it has no crease.
fn folded_so(
    field: &SeenField,
    template: &FlexibleTemplate,
    fit: &JointFit,
    parameters: &FitParameters,
) -> Option<Vec<JointFit>> {
    fit.creases.first()?;
    let mut problem = Problem::new(field, template, fit.start.clone(), parameters)?;
    let here = problem.factored(&fit.state, parameters.noise)?;
    let anyhow = Way::Any.surprise(template, parameters);
    let mut found = Vec::new();
    for way in Way::of(template) {
        problem.way = way;
        // What the way would add if all were as linear as it is here.
        let mut short = way.surprise(template, parameters) - anyhow;
        for deviation in problem.deviations(&fit.state) {
            let mut row = DVector::zeros(here.gradient.len());
            for &(variable, by) in &deviation.row {
                row[variable] = by;
            }
            let open = row.dot(&here.factor.solve(&row));
            let variance = deviation.spread.powi(2) + open;
            short += 0.5 * (deviation.value.powi(2) / variance + (variance / deviation.spread.powi(2)).ln());
        }
        if short <= SHORT {
            found.extend(solve::settled(&problem, fit.state.clone()));
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::start_over;
    use crate::hypothesis::Face;
    use crate::{Outline, Point, Segment};
    use proptest::prelude::*;

    const AXIS: Segment = [Point::new(2.0, 0.0), Point::new(-1.0, 40.0)];

    fn towel() -> ([Point; 4], FlexibleTemplate) {
        let corners = [(-30.0, 0.0), (30.0, 0.0), (30.0, 40.0), (-30.0, 40.0)].map(|(x, y)| Point::new(x, y));
        let outline = Outline::new(corners.to_vec()).unwrap();
        let mirrored = [[corners[0], corners[1]], [corners[3], corners[2]]];
        let template = FlexibleTemplate::new(&outline, &mirrored, &FitParameters::default());
        (corners, template)
    }

    /// A problem of the towel folded over `AXIS`, laid so that it is creased there, or seen from behind.
    fn with_problem<T>(face: Face, look: impl FnOnce(Problem) -> T) -> T {
        let parameters = FitParameters::default();
        let (corners, template) = towel();
        let field = SeenField::new(&Outline::new(corners.to_vec()).unwrap(), 40, 16);
        let start = start_over(&AXIS, face, &AXIS, 1.1).unwrap();
        look(Problem::new(&field, &template, start, &parameters).unwrap())
    }

    proptest! {
        #[test]
        fn rows_are_how_deviations_change(
            mirrored in any::<bool>(),
            change in proptest::collection::vec(-0.2..0.2_f64, 8 + POSE + 2 + 4),
        ) {
            let face = if mirrored { Face::Mirrored } else { Face::Seen };
            with_problem(face, |mut problem| {
                let change = DVector::from_vec(change);
                let state = problem.shifted(&problem.initial(), &change);
                for way in Way::of(problem.template) {
                    problem.way = way;
                    for (k, deviation) in problem.deviations(&state).iter().enumerate() {
                        for variable in 0..change.len() {
                            let mut step = DVector::zeros(change.len());
                            step[variable] = 1e-5;
                            let there = problem.deviations(&problem.shifted(&state, &step))[k].value;
                            let back = problem.deviations(&problem.shifted(&state, &-step))[k].value;
                            let told = deviation.row.iter().find(|(v, _)| *v == variable).map_or(0.0, |r| r.1);
                            let mut change = there - back;
                            if k == 0 {
                                // The turn of a line: at right angles to its way it goes on from the other side.
                                change -= PI * (change / PI).round();
                            }
                            prop_assert!((change / 2e-5 - told).abs() < 1e-4, "{way:?} {variable}");
                        }
                    }
                }
                Ok(())
            })?;
        }
    }

    #[test]
    fn a_crease_deviates_from_its_way_by_what_it_is_off() {
        with_problem(Face::Seen, |mut problem| {
            let state = problem.initial();
            let mut values = |way| {
                problem.way = way;
                let told = problem.deviations(&state);
                told.iter().map(|d| d.value.abs()).collect::<Vec<f64>>()
            };
            let turn = (3.0_f64 / 40.0).atan();
            // The axis passes the towel's middle half a centimetre beside it; all is drawn 1.1 times as large.
            let beside = 1.1 * 0.5 * turn.cos();
            // The second mirror axis lies at right angles to the first.
            let right = std::f64::consts::FRAC_PI_2 - turn;
            for (way, expected) in [
                (Way::Any, vec![]),
                (Way::Along, vec![turn]),
                (Way::Across, vec![right]),
                (Way::Halves(0), vec![turn, beside]),
                (Way::Halves(1), vec![right, beside]),
            ] {
                let found = values(way);
                assert_eq!(found.len(), expected.len(), "{way:?}");
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((found - expected).abs() < 1e-9, "{way:?} {found} {expected}");
                }
            }
        });
    }

    #[test]
    fn ways_share_all_there_is() {
        let (_, template) = towel();
        let p = FitParameters::default();
        let likelier = |way: Way| (-way.surprise(&template, &p)).exp();
        let turned = p.way_turn * TAU.sqrt() / PI;
        let shifted = p.way_shift * TAU.sqrt();
        let halves = [0, 1].map(|m| likelier(Way::Halves(m)) * turned * shifted);
        let directions = [Way::Along, Way::Across].map(|way| likelier(way) * turned);
        let all = likelier(Way::Any) + halves.iter().sum::<f64>() + directions.iter().sum::<f64>();
        assert!((all - 1.0).abs() < 1e-9);
        // What has no mirror axis is folded anyhow.
        let (corners, _) = towel();
        let alone = FlexibleTemplate::new(&Outline::new(corners.to_vec()).unwrap(), &[], &p);
        assert_eq!(Way::of(&alone), []);
        assert_eq!(Way::Any.surprise(&alone, &p), 0.0);
    }
}
