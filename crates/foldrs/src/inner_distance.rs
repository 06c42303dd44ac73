//! Inner distances: lengths of the shortest paths inside an outline.
//!
//! Ling & Jacobs, *Shape classification using the inner-distance* (PAMI 2007), the metric under the
//! shape contexts that compare folded outlines (Mariolis & Malassiotis 2015, section 2.1.2).
//!
//! Ling & Jacobs test every chord for visibility and run a shortest-path search on the graph of
//! visible chords, which is cubic. A simple polygon allows better (Guibas et al. 1987): cut it into
//! triangles, and from a source carry through the triangles a *funnel*, the two shortest paths to the
//! ends of the diagonal just crossed; the tangent from the next corner to that funnel is the last leg
//! of its shortest path. One source costs about as many steps as there are vertices, whatever the
//! share of reflex ones, and no chord is ever tested.
//!
//! The triangulation is exact: parry's bounding volume hierarchy finds the reflex vertices near a
//! possible ear and [`robust::orient2d`] decides. Only the tangents know a tolerance, see
//! [`STRAIGHT`].

use crate::Point;

mod triangulation;
use triangulation::{triangulate, Triangle};

/// A path passes a vertex without a bend if the straight line misses it by less than this share of the
/// outline's size.
///
/// The points of a resampled straight side are collinear only up to their last bits. Without a
/// tolerance every second one of them would be an obstacle, and the path along the side a chain of many
/// legs. The rounding error of the test is some thousand times smaller, so plain arithmetic decides it.
pub const STRAIGHT: f64 = 1e-12;

/// Shortest paths inside an outline between all pairs of its vertices.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct InnerDistances {
    /// Number of vertices `n`.
    pub n: usize,
    /// Path lengths, row-major `n x n`, in the unit of the points; symmetric.
    pub distance: Vec<f64>,
    /// Row-major `n x n`: the vertex after `i` on the way from `i` to `j`; `i` itself on the diagonal.
    pub first_step: Vec<u32>,
}

impl InnerDistances {
    /// Mean of the finite, positive distances, the unit of the shape contexts' distance bins
    /// (Ling & Jacobs 2007, section 4.1); 0 if there is none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        // Several sums at a time, or each addition would wait for the one before.
        let (mut sums, mut counts) = ([0.0; 8], [0_u64; 8]);
        for chunk in self.distance.chunks(8) {
            for ((sum, count), &d) in sums.iter_mut().zip(&mut counts).zip(chunk) {
                let counted = (d > 0.0) & (d < f64::INFINITY);
                *sum += if counted { d } else { 0.0 };
                *count += u64::from(counted);
            }
        }
        match counts.iter().sum::<u64>() {
            0 => 0.0,
            count => sums.iter().sum::<f64>() / count as f64,
        }
    }
}

/// Lengths and first steps of the shortest paths inside a closed outline, for all pairs of vertices.
///
/// `points` is a simple polygon, closed implicitly, of either winding. Paths may touch the boundary, run
/// along it and pass through vertices. They belong to the outline as a curve: two stretches of it that
/// touch from outside are no passage. Duplicate points, spikes and collinear runs are allowed; for an
/// outline that crosses itself the result is finite and not less than the straight distance.
///
/// Takes time `O(n^2)` for short funnels after a triangulation of `O(n^2 log n)` at worst.
#[must_use]
pub fn inner_distances(points: &[Point]) -> InnerDistances {
    let n = points.len();
    let mut inner = InnerDistances {
        n,
        distance: vec![0.0; n * n],
        first_step: vec![0; n * n],
    };
    for i in 0..n {
        inner.first_step[i * n + i] = i as u32;
    }
    if n < 2 {
        return inner;
    }
    let triangulation = triangulate(points);
    let mut explorer = Explorer::new(points, &triangulation.triangles);
    // An ear is no part of a shortest path between two other vertices. So every source is dropped with its
    // triangle once it was explored, and each pair of vertices is met only once.
    let mut left: Vec<u32> = triangulation.clip_order;
    left.reverse();
    for k in 0..triangulation.triangles.len() {
        let Some(source) = left.pop() else { break };
        explorer.explore(k);
        inner.store(source, &left, &explorer.nodes);
    }
    if let [a, b] = left[..] {
        let length = (points[a as usize] - points[b as usize]).norm();
        inner.set(a, b, length, b, a);
    }
    inner
}

impl InnerDistances {
    fn store(&mut self, source: u32, targets: &[u32], nodes: &[Node]) {
        for &target in targets {
            let node = &nodes[target as usize];
            self.set(source, target, node.length, node.first, node.parent);
        }
    }

    fn set(&mut self, i: u32, j: u32, length: f64, after_i: u32, after_j: u32) {
        let (ij, ji) = (i as usize * self.n + j as usize, j as usize * self.n + i as usize);
        self.distance[ij] = length;
        self.distance[ji] = length;
        self.first_step[ij] = after_i;
        self.first_step[ji] = after_j;
    }
}

/// A vertex in the tree of shortest paths from the current source.
#[derive(Clone, Copy)]
struct Node {
    x: f64,
    y: f64,
    /// Length of the path from the source.
    length: f64,
    /// Vertex before this one on the path.
    parent: u32,
    /// Vertex after the source on the path.
    first: u32,
}

