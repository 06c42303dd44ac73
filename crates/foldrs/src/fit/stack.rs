//! Starts for several folds: what explains the outline with fewer folds, folded once more over another of its sides.
//!
//! The last fold's crease lies on the outline. Of an earlier one a part does: where the cloth beside it was not turned
//! any more, or where the last fold carried it to. So every side is tried as the crease of a further fold, made
//! before or after the others, seen where it was made or turned over with the last flap. Most of these stacks explain
//! nothing; their cost as they stand tells which are worth fitting.

use super::solve::{self, JointFit, Start};
use super::{FlexibleTemplate, SeenField};
use crate::crease::Axis;
use crate::parameters::FitParameters;
use crate::{parallel, Segment};

/// Ways in which a further side may join a stack of creases.
pub(super) const WAYS: f64 = 4.0;

/// All starts with one more of the sides as a crease; `growth` is how much larger than before the garment is then
/// expected to be.
pub(super) fn extended(
    starts: &[(usize, Start)],
    sides: &[Segment],
    growth: f64,
    parameters: &FitParameters,
) -> Vec<(usize, Start)> {
    let mut further = Vec::with_capacity(4 * starts.len() * sides.len());
    for (template, start) in starts {
        for side in sides {
            for creases in stacks(&start.sides, side, parameters.shift) {
                let start = Start {
                    sides: creases,
                    scale: start.scale * growth,
                    ..start.clone()
                };
                further.push((*template, start));
            }
        }
    }
    further
}

/// The stacks of creases that one more side may make of some.
fn stacks(creases: &[Segment], side: &Segment, same: f64) -> Vec<Vec<Segment>> {
    let Some(last) = creases.last() else {
        return vec![vec![*side]];
    };
    let (Ok(by_last), Ok(by_side)) = (Axis::new(last), Axis::new(side)) else {
        return Vec::new();
    };
    if creases.iter().any(|c| in_line(c, &by_side, same)) {
        return Vec::new();
    }
    let one = std::slice::from_ref(side);
    vec![
        [creases, one].concat(),
        [&carried(creases, &by_side)[..], one].concat(),
        [one, creases].concat(),
        [&carried(one, &by_last)[..], creases].concat(),
    ]
}

/// Creases seen on the last fold's flap where they lay before; the cloth stays on their left.
fn carried(creases: &[Segment], last: &Axis) -> Vec<Segment> {
    creases
        .iter()
        .map(|c| [last.reflect(&c[1]), last.reflect(&c[0])])
        .collect()
}

/// Whether a crease lies on a line.
fn in_line(crease: &Segment, line: &Axis, tolerance: f64) -> bool {
    crease.iter().all(|p| line.side(p).abs() <= tolerance)
}

/// A fit as a start: its pose and creases, the template's own shape.
pub(super) fn start_of(fit: &JointFit, template: &FlexibleTemplate) -> Start {
    Start {
        sides: fit.creases.iter().map(|c| [c[1], c[0]]).collect(),
        anchor: template.centre,
        target: fit.centre,
        turn: fit.turn,
        ..fit.start.clone()
    }
}

/// The starts of every template whose folded outline explains the seen one best as it stands.
pub(super) fn promising(
    field: &SeenField,
    templates: &[FlexibleTemplate],
    starts: Vec<(usize, Start)>,
    parameters: &FitParameters,
) -> Vec<(usize, Start)> {
    let costs = parallel::map(&starts, |(t, start)| {
        solve::cost(field, &templates[*t], start, parameters)
    });
    let mut ranked: Vec<(f64, (usize, Start))> = costs
        .into_iter()
        .zip(starts)
        .filter_map(|(cost, start)| Some((cost?, start)))
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept = vec![0; templates.len()];
    ranked.retain(|(_, (t, _))| {
        kept[*t] += 1;
        kept[*t] <= parameters.starts
    });
    ranked.into_iter().map(|(_, start)| start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;

    fn side(from: (f64, f64), to: (f64, f64)) -> Segment {
        [Point::new(from.0, from.1), Point::new(to.0, to.1)]
    }

    #[test]
    fn a_further_crease_is_tried_in_every_order_and_place() {
        let (first, second) = (side((0.0, 0.0), (10.0, 0.0)), side((10.0, 0.0), (10.0, 8.0)));
        let stacks = stacks(&[first], &second, 0.5);
        assert_eq!(stacks.len(), 4);
        assert!(stacks.iter().all(|s| s.len() == 2));
        // Turned over the second crease, the first one runs on beyond it, the cloth still on its left.
        assert_eq!(stacks[1], vec![side((10.0, 0.0), (20.0, 0.0)), second]);
        assert_eq!(stacks[3], vec![side((10.0, -8.0), (10.0, 0.0)), first]);
    }

    #[test]
    fn one_line_is_creased_once() {
        let first = side((0.0, 0.0), (10.0, 0.0));
        assert!(stacks(&[first], &side((12.0, 0.2), (20.0, 0.2)), 0.5).is_empty());
    }
}
