//! Several folds: layers of cloth cut and turned over, fold after fold.
//!
//! Every fold cuts each layer of cloth at the chords that its axis covers and turns over what hangs on their left;
//! a layer that it does not cut goes with the cloth it is creased to. One fold is a stack of one.
//!
//! All folds are told in the frame of the part that none of them turns over: a later fold does not move the axes of the
//! earlier ones.

use crate::crease::{Axis, Chord};
use crate::fold::{longest, turned_across, COVERED};
use crate::model::Region;
use crate::{FoldError, Outline, Point, Segment};

/// What a stretch of a rim is a piece of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Source {
    /// The template's edge from this corner to the next.
    Edge(usize),
    /// A crease, by its index in [`FoldedStack::creases`].
    Crease(usize),
}

/// The folds of a stack that turned a piece of cloth over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Turns(u32);

impl Turns {
    /// The most folds a stack may have.
    pub(crate) const MOST: usize = 32;

    /// Whether this fold, by its index, did.
    #[must_use]
    pub fn by(self, fold: usize) -> bool {
        fold < Self::MOST && self.0 & (1 << fold) != 0
    }

    fn and(self, fold: usize) -> Self {
        Self(self.0 | 1 << fold)
    }

    /// Only those after a fold.
    pub(crate) fn after(self, fold: usize) -> Self {
        Self(self.0 & !(u32::MAX >> (Self::MOST - 1 - fold)))
    }

    /// Whether the cloth shows its other face.
    pub(crate) fn over(self) -> bool {
        self.0.count_ones() % 2 == 1
    }
}

/// A crease of one layer of cloth.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Crease {
    /// The fold that made it.
    pub fold: usize,
    /// Its ends as the fold made it, in the axis's direction.
    pub ends: Segment,
}

/// An outline folded several times.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoldedStack {
    /// The axes it was folded over, first made first.
    pub axes: Vec<Axis>,
    /// The layers, the lowest first.
    pub layers: Vec<Cloth>,
    /// All creases, in the order they were made.
    pub creases: Vec<Crease>,
    /// The unfolded outline.
    unfolded: Outline,
}

/// Folds an outline over axis segments that have the flap on their left, the first made first.
///
/// A fold creases the chords it covers by half; of an earlier fold's segment, it is also enough if half of it lies on the
/// chord. `on_top` tells of every fold whether its flap comes to lie on top of the kept part; true where it is silent.
///
/// # Errors
/// [`FoldError::NoDirection`] for a segment without length, [`FoldError::NoCrease`] if a fold creases nothing,
/// [`FoldError::Tangled`] if an outline crosses itself at an axis, [`FoldError::TooManyFolds`] beyond 32.
pub fn fold_stack(
    outline: &Outline,
    segments: &[Segment],
    on_top: &[bool],
) -> Result<FoldedStack, FoldError> {
    let axes = segments.iter().map(Axis::new).collect::<Result<Vec<Axis>, _>>()?;
    let (layers, creases) = fold_ring(outline.points(), &axes, COVERED, on_top)?;
    Ok(FoldedStack {
        axes,
        layers,
        creases,
        unfolded: outline.clone(),
    })
}

impl FoldedStack {
    /// Outline of the union of all layers: its largest ring.
    ///
    /// # Errors
    /// [`FoldError::EmptyFlap`] if the layers enclose no area.
    pub fn outline(&self) -> Result<Outline, FoldError> {
        let ring = Region::union(&self.rings())
            .largest()
            .ok_or(FoldError::EmptyFlap)?;
        Outline::new(ring).map_err(|_| FoldError::EmptyFlap)
    }

    /// Where two layers or more lie over each other.
    #[must_use]
    pub fn double_layer(&self) -> Region {
        Region::doubled(&self.rings())
    }

