//! Random outlines.
#![allow(dead_code)]

use std::ops::Range;

use foldrs::{Outline, Point};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// So many cases, the same ones every time.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(2015),
        failure_persistence: None,
        ..ProptestConfig::with_cases(cases)
    }
}

/// An outline through random points; those that hardly enclose anything are left out.
pub fn outline(size: Range<usize>) -> impl Strategy<Value = Outline> {
    polygon(size).prop_filter_map("no area", |p| {
        Outline::new(p).ok().filter(|o| o.signed_area().abs() > 1e-3)
    })
}

fn cross(o: Point, a: Point, b: Point) -> f64 {
    (a - o).perp(&(b - o))
}

/// Removes crossings by turning round the stretch between two crossing sides; each time the outline gets shorter.
/// `None` where that leads nowhere, for points coincide or lie on one line.
fn untangle(mut p: Vec<Point>) -> Option<Vec<Point>> {
    let n = p.len();
    let cross_each_other =
        |a, b, c, d| cross(a, b, c) * cross(a, b, d) <= 0.0 && cross(c, d, a) * cross(c, d, b) <= 0.0;
    for _ in 0..n * n * n {
        let crossing = (0..n)
            .flat_map(|i| (i + 2..n).map(move |j| (i, j)))
            .filter(|&(i, j)| (j + 1) % n != i)
            .find(|&(i, j)| cross_each_other(p[i], p[i + 1], p[j], p[(j + 1) % n]));
        match crossing {
            Some((i, j)) => p[i + 1..=j].reverse(),
            None => return Some(p),
        }
    }
    None
}

/// Simple polygons of random points in the unit square, winding and all.
pub fn polygon(size: Range<usize>) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64), size).prop_filter_map("points in one line", |xy| {
        untangle(xy.into_iter().map(|(x, y)| Point::new(x, y)).collect())
    })
}

/// Star-shaped polygons around the origin.
pub fn star(size: Range<usize>) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec((0.2..1.0_f64, 0.2..1.0_f64), size).prop_map(|rays| {
        let full: f64 = rays.iter().map(|ray| ray.1).sum();
        let mut angle = 0.0;
        rays.iter()
            .map(|&(radius, width)| {
                angle += width / full * std::f64::consts::TAU;
                Point::new(radius * f64::cos(angle), radius * f64::sin(angle))
            })
            .collect()
    })
}

/// Cuts every side into `pieces`; the new points lie on it up to rounding.
pub fn subdivided(p: &[Point], pieces: usize) -> Vec<Point> {
    (0..p.len() * pieces)
        .map(|k| {
            let (a, b) = (p[k / pieces], p[(k / pieces + 1) % p.len()]);
            a + (b - a) * ((k % pieces) as f64 / pieces as f64)
        })
        .collect()
}

/// Turned, scaled, shifted; before that mirrored if `flip`.
pub fn transformed(p: &[Point], angle: f64, scale: f64, shift: f64, flip: bool) -> Vec<Point> {
    let (sin, cos) = angle.sin_cos();
    p.iter()
        .map(|q| Point::new(if flip { -q.x } else { q.x }, q.y))
        .map(|q| Point::new(cos * q.x - sin * q.y, sin * q.x + cos * q.y) * scale)
        .map(|q| Point::new(q.x + shift, q.y - shift))
        .collect()
}
