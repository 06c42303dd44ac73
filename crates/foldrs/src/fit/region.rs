//! Evidence from the picture: the layer on top covers a region of its own look.
//!
//! A flap shows the cloth's other face, or its print the other way round, and lies in other light than what it covers.
//! Where a fold puts the layer on top, the looks within and without its rim should differ: what counts is how much the
//! one tells of the other (their mutual information), beyond what straight cuts through the same cloth give. A print
//! differs from place to place however it is cut, plain cloth differs nowhere.

use super::field::{Grid, SeenField};
use super::picture::Looks;
use crate::parameters::RegionParameters;
use crate::stack::Cloth;
use crate::{Point, Vector};

/// The looks of one garment, at the nodes of a grid over it.
#[derive(Debug)]
pub(super) struct Regions {
    low: Point,
    cell: f64,
    columns: usize,
    rows: usize,
    /// For every look, how many nodes of a row have it before a column; row by row, each of one more than the columns.
    before: Vec<Vec<f64>>,
    /// How many nodes have each look.
    all: Vec<f64>,
    /// So many observations: patches that look alike for reasons of their own.
    patches: f64,
    /// The share of what there is to tell that a straight cut tells by chance.
    chance: f64,
    /// Share of the cloth below which a region is too small.
    least: f64,
}