/// A diagonal seen from the source's side, and the triangle behind it.
#[derive(Clone, Copy)]
struct Gate {
    left: u32,
    right: u32,
    /// The corner of the triangle behind the gate that is new.
    tip: u32,
    /// Gates behind, across the sides left-tip and tip-right; [`BOUNDARY`] if there is none.
    past_left: u32,
    past_right: u32,
}

/// Explores the polygon from one source after the other.
struct Explorer {
    nodes: Vec<Node>,
    gates: Vec<Gate>,
    /// For every triangle: its ear and the two other corners.
    ears: Vec<[u32; 3]>,
    /// For every triangle the gate opposite to its ear.
    exits: Vec<u32>,
    /// Gates still to pass, each with the apex of its funnel.
    pending: Vec<(u32, u32)>,
    tolerance: f64,
}

impl Explorer {
    fn new(points: &[Point], triangles: &[Triangle]) -> Self {
        let nodes = points
            .iter()
            .map(|p| Node {
                x: p.x,
                y: p.y,
                length: 0.0,
                parent: 0,
                first: 0,
            })
            .collect();
        let gate = |t: &Triangle, side: usize| Gate {
            left: t.corners[side],
            right: t.corners[(side + 1) % 3],
            tip: t.corners[(side + 2) % 3],
            past_right: t.across[(side + 1) % 3],
            past_left: t.across[(side + 2) % 3],
        };
        Self {
            nodes,
            gates: triangles
                .iter()
                .flat_map(|t| (0..3).map(move |side| gate(t, side)))
                .collect(),
            ears: triangles.iter().map(|t| t.corners).collect(),
            exits: triangles.iter().map(|t| t.across[2]).collect(),
            pending: Vec::with_capacity(points.len()),
            tolerance: STRAIGHT * size(points),
        }
    }

    /// Shortest paths from the ear of triangle `k` through the triangles after `k`.
    fn explore(&mut self, k: usize) {
        let [right, source, left] = self.ears[k];
        self.nodes[source as usize].length = 0.0;
        self.attach(left, source, source);
        self.attach(right, source, source);
        // Boundary sides carry the gate number 0, so one comparison keeps out those and the triangles dropped.
        let first_gate = 3 * (k as u32 + 1);
        self.pending.clear();
        if self.exits[k] >= first_gate {
            self.pending.push((self.exits[k], source));
        }
        while let Some((gate, apex)) = self.pending.pop() {
            let gate = self.gates[gate as usize];
            let (parent, side) = self.tangent(&gate, apex);
            self.attach(gate.tip, parent, source);
            if gate.past_left >= first_gate {
                let apex = if side == Side::Right { apex } else { parent };
                self.pending.push((gate.past_left, apex));
            }
            if gate.past_right >= first_gate {
                let apex = if side == Side::Left { apex } else { parent };
                self.pending.push((gate.past_right, apex));
            }
        }
    }

    fn attach(&mut self, vertex: u32, parent: u32, source: u32) {
        let from = self.nodes[parent as usize];
        let node = &mut self.nodes[vertex as usize];
        let (dx, dy) = (node.x - from.x, node.y - from.y);
        node.length = from.length + (dx * dx + dy * dy).sqrt();
        node.parent = parent;
        node.first = if parent == source { vertex } else { from.first };
    }

    /// The vertex of the funnel before the gate's tip on its shortest path, and the chain it is on.
    ///
    /// The chains are the paths to the ends of the gate, from where they part (the apex). Each bends away
    /// from the other, so the first edge met from the gate that the tip lies beyond ends in the tangent.
    #[inline]
    fn tangent(&self, gate: &Gate, apex: u32) -> (u32, Side) {
        let tip = &self.nodes[gate.tip as usize];
        let mut at = gate.left;
        while at != apex {
            let node = &self.nodes[at as usize];
            let parent = &self.nodes[node.parent as usize];
            let (turn, slack) = self.turn(parent, node, tip);
            if turn > slack {
                return (at, Side::Left);
            }
            at = node.parent;
        }
        at = gate.right;
        while at != apex {
            let node = &self.nodes[at as usize];
            let parent = &self.nodes[node.parent as usize];
            let (turn, slack) = self.turn(parent, node, tip);
            if turn < -slack {
                return (at, Side::Right);
            }
            at = node.parent;
        }
        (apex, Side::Apex)
    }

    /// Twice the area of the triangle `from`, `via`, `to` (positive if it turns left), and the area up to
    /// which it counts as straight.
    #[inline]
    fn turn(&self, from: &Node, via: &Node, to: &Node) -> (f64, f64) {
        let (ax, ay) = (via.x - from.x, via.y - from.y);
        let (bx, by) = (to.x - from.x, to.y - from.y);
        (ax * by - ay * bx, self.tolerance * (bx.abs() + by.abs()))
    }
}

/// Chain of the funnel.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
    Apex,
}

/// Longer side of the bounding box.
fn size(points: &[Point]) -> f64 {
    let extent = |coordinate: fn(&Point) -> f64| {
        let (low, high) = points
            .iter()
            .map(coordinate)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        high - low
    };
    extent(|p| p.x).max(extent(|p| p.y))
}
