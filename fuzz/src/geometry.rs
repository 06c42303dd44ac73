//! Outlines, virtual folding, inner distances.

use super::bytes::Bytes;
use foldrs::inner_distance::inner_distances;
use foldrs::model::Region;
use foldrs::outline::signed_area;
use foldrs::shape_context::{chi_squared, mirrored_shape_contexts, shape_contexts, ShapeContextParameters};
use foldrs::{Outline, Point, Segment};

fn finite(p: &Point) -> bool {
    p.x.is_finite() && p.y.is_finite()
}

/// The larger side of the box around the points.
fn size(points: &[Point]) -> f64 {
    points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max)
}

/// Any points are an outline or named as none; what is an outline can be measured, sampled and simplified.
pub fn outline(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let points = bytes.points(48);
    let tolerance = f64::from(bytes.byte()) / 64.0;
    let Ok(outline) = Outline::new(points) else { return };
    let n = outline.points().len();
    let (size, length) = (size(outline.points()), outline.length());
    assert!(n >= 3 && length.is_finite() && length >= size);
    assert!(outline.signed_area() != 0.0 && outline.signed_area().abs() <= 2.0 * n as f64 * size * size);
    assert!(outline.clone().positive().signed_area() > 0.0);
    assert_eq!(outline.reversed().reversed(), outline);
    assert_eq!(outline.mirrored().mirrored(), outline);

    // A tangle of loops may balance anywhere; cloth balances near itself.
    assert!(finite(&outline.centroid()));
    let simple = outline.check_simple().is_ok();
    // Far from the origin coordinates have few digits left for the outline's own shape.
    let far = outline
        .points()
        .iter()
        .map(|p| p.coords.amax())
        .fold(0.0, f64::max);
    let rounding = 1e-9 * length + 8.0 * f64::EPSILON * far;
    for p in outline.resample(40) {
        let nearest = outline.nearest(&p);
        assert!(
            finite(&p) && nearest.distance <= rounding,
            "{p} is {} off",
            nearest.distance
        );
        assert!((0.0..=length).contains(&nearest.arc));
        let _ = simple && outline.contains(&p);
    }
    let corners = outline.simplify(tolerance * size);
    assert!(
        corners.len() >= 2
            && corners.windows(2).all(|pair| pair[0] < pair[1])
            && corners[corners.len() - 1] < n
    );
    for side in outline.sides(tolerance * size) {
        assert!(side.segment.iter().all(finite) && side.arc.iter().all(|arc| (0.0..=length).contains(arc)));
    }
}

/// A fold loses no cloth, makes up none, and every point of it knows where it comes from.
pub fn fold(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let Ok(axis) = Segment::try_from(bytes.points(2)) else {
        return;
    };
    let Some(outline) = bytes.outline(48) else { return };
    let Ok(folded) = foldrs::fold(&outline, &axis) else {
        return;
    };
    let length = outline.length();
    let all = || folded.kept.iter().chain(&folded.flap).chain([&folded.outline]);
    for piece in all() {
        assert_eq!(piece.points.len(), piece.sources.len());
        assert!(piece.points.iter().all(finite));
        let within = |arc: &f64| (-1e-9 * length..=(1.0 + 1e-9) * length).contains(arc);
        assert!(piece.sources.iter().all(|source| source.arc.iter().all(within)));
    }
    assert!(folded
        .resample(40)
        .iter()
        .all(|p| finite(&p.point) && p.arc.is_finite()));
    assert!(folded.flap_area() > 0.0);
    let double = Region::double_layer(&folded);
    assert!(!double.distance(&outline.points()[0]).is_nan());
    if outline.check_simple().is_ok() {
        let cloth = outline.signed_area().abs();
        let area = |pieces: &[foldrs::fold::Piece]| -> f64 {
            pieces.iter().map(|piece| signed_area(&piece.points).abs()).sum()
        };
        let pieces = area(&folded.kept) + area(&folded.flap);
        let slack = 1e-6 * length * length;
        assert!((pieces - cloth).abs() <= slack, "{cloth} folded to {pieces}");
        assert!(double.area() <= cloth + slack);
    }
}

/// Inner distances are never shorter than the straight way, equal both ways, and there is always a first step.
pub fn inner_distance(data: &[u8]) {
    let points = Bytes::new(data).points(48);
    let inner = inner_distances(&points);
    let n = points.len();
    assert_eq!((inner.distance.len(), inner.first_step.len()), (n * n, n * n));
    assert!(inner.first_step.iter().all(|&step| (step as usize) < n));
    // Out of this range, which that of an outline lies well within, squares of lengths have not all their digits.
    let range = 1e-100..1e100;
    let plain = |p: &Point| finite(p) && p.coords.amax() < range.end;
    if points.iter().all(plain) && range.contains(&size(&points)) {
        let least = f64::EPSILON * size(&points);
        for i in 0..n {
            for j in 0..n {
                let (there, back) = (inner.distance[i * n + j], inner.distance[j * n + i]);
                let straight = (points[i] - points[j]).norm();
                assert!(
                    there.is_finite() && there >= straight * (1.0 - 1e-12) - least,
                    "{there} < {straight}"
                );
                assert_eq!(there, back);
                assert_eq!(inner.first_step[i * n + j] as usize == i, i == j);
            }
        }
    }
    let parameters = ShapeContextParameters::default();
    let contexts = shape_contexts(&points, &inner, &parameters);
    let mirrored = mirrored_shape_contexts(&points, &inner, &parameters);
    let costs = chi_squared(&contexts, &mirrored);
    assert!(costs.values.iter().all(|cost| (-1e-5..=2.00001).contains(cost)));
}