/// Fewest nodes of the grid within the cloth that tell anything.
const FEWEST: f64 = 50.0;
/// Directions of the chance cuts.
const DIRECTIONS: usize = 12;
/// Shares of the cloth they cut off.
const SHARES: [f64; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

impl Regions {
    /// `unit` is the number of seen units a working unit. `None` if there is too little cloth to tell.
    pub(super) fn new(
        looks: &Looks,
        unit: f64,
        field: &SeenField,
        parameters: &RegionParameters,
    ) -> Option<Self> {
        let grid = field.grid();
        let look = |(k, node): (usize, Point)| Some((k, looks.at(&(node * unit))?));
        let nodes: Vec<(usize, u8)> = field.nodes_within(parameters.inside).filter_map(look).collect();
        let kinds = nodes
            .iter()
            .map(|&(_, look)| usize::from(look) + 1)
            .max()
            .unwrap_or(0);
        let mut all = vec![0.0; kinds];
        let width = grid.columns + 1;
        let mut before = vec![vec![0.0; width * grid.rows]; kinds];
        for &(k, look) in &nodes {
            all[usize::from(look)] += 1.0;
            before[usize::from(look)][k / grid.columns * width + k % grid.columns + 1] += 1.0;
        }
        for row in before
            .iter_mut()
            .flat_map(|counts| counts.chunks_exact_mut(width))
        {
            let mut sum = 0.0;
            for count in row {
                sum += *count;
                *count = sum;
            }
        }
        let count: f64 = all.iter().sum();
        let mut regions = Self {
            low: grid.low,
            cell: grid.cell,
            columns: grid.columns,
            rows: grid.rows,
            before,
            all,
            patches: count * (grid.cell / parameters.patch).powi(2),
            chance: 0.0,
            least: parameters.least,
        };
        regions.chance = regions.by_chance(grid, &nodes, parameters.chance);
        (count >= FEWEST).then_some(regions)
    }

    /// What straight cuts of all directions tell, as shares of what they could; a quantile of it.
    fn by_chance(&self, grid: &Grid, nodes: &[(usize, u8)], quantile: f64) -> f64 {
        let mut told = Vec::with_capacity(DIRECTIONS * SHARES.len());
        for k in 0..DIRECTIONS {
            let (sin, cos) = (std::f64::consts::PI * k as f64 / DIRECTIONS as f64).sin_cos();
            let along = |&(k, look): &(usize, u8)| (grid.node(k).coords.dot(&Vector::new(cos, sin)), look);
            let mut order: Vec<(f64, u8)> = nodes.iter().map(along).collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (mut within, mut from) = (vec![0.0; self.all.len()], 0);
            for share in SHARES {
                let until = (share * order.len() as f64) as usize;
                for (_, look) in &order[from..until] {
                    within[usize::from(*look)] += 1.0;
                }
                from = until;
                let (here, most) = self.told(&within);
                if most > 0.0 {
                    told.push(here / most);
                }
            }
        }
        told.sort_by(f64::total_cmp);
        let place = quantile.clamp(0.0, 1.0) * told.len().saturating_sub(1) as f64;
        told.get(place.round() as usize).copied().unwrap_or(1.0)
    }

    /// Mutual information of look and region, and the most it could be (the region's own entropy), in nats a node.
    fn told(&self, within: &[f64]) -> (f64, f64) {
        let all: f64 = self.all.iter().sum();
        let inner: f64 = within.iter().sum();
        let outer = all - inner;
        if inner.min(outer) <= self.least * all {
            return (0.0, 0.0);
        }
        let mut told = 0.0;
        for (&inside, &of_look) in within.iter().zip(&self.all) {
            for (part, whole) in [(inside, inner), (of_look - inside, outer)] {
                if part > 0.0 {
                    told += part / all * (part * all / (whole * of_look)).ln();
                }
            }
        }
        let share = inner / all;
        (told, -share * share.ln() - (1.0 - share) * (1.0 - share).ln())
    }

    /// What the looks say of the flap lying on top, and of the kept part, in nats: nothing where one covers all or
    /// nothing. `last` is the fold made last.
    pub(super) fn gains(&self, cloths: &[Cloth], last: Option<usize>) -> [f64; 2] {
        let Some(last) = last else { return [0.0; 2] };
        [true, false].map(|flap| {
            let layer = cloths.iter().filter(|cloth| cloth.turned.by(last) == flap);
            let rings: Vec<Vec<Point>> = layer.map(Cloth::ring).collect();
            let (told, most) = self.told(&self.within(&rings));
            self.patches * (told - most * self.chance).max(0.0)
        })
    }

    /// How many nodes of each look lie within any of some rings.
    fn within(&self, rings: &[Vec<Point>]) -> Vec<f64> {
        let mut within = vec![0.0; self.all.len()];
        let (mut crossings, mut spans) = (Vec::with_capacity(8), Vec::with_capacity(8));
        for row in 0..self.rows {
            let y = self.low.y + row as f64 * self.cell;
            spans.clear();
            for ring in rings {
                crossings.clear();
                crossings.extend(crossings_of(ring, y).map(|x| self.column(x)));
                crossings.sort_unstable();
                spans.extend(crossings.chunks_exact(2).map(|pair| (pair[0], pair[1])));
            }
            spans.sort_unstable();
            let mut covered = 0;
            let at = row * (self.columns + 1);
            for &(from, to) in &spans {
                let (from, to) = (from.max(covered), to.max(covered));
                covered = to;
                for (count, before) in within.iter_mut().zip(&self.before) {
                    *count += before[at + to] - before[at + from];
                }
            }
        }
        within
    }

    /// The first column at or beyond a place.
    fn column(&self, x: f64) -> usize {
        ((x - self.low.x) / self.cell)
            .ceil()
            .clamp(0.0, self.columns as f64) as usize
    }
}

/// Where a closed ring crosses a line of equal y; an even number of places.
fn crossings_of(ring: &[Point], y: f64) -> impl Iterator<Item = f64> + '_ {
    let edges = (0..ring.len()).map(|i| (&ring[i], &ring[(i + 1) % ring.len()]));
    let crossed = edges.filter(move |(a, b)| (a.y > y) != (b.y > y));
    crossed.map(move |(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::layers::fold_layers;
    use crate::{crease::Axis, Outline};

    const SIZE: usize = 40;

    /// A cloth of 40 x 40 whose looks are a function of the place, folded over a line at x so that what lies right of it
    /// covers as much left of it.
    fn gains(look: impl Fn(usize, usize) -> u8, x: f64) -> [f64; 2] {
        let corners = |right: f64| {
            [(0.0, 0.0), (right, 0.0), (right, 40.0), (0.0, 40.0)].map(|(x, y)| Point::new(x, y))
        };
        let seen = Outline::new(corners(40.0).to_vec()).unwrap();
        let field = SeenField::new(&seen, 100, 64);
        let looks = Looks {
            width: SIZE,
            height: SIZE,
            look: (0..SIZE * SIZE).map(|k| look(k % SIZE, k / SIZE)).collect(),
            scale: 1.0,
            origin: Point::origin(),
        };
        let regions = Regions::new(&looks, 1.0, &field, &RegionParameters::default()).unwrap();
        // A sheet that reaches beyond the crease at 40, turned back to x.
        let sheet = corners(80.0 - x);
        let axis = Axis::new(&[Point::new(40.0, 40.0), Point::new(40.0, 0.0)]).unwrap();
        let layers = fold_layers(&sheet, &[axis], 0.5).unwrap();
        regions.gains(&layers.cloths, layers.last)
    }

    #[test]
    fn a_flap_of_another_look_is_told_where_it_lies() {
        let two_faces = |x: usize, _: usize| u8::from(x >= 24);
        let [right, kept] = gains(two_faces, 24.0);
        assert!(right > 20.0, "{right}");
        // The kept part covers all that is seen.
        assert_eq!(kept, 0.0);
        let [beside, _] = gains(two_faces, 14.0);
        assert!(beside < right / 2.0, "{beside} of {right}");
    }

    #[test]
    fn plain_cloth_and_cloth_that_differs_everywhere_tell_nothing() {
        assert_eq!(gains(|_, _| 3, 24.0), [0.0, 0.0]);
        let stripes = |x: usize, _: usize| (x / 2 % 2) as u8;
        assert!(gains(stripes, 24.0)[0] < 1.0);
        let light = |x: usize, _: usize| (x / 8) as u8;
        let ours = gains(light, 24.0)[0];
        assert!(ours < gains(|x, _| u8::from(x >= 24), 24.0)[0] / 2.0);
    }

    #[test]
    fn what_several_cloths_cover_counts_once() {
        let cloth = [(0.0, 0.0), (30.0, 0.0), (30.0, 40.0), (0.0, 40.0)].map(|(x, y)| Point::new(x, y));
        let seen = Outline::new(cloth.to_vec()).unwrap();
        let field = SeenField::new(&seen, 100, 64);
        let looks = Looks {
            width: SIZE,
            height: SIZE,
            look: (0..SIZE * SIZE).map(|k| (k % 3) as u8).collect(),
            scale: 1.0,
            origin: Point::origin(),
        };
        let regions = Regions::new(&looks, 1.0, &field, &RegionParameters::default()).unwrap();
        let part = |from: f64, to: f64| {
            [(from, -1.0), (to, -1.0), (to, 41.0), (from, 41.0)]
                .map(|(x, y)| Point::new(x, y))
                .to_vec()
        };
        let once = regions.within(&[part(3.0, 20.0)]);
        assert_eq!(regions.within(&[part(3.0, 14.0), part(8.0, 20.0)]), once);
        assert_eq!(regions.within(&[part(-50.0, 90.0)]), regions.all);
        assert!(once.iter().sum::<f64>() < regions.all.iter().sum());
    }
}