    /// Where a point that belongs to the unfolded outline at an arc length, taken modulo its length, comes to lie.
    #[must_use]
    pub fn place(&self, point: &Point, arc: f64) -> Point {
        let turned = self.turns_at(arc);
        let over = self.axes.iter().enumerate().filter(|(k, _)| turned.by(*k));
        over.fold(*point, |p, (_, axis)| axis.reflect(&p))
    }

    /// Where the creases of a fold lie now, in the pieces that later folds left of them.
    #[must_use]
    pub fn creases_seen(&self, fold: usize) -> Vec<Segment> {
        // Both layers beside a crease share it; the one the fold kept tells of it.
        let kept = self.layers.iter().filter(|cloth| !cloth.turned.by(fold));
        let rims = kept.flat_map(|cloth| (0..cloth.rim.len()).map(move |i| (cloth, i)));
        let of_fold = rims.filter(|(cloth, i)| match cloth.rim[*i].source {
            Source::Crease(c) => self.creases.get(c).is_some_and(|crease| crease.fold == fold),
            Source::Edge(_) => false,
        });
        of_fold
            .map(|(cloth, i)| [cloth.rim[i].from, cloth.rim[(i + 1) % cloth.rim.len()].from])
            .collect()
    }

    /// The folds that turned over what the unfolded outline has at an arc length.
    fn turns_at(&self, arc: f64) -> Turns {
        let arc = arc.rem_euclid(self.unfolded.length());
        let points = self.unfolded.points();
        let after = (0..points.len()).rfind(|&i| self.unfolded.arc_of_vertex(i) <= arc);
        let edge = after.unwrap_or(0);
        let [a, b] = self.unfolded.edge(edge);
        let share = (arc - self.unfolded.arc_of_vertex(edge)) / (b - a).norm().max(f64::MIN_POSITIVE);
        let off = |s: &Stretch| {
            let of_edge = s.source == Source::Edge(edge);
            of_edge.then(|| (s.share[0] - share).max(share - s.share[1]))
        };
        let nearest = self.layers.iter().filter_map(|cloth| {
            let off = cloth.rim.iter().filter_map(off).min_by(f64::total_cmp)?;
            Some((off, cloth.turned))
        });
        nearest
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(Turns::default(), |found| found.1)
    }

    fn rings(&self) -> Vec<Vec<Point>> {
        self.layers.iter().map(Cloth::ring).collect()
    }
}

/// The layers of a ring folded over axes that have the flap on their left, the lowest first, and their creases.
///
/// A fold creases the chords of which its axis covers the share `covered`. Of an earlier fold's crease less may be
/// seen, so there it is enough if the chord covers that share of the axis.
pub(crate) fn fold_ring(
    ring: &[Point],
    axes: &[Axis],
    covered: f64,
    on_top: &[bool],
) -> Result<(Vec<Cloth>, Vec<Crease>), FoldError> {
    if axes.len() > Turns::MOST {
        return Err(FoldError::TooManyFolds(Turns::MOST));
    }
    if !ring.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
        return Err(FoldError::NoCrease);
    }
    let whole = (0..ring.len()).map(|i| Stretch {
        from: ring[i],
        source: Source::Edge(i),
        share: [0.0, 1.0],
    });
    let mut cloths = vec![Cloth {
        rim: whole.collect(),
        turned: Turns::default(),
    }];
    let mut creases = Vec::with_capacity(2 * axes.len());
    let forward = crate::outline::signed_area(ring) > 0.0;
    for (fold, axis) in axes.iter().enumerate() {
        let last = fold + 1 == axes.len();
        let creased = |c: &Chord| {
            let common = c.overlap(0.0, axis.length);
            let enough = if last {
                c.length()
            } else {
                c.length().min(axis.length)
            };
            c.length() > 0.0 && common >= covered * enough
        };
        let this = Fold { fold, axis, forward };
        let (kept, flap) = this.of_all(cloths, creased, &mut creases)?;
        // Turned over, what was on top of the flap comes to lie at its bottom.
        let flap = flap.into_iter().rev();
        cloths = if on_top.get(fold).copied().unwrap_or(true) {
            kept.into_iter().chain(flap).collect()
        } else {
            flap.chain(kept).collect()
        };
    }
    Ok((cloths, creases))
}

