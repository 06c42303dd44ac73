//! Exact triangulation of an outline by ear clipping.
//!
//! parry's bounding volume hierarchy finds the reflex vertices near an ear, exact predicates decide.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector as ParryVector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use robust::{orient2d, Coord};

use crate::Point;

/// Stands for "no gate" in [`Triangle::across`]: side 0 of the first triangle, which is a source's own and
/// never entered.
pub(super) const BOUNDARY: u32 = 0;

/// A triangle of the outline, counter-clockwise in the sense of a positive [`orient2d`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    /// Vertex before the ear, the ear, vertex after it.
    pub corners: [u32; 3],
    /// Behind side `corners[k]`-`corners[k + 1]`: three times the triangle there plus its side's number,
    /// or [`BOUNDARY`].
    pub across: [u32; 3],
}

/// The triangles in the order they were cut off, and that order of the vertices.
pub(super) struct Triangulation {
    pub triangles: Vec<Triangle>,
    /// The ears as they were cut off, then the last two vertices.
    pub clip_order: Vec<u32>,
}

/// Cuts a polygon of at least two vertices into `n - 2` triangles.
pub(super) fn triangulate(points: &[Point]) -> Triangulation {
    Clipper::new(points).run()
}

/// How strict the search for an ear is. A simple polygon always has a strict one.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Ear {
    /// Convex, no other vertex in the closed triangle.
    Strict,
    /// Not reflex, no other vertex inside the triangle: enough where the outline touches itself.
    Touching,
    /// Anything, where it crosses itself.
    Any,
}

struct Clipper<'a> {
    points: &'a [Point],
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Sign of the turn at every vertex: positive if convex.
    turn: Vec<f64>,
    /// For the side that starts at a vertex: where to enter what was cut off behind it.
    behind: Vec<u32>,
    obstacles: Obstacles,
    out: Triangulation,
}

impl<'a> Clipper<'a> {
    fn new(points: &'a [Point]) -> Self {
        let n = points.len() as u32;
        let mut next: Vec<u32> = (1..n).chain([0]).collect();
        let mut previous: Vec<u32> = [n - 1].into_iter().chain(0..n - 1).collect();
        if twice_the_area(points) < 0.0 {
            std::mem::swap(&mut next, &mut previous);
        }
        let turn: Vec<f64> = (0..points.len())
            .map(|k| orient(points, previous[k], k as u32, next[k]))
            .collect();
        let obstacles = Obstacles::new(points, &turn);
        Self {
            points,
            previous,
            next,
            turn,
            behind: vec![BOUNDARY; points.len()],
            obstacles,
            out: Triangulation {
                triangles: Vec::with_capacity(points.len()),
                clip_order: Vec::with_capacity(points.len()),
            },
        }
    }

    fn run(mut self) -> Triangulation {
        let mut remaining = self.points.len();
        let mut at = 0;
        let mut strictness = Ear::Strict;
        let mut misses = 0;
        while remaining > 2 {
            let (a, b, c) = (self.previous[at as usize], at, self.next[at as usize]);
            if self.is_ear(a, b, c, strictness) {
                self.clip(a, b, c);
                remaining -= 1;
                // Skipping one vertex keeps the triangles compact.
                at = self.next[c as usize];
                strictness = Ear::Strict;
                misses = 0;
            } else {
                at = c;
                misses += 1;
                if misses == remaining {
                    misses = 0;
                    strictness = if strictness == Ear::Strict {
                        Ear::Touching
                    } else {
                        Ear::Any
                    };
                }
            }
        }
        self.out.clip_order.extend([at, self.next[at as usize]]);
        self.out
    }

    fn is_ear(&self, a: u32, b: u32, c: u32, strictness: Ear) -> bool {
        let turn = self.turn[b as usize];
        match strictness {
            Ear::Strict if turn > 0.0 => !self.obstacles.any(self.points, [a, b, c], false),
            Ear::Strict => turn == 0.0 && self.is_spike(a, b, c),
            Ear::Touching if turn > 0.0 => !self.obstacles.any(self.points, [a, b, c], true),
            Ear::Touching => turn == 0.0,
            Ear::Any => true,
        }
    }

