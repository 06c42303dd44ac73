//! Which piece of the folded model's boundary every seen point is explained by.

use super::layers::Piece;
use crate::wide::{widest, Kernel};
use crate::{Point, Vector};

/// The nearest piece to a seen point, among those that run its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    /// Its index.
    pub piece: usize,
    /// The share of its source that the point is nearest to.
    pub t: f64,
    /// Squared distance that its direction counts as.
    pub opposed: f64,
}

/// The nearest piece to every sample; the first of equals.
///
/// A piece whose direction differs from the sample's, beyond `bend`, counts as farther away: by `against`, if it is
/// the opposite one.
pub(super) fn nearest_pieces(
    samples: &[(Point, Vector)],
    pieces: &[Piece],
    against: f64,
    bend: f64,
) -> Vec<Nearest> {
    let mut nearest = Vec::with_capacity(samples.len());
    for some in samples.chunks(LANES) {
        // The last block is filled up; what is found for these lanes is dropped.
        let lane = |lane: usize| &some[lane.min(some.len() - 1)];
        let found = widest(Block {
            x: std::array::from_fn(|k| lane(k).0.x),
            y: std::array::from_fn(|k| lane(k).0.y),
            along_x: std::array::from_fn(|k| lane(k).1.x),
            along_y: std::array::from_fn(|k| lane(k).1.y),
            pieces,
            against,
            bend,
        });
        nearest.extend_from_slice(&found[..some.len()]);
    }
    nearest
}

/// Samples looked at side by side.
const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Some samples and the directions of the outline there.
struct Block<'a> {
    x: Lanes,
    y: Lanes,
    along_x: Lanes,
    along_y: Lanes,
    pieces: &'a [Piece],
    against: f64,
    bend: f64,
}

impl Kernel for Block<'_> {
    type Output = [Nearest; LANES];

    #[inline(always)]
    fn run(self) -> [Nearest; LANES] {
        let (mut least, mut at, mut its_opposed) = ([f64::INFINITY; LANES], [0.0; LANES], [0.0; LANES]);
        let mut which = [0_u64; LANES];
        for (k, piece) in self.pieces.iter().enumerate() {
            let [from, to] = piece.ends;
            let length = piece.length.max(f64::MIN_POSITIVE);
            let along = (to - from) / length;
            for lane in 0..LANES {
                let cosine = piece.direction.x * self.along_x[lane] + piece.direction.y * self.along_y[lane];
                let against = 1.0 - cosine - self.bend;
                let against = if against > 0.0 { against } else { 0.0 };
                let opposed = 0.5 * self.against * self.against * against;
                let (x, y) = (self.x[lane] - from.x, self.y[lane] - from.y);
                let t = (x * along.x + y * along.y) / length;
                let t = if t < piece.share[0] { piece.share[0] } else { t };
                let t = if t > piece.share[1] { piece.share[1] } else { t };
                let far = t * piece.length;
                let (x, y) = (x - along.x * far, y - along.y * far);
                let squared = x * x + y * y + opposed;
                let nearer = squared < least[lane];
                least[lane] = if nearer { squared } else { least[lane] };
                at[lane] = if nearer { t } else { at[lane] };
                its_opposed[lane] = if nearer { opposed } else { its_opposed[lane] };
                which[lane] = if nearer { k as u64 } else { which[lane] };
            }
        }
        std::array::from_fn(|lane| Nearest {
            piece: which[lane] as usize,
            t: at[lane],
            opposed: its_opposed[lane],
        })
    }
}