/// A piece of cloth between creases.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cloth {
    /// Its rim, closed.
    pub(crate) rim: Vec<Stretch>,
    /// The folds that turned it over.
    pub turned: Turns,
}

impl Cloth {
    /// The vertices of its rim where they lie now.
    #[must_use]
    pub fn ring(&self) -> Vec<Point> {
        self.rim.iter().map(|s| s.from).collect()
    }
}

/// A straight stretch of a rim, to where the next one begins.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Stretch {
    /// Where it begins, folded.
    pub(crate) from: Point,
    pub(crate) source: Source,
    /// The share of its source it begins and ends at.
    pub(crate) share: [f64; 2],
}

/// What a fold makes of one cloth.
enum Outcome {
    /// Parts, and whether each is turned over.
    Cut(Vec<(Cloth, bool)>),
    /// It stays whole.
    Whole(Cloth),
}

/// One of the folds.
struct Fold<'a> {
    fold: usize,
    axis: &'a Axis,
    /// Whether the unfolded ring is wound positively.
    forward: bool,
}

impl Fold<'_> {
    /// What it keeps and what it turns over, each in the order the cloths lay in.
    fn of_all(
        &self,
        cloths: Vec<Cloth>,
        creased: impl Fn(&Chord) -> bool,
        creases: &mut Vec<Crease>,
    ) -> Result<(Vec<Cloth>, Vec<Cloth>), FoldError> {
        let before = creases.len();
        let mut settled: Vec<(usize, Cloth, bool)> = Vec::with_capacity(2 * cloths.len());
        let mut whole = Vec::with_capacity(cloths.len());
        for (place, cloth) in cloths.into_iter().enumerate() {
            match self.cut(cloth, &creased, creases)? {
                Outcome::Cut(parts) => {
                    settled.extend(parts.into_iter().map(|(part, turn)| (place, part, turn)))
                }
                Outcome::Whole(cloth) => whole.push((place, cloth)),
            }
        }
        if creases.len() == before {
            return Err(FoldError::NoCrease);
        }
        // What is not cut goes with what it is creased to.
        while !whole.is_empty() {
            let found = whole.iter().enumerate().find_map(|(k, (_, cloth))| {
                let most = settled
                    .iter()
                    .map(|(_, other, turn)| (creased_together(cloth, other), *turn))
                    .max_by(|a, b| a.0.total_cmp(&b.0))?;
                (most.0 > 0.0).then_some((k, most.1))
            });
            let (k, turn) = found.unwrap_or((0, false));
            let (place, cloth) = whole.remove(k);
            settled.push((place, cloth, turn));
        }
        settled.sort_by_key(|(place, ..)| *place);
        let (flap, kept): (Vec<_>, Vec<_>) = settled.into_iter().partition(|(_, _, turn)| *turn);
        let flap = flap.into_iter().map(|(_, cloth, _)| self.turned(cloth));
        Ok((
            kept.into_iter().map(|(_, cloth, _)| cloth).collect(),
            flap.collect(),
        ))
    }

    fn turned(&self, mut cloth: Cloth) -> Cloth {
        for stretch in &mut cloth.rim {
            stretch.from = self.axis.reflect(&stretch.from);
        }
        cloth.turned = cloth.turned.and(self.fold);
        cloth
    }

    /// Cuts a cloth along the creased chords of an axis.
    fn cut(
        &self,
        cloth: Cloth,
        creased: impl Fn(&Chord) -> bool,
        creases: &mut Vec<Crease>,
    ) -> Result<Outcome, FoldError> {
        let (fold, axis) = (self.fold, self.axis);
        let points = cloth.ring();
        let positive = self.forward != cloth.turned.over();
        let mut chords = axis.chords_of(&points, positive)?;
        chords.retain(creased);
        if chords.is_empty() {
            return Ok(Outcome::Whole(cloth));
        }
        let first_crease = creases.len();
        creases.extend(chords.iter().map(|c| Crease {
            fold,
            ends: [axis.at(c.ends[0].position), axis.at(c.ends[1].position)],
        }));

        // Every stretch of the rim, cut at the chords; for the end of a chord which end of which.
        let mut nodes: Vec<(Stretch, Option<(usize, usize)>)> =
            Vec::with_capacity(points.len() + 2 * chords.len());
        let mut ends = vec![[0, 0]; chords.len()];
        let crossing = |i: usize| {
            let at = |(c, chord): (usize, &Chord)| (0..2).find(|&e| chord.ends[e].edge == i).map(|e| (c, e));
            chords.iter().enumerate().find_map(at)
        };
        for (i, stretch) in cloth.rim.iter().enumerate() {
            let Some((c, e)) = crossing(i) else {
                nodes.push((*stretch, None));
                continue;
            };
            let at = axis.at(chords[c].ends[e].position);
            let length = (points[(i + 1) % points.len()] - stretch.from).norm();
            let t = ((at - stretch.from).norm() / length.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let [from, to] = stretch.share;
            let middle = from + (to - from) * t;
            let begun = Stretch {
                share: [from, middle],
                ..*stretch
            };
            nodes.push((begun, None));
            ends[c][e] = nodes.len();
            let rest = Stretch {
                from: at,
                share: [middle, to],
                ..*stretch
            };
            nodes.push((rest, Some((c, e))));
        }

        let mut part_after = vec![usize::MAX; nodes.len()]; // the part that the rim belongs to from each node on
        let mut parts = Vec::with_capacity(chords.len() + 1);
        for first in 0..nodes.len() {
            if part_after[first] != usize::MAX {
                continue;
            }
            let mut rim = Vec::with_capacity(nodes.len());
            let mut k = first;
            loop {
                if part_after[k] != usize::MAX {
                    return Err(FoldError::Tangled);
                }
                part_after[k] = parts.len();
                rim.push(nodes[k].0);
                k = (k + 1) % nodes.len();
                if let (stretch, Some((c, e))) = nodes[k] {
                    rim.push(Stretch {
                        from: stretch.from,
                        source: Source::Crease(first_crease + c),
                        share: [e as f64, (1 - e) as f64],
                    });
                    k = ends[c][1 - e];
                }
                if k == first {
                    break;
                }
            }
            parts.push(Cloth {
                rim,
                turned: cloth.turned,
            });
        }
        // At the end of a chord the rim passes from one part to the other.
        let passed = |k: usize| [part_after[(k + nodes.len() - 1) % nodes.len()], part_after[k]];
        let across: Vec<[usize; 2]> = ends.iter().map(|e| passed(e[0])).collect();
        let longest = longest(&chords);
        let stays = across[longest][usize::from(!chords[longest].ends[0].to_left)];
        let turned = turned_across(&across, stays, parts.len());
        Ok(Outcome::Cut(parts.into_iter().zip(turned).collect()))
    }
}

/// How much of their creases two cloths share, in shares of a crease.
fn creased_together(one: &Cloth, other: &Cloth) -> f64 {
    let creased = |s: &&Stretch| matches!(s.source, Source::Crease(_));
    let range = |s: &Stretch| (s.share[0].min(s.share[1]), s.share[0].max(s.share[1]));
    let mut common = 0.0;
    for a in one.rim.iter().filter(creased) {
        for b in other.rim.iter().filter(|b| b.source == a.source) {
            let ((from, to), (first, last)) = (range(a), range(b));
            common += (to.min(last) - from.max(first)).max(0.0);
        }
    }
    common
}
