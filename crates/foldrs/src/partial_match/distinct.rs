//! Of matches that say nearly the same, the best.

use super::PartialMatch;

/// Offsets apart by at most so many points are neighbours.
const NEIGHBOURS: isize = 2;

/// Keeps the best of matches that overlap along the same or a neighbouring offset, at most `most`.
///
/// `found` comes best first; `m` and `n` are the numbers of points of both outlines.
pub(super) fn distinct(
    found: impl Iterator<Item = PartialMatch>,
    m: usize,
    n: usize,
    most: usize,
) -> Vec<PartialMatch> {
    let mut kept: Vec<PartialMatch> = Vec::new();
    let mut neighbours = Neighbours::new(m, n);
    for p in found {
        if kept.len() == most {
            break;
        }
        let others = neighbours.of(&p);
        match others.iter().position(|&k| overlap(&p, &kept[k], m, n)) {
            // The next ones along the offset will overlap with the same one.
            Some(found) => others.swap(0, found),
            None => {
                neighbours.add(&p, kept.len());
                kept.push(p);
            }
        }
    }
    kept
}

/// The matches kept so far, by the offsets they may overlap with: hardly one in ten is worth a closer look.
struct Neighbours {
    m: isize,
    n: isize,
    /// At `start - template_start + n` of a match: indices of those kept near its offset.
    near: Vec<Vec<usize>>,
}

impl Neighbours {
    fn new(m: usize, n: usize) -> Self {
        Self {
            m: m as isize,
            n: n as isize,
            near: vec![Vec::new(); m + n],
        }
    }

    fn offset(&self, p: &PartialMatch) -> isize {
        p.start as isize - p.template_start as isize + self.n
    }

    fn of(&mut self, p: &PartialMatch) -> &mut [usize] {
        let offset = self.offset(p);
        &mut self.near[offset as usize]
    }

    fn add(&mut self, p: &PartialMatch, index: usize) {
        // Both outlines close on themselves: a round of either more or less leads to the same pieces.
        for rounds in [-self.m, 0, self.m] {
            for template_rounds in [-self.n, 0, self.n] {
                let middle = self.offset(p) + rounds + template_rounds;
                for offset in middle - NEIGHBOURS..=middle + NEIGHBOURS {
                    let near = usize::try_from(offset).ok().and_then(|o| self.near.get_mut(o));
                    if let Some(near) = near.filter(|near| !near.contains(&index)) {
                        near.push(index);
                    }
                }
            }
        }
    }
}

/// Whether two matches say nearly the same: neighbouring offsets, more than half of the shorter one shared.
fn overlap(p: &PartialMatch, q: &PartialMatch, m: usize, n: usize) -> bool {
    let ahead = signed_steps(p.start, q.start, m);
    let template_ahead = signed_steps(p.template_start, q.template_start, n);
    if (ahead - template_ahead).abs() > NEIGHBOURS {
        return false;
    }
    let end = (p.length as isize).min(ahead + q.length as isize);
    2 * (end - ahead.max(0)) > p.length.min(q.length) as isize
}

/// Steps from one place of a ring of `n` to another, the shorter way; both places are below `n`.
fn signed_steps(from: usize, to: usize, n: usize) -> isize {
    let ahead = if to >= from { to - from } else { to + n - from };
    if 2 * ahead > n {
        ahead as isize - n as isize
    } else {
        ahead as isize
    }
}
