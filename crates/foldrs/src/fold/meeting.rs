//! Whether two edges cross, if there can be no doubt.

use crate::outline::distance_to_segment;
use crate::{Segment, Vector};

/// How two edges without a common end lie to each other.
pub(super) enum Meeting {
    Apart,
    Crossing,
    /// They touch or nearly do.
    Unclear,
}

/// How two edges lie to each other, neither of which is shorter than `clear`.
///
/// Signs are trusted only of what lies farther than `clear` from a line. That is some 10^8 times the rounding error, so
/// plain arithmetic is exact enough.
pub(super) fn meet([e, f]: [&Segment; 2], clear: f64) -> Meeting {
    let (u, v) = (e[1] - e[0], f[1] - f[0]);
    let away = f[0] - e[0];
    // Each end's distance from the other line, times that edge's length: positive on its left.
    let of_f = [u.perp(&away), u.perp(&(away + v))];
    let of_e = [-v.perp(&away), v.perp(&(u - away))];
    match (sides(of_f, u.norm() * clear), sides(of_e, v.norm() * clear)) {
        (Sides::Same, _) | (_, Sides::Same) => Meeting::Apart,
        (Sides::Both, Sides::Both) => Meeting::Crossing,
        _ => {
            let ends = [(e, &f[0]), (e, &f[1]), (f, &e[0]), (f, &e[1])];
            if ends
                .iter()
                .all(|(segment, end)| distance_to_segment(segment, end) > clear)
            {
                Meeting::Apart
            } else {
                Meeting::Unclear
            }
        }
    }
}

/// On which sides of a line the two ends of an edge lie.
enum Sides {
    Same,
    Both,
    Unclear,
}

fn sides([a, b]: [f64; 2], clear: f64) -> Sides {
    if !(a.abs() > clear && b.abs() > clear) {
        Sides::Unclear
    } else if (a > 0.0) == (b > 0.0) {
        Sides::Same
    } else {
        Sides::Both
    }
}

/// Whether two edges that leave a common end do so in directions that are told apart.
pub(super) fn part(u: &Vector, v: &Vector, clear: f64) -> bool {
    let longer = u.norm_squared().max(v.norm_squared());
    u.dot(v) < 0.0 || u.perp(v).powi(2) > longer * clear * clear
}