    /// Whether the collinear corners double back at `b` (or `b` repeats a neighbour), so that nothing is cut
    /// off with it.
    fn is_spike(&self, a: u32, b: u32, c: u32) -> bool {
        let [a, b, c] = [a, b, c].map(|k| self.points[k as usize]);
        (b - a).dot(&(c - b)) <= 0.0
    }

    fn clip(&mut self, a: u32, b: u32, c: u32) {
        let entrance = 3 * self.out.triangles.len() as u32;
        // The cut is a new side of what remains, but for the last triangle.
        let is_last = self.next[c as usize] == a;
        let cut = if is_last {
            self.behind[c as usize]
        } else {
            BOUNDARY
        };
        let across = [self.behind[a as usize], self.behind[b as usize], cut];
        for (side, &neighbour) in across.iter().enumerate() {
            if neighbour != BOUNDARY {
                let (triangle, neighbour_side) = (neighbour / 3, neighbour % 3);
                self.out.triangles[triangle as usize].across[neighbour_side as usize] =
                    entrance + side as u32;
            }
        }
        self.out.triangles.push(Triangle {
            corners: [a, b, c],
            across,
        });
        self.out.clip_order.push(b);
        self.behind[a as usize] = entrance + 2;
        self.next[a as usize] = c;
        self.previous[c as usize] = a;
        self.obstacles.remove(b);
        for k in [a, c] {
            let turn = orient(self.points, self.previous[k as usize], k, self.next[k as usize]);
            self.turn[k as usize] = turn;
            if turn > 0.0 {
                self.obstacles.remove(k);
            }
        }
    }
}

/// The vertices that may lie in an ear: those that are not convex.
struct Obstacles {
    tree: Bvh,
    /// Vertex of every leaf.
    vertices: Vec<u32>,
    alive: Vec<bool>,
}

impl Obstacles {
    fn new(points: &[Point], turn: &[f64]) -> Self {
        // Not `turn <= 0`: a turn that is not a number must count as an obstacle, too.
        let alive: Vec<bool> = turn.iter().map(|&turn| turn.is_nan() || turn <= 0.0).collect();
        let vertices: Vec<u32> = (0..points.len() as u32).filter(|&k| alive[k as usize]).collect();
        let boxes: Vec<Aabb> = vertices
            .iter()
            .map(|&k| {
                let corner = ParryVector::new(points[k as usize].x, points[k as usize].y);
                Aabb::new(corner, corner)
            })
            .collect();
        Self {
            tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            vertices,
            alive,
        }
    }

    fn remove(&mut self, vertex: u32) {
        self.alive[vertex as usize] = false;
    }

    /// Whether an obstacle lies in the triangle, its border counted unless `open`.
    fn any(&self, points: &[Point], corners: [u32; 3], open: bool) -> bool {
        let [a, b, c] = corners.map(|k| points[k as usize]);
        let low = a.inf(&b).inf(&c);
        let high = a.sup(&b).sup(&c);
        let bounds = Aabb::new(ParryVector::new(low.x, low.y), ParryVector::new(high.x, high.y));
        let found = self.tree.intersect_aabb(&bounds).any(|leaf| {
            let vertex = self.vertices[leaf as usize];
            self.alive[vertex as usize] && !corners.contains(&vertex) && {
                let inside = |from: u32, to: u32| {
                    let turn = orient(points, from, to, vertex);
                    turn > 0.0 || (turn == 0.0 && !open)
                };
                inside(corners[0], corners[1])
                    && inside(corners[1], corners[2])
                    && inside(corners[2], corners[0])
            }
        });
        found
    }
}

fn orient(points: &[Point], a: u32, b: u32, c: u32) -> f64 {
    let [a, b, c] = [a, b, c].map(|k| {
        let p = points[k as usize];
        Coord { x: p.x, y: p.y }
    });
    orient2d(a, b, c)
}

/// Twice the signed area, relative to the first point for accuracy.
fn twice_the_area(points: &[Point]) -> f64 {
    let origin = points[0];
    points
        .windows(2)
        .map(|w| (w[0] - origin).perp(&(w[1] - origin)))
        .sum()
}
