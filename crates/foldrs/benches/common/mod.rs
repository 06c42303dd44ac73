//! Outlines to measure with.
#![allow(dead_code)]

use std::f64::consts::TAU;

use foldrs::inner_distance::inner_distances;
use foldrs::shape_context::{shape_contexts, ShapeContextParameters, ShapeContexts};
use foldrs::{Point, Segment};

/// Points of the outlines measured.
pub const SIZES: [usize; 4] = [50, 100, 200, 400];

/// An axis off the centre, across the whole outline.
pub const AXIS: Segment = [Point::new(-2.0, 0.3), Point::new(2.0, 0.5)];

/// A star with rounded rays, about a third of its vertices reflex.
pub fn outline(n: usize, phase: f64) -> Vec<Point> {
    (0..n)
        .map(|k| {
            let angle = TAU * k as f64 / n as f64;
            let radius = 1.0 + 0.5 * (5.0 * angle + phase).sin() + 0.2 * (11.0 * angle).cos();
            Point::new(radius * angle.cos(), radius * angle.sin())
        })
        .collect()
}

/// Its shape contexts.
pub fn contexts(points: &[Point]) -> ShapeContexts {
    let parameters = ShapeContextParameters::default();
    shape_contexts(points, &inner_distances(points), &parameters)
}
