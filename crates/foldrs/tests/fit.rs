//! Joint fit: a garment folded virtually is found folded where it was.

mod common;

use common::cases;
use foldrs::crease::Axis;
use foldrs::fit::{
    explain_from, explain_jointly, fit_jointly, fit_unfolded, start_from, FlexibleTemplate, FoldCount,
    JointFit, KnownFold, Looks, Picture, SeenField,
};
use foldrs::hypothesis::{Face, Hypothesis};
use foldrs::matching::{claim_axes, Seen};
use foldrs::parameters::{FitParameters, Parameters};
use foldrs::registration::PlaneMap;
use foldrs::{fold, Outline, Point, Segment};
use nalgebra::{Rotation2, Vector2};
use proptest::prelude::*;

/// A shirt without mirror symmetry, cm: of a symmetric one either sleeve would do.
const SHIRT: [[f64; 2]; 12] = [
    [-9.0, 0.0],
    [-22.0, 3.0],
    [-40.0, 24.0],
    [-30.0, 33.0],
    [-22.0, 25.0],
    [-24.0, 70.0],
    [22.0, 66.0],
    [20.0, 22.0],
    [33.0, 29.0],
    [41.0, 17.0],
    [21.0, 2.0],
    [8.0, 1.0],
];

fn shirt() -> Outline {
    Outline::new(SHIRT.map(|p| Point::new(p[0], p[1])).to_vec()).unwrap()
}

/// Axes that turn over the hem, a sleeve's side or the shoulders, the flap on their left.
fn axis() -> impl Strategy<Value = Segment> {
    (0.0..std::f64::consts::TAU, 8.0..18.0_f64).prop_map(|(angle, distance)| {
        let d = Vector2::new(angle.cos(), angle.sin());
        let foot = Point::new(0.0, 35.0) + Vector2::new(-d.y, d.x) * distance;
        [foot - d * 100.0, foot + d * 100.0]
    })
}

/// A shirt as it lies: its outline, wound positively, the true crease in the outline's direction, and what led there.
struct Scene {
    outline: Outline,
    crease: Segment,
    axis: Segment,
}

/// Folds the shirt over an axis and lays it elsewhere; `None` if the line creases it twice, or hardly.
fn scene(axis: &Segment, turn: f64, mirrored: bool) -> Option<Scene> {
    scene_of(&shirt(), axis, turn, mirrored)
}

/// The same of another garment.
fn scene_of(garment: &Outline, axis: &Segment, turn: f64, mirrored: bool) -> Option<Scene> {
    let folded = fold(garment, axis).ok()?;
    let [crease] = folded.creases[..] else { return None };
    if folded.flap_area() < 150.0 || folded.holes > 0 {
        return None;
    }
    let lay = |p: &Point| {
        let p = if mirrored { Point::new(-p.x, p.y) } else { *p };
        Rotation2::new(turn) * p + Vector2::new(12.0, -40.0)
    };
    let outline = Outline::new(folded.outline.points.iter().map(lay).collect())
        .ok()?
        .positive();
    // The cloth lies on the outline's left, and the flap was on the axis's left: they run against each other.
    let mut crease = crease.map(|p| lay(&p));
    if !mirrored {
        crease.reverse();
    }
    Some(Scene {
        outline,
        crease,
        axis: [folded.creases[0][1], folded.creases[0][0]],
    })
}

fn fit(scene: &Scene, mirrored: bool) -> (JointFit, JointFit) {
    let parameters = FitParameters::default();
    let template = FlexibleTemplate::new(&shirt(), &[], &parameters);
    fit_with(template, scene, mirrored, &parameters)
}

/// A template fitted folded as the scene is, and unfolded.
fn fit_with(
    template: FlexibleTemplate,
    scene: &Scene,
    mirrored: bool,
    parameters: &FitParameters,
) -> (JointFit, JointFit) {
    let field = SeenField::new(&scene.outline, parameters.samples, parameters.nodes);
    let claim = Hypothesis {
        axis: scene.axis,
        confidence: 1.0,
        side: 0,
        face: if mirrored { Face::Mirrored } else { Face::Seen },
        map: PlaneMap::identity(),
    };
    let start = start_from(&claim, &scene.crease, 1.0).unwrap();
    let templates = [template];
    let folded = fit_jointly(&field, &templates, &[(0, start)], parameters)
        .remove(0)
        .1;
    let middle = scene.outline.centroid();
    let unfolded = fit_unfolded(&field, &templates[0], middle, 1.0, parameters).unwrap();
    (folded, unfolded)
}

proptest! {
    #![proptest_config(cases(12))]

    #[test]
    fn a_virtual_fold_is_recovered(axis in axis(), turn in -3.0..3.0_f64, mirrored in any::<bool>()) {
        let Some(scene) = scene(&axis, turn, mirrored) else { return Ok(()) };
        let (folded, unfolded) = fit(&scene, mirrored);
        // The fitted crease has the flap on its left: it runs against the side. Where it ends depends on the
        // outline there, which the template follows up to its simplification.
        let simplified = FitParameters::default().simplify * shirt().signed_area().abs().sqrt();
        let line = Axis::new(&folded.creases[0]).unwrap();
        for (end, fitted) in [(scene.crease[1], folded.creases[0][0]), (scene.crease[0], folded.creases[0][1])] {
            prop_assert!(line.side(&end).abs() < 0.3, "{:?} found, {:?} true", folded.creases, scene.crease);
            prop_assert!((end - fitted).norm() < 0.3 + simplified);
        }
        prop_assert!(folded.surprise < unfolded.surprise);
        prop_assert!((folded.scale - 1.0).abs() < 0.02);
    }
}

proptest! {
    #![proptest_config(cases(8))]

    #[test]
    fn a_fold_known_beforehand_is_explained_as_it_is_found(
        axis in axis(), turn in -3.0..3.0_f64, mirrored in any::<bool>()
    ) {
        let Some(scene) = scene(&axis, turn, mirrored) else { return Ok(()) };
        let parameters = Parameters::default();
        let seen = Seen::new(scene.outline, &parameters);
        let templates = [FlexibleTemplate::new(&shirt(), &[], &parameters.fit)];
        let claims = claim_axes(&seen, &[shirt()], Some(1.0), &parameters);
        let one = FoldCount::Exactly(1);
        let found = explain_jointly(&seen, &templates, &claims, Some(1.0), None, one, &parameters);
        let known = KnownFold {
            template: 0,
            axis: scene.axis,
            crease: scene.crease,
            face: if mirrored { Face::Mirrored } else { Face::Seen },
        };
        let told = explain_from(&seen, &templates, &[known], Some(1.0), None, &parameters);
        prop_assert!((told[0].surprise - found.by_folds[1][0].surprise).abs() < 0.5);
    }
}

/// A towel whose lower hem bulges by so much, cm.
fn towel(bulge: f64) -> Outline {
    let hem = (0..=20).map(|k| {
        let t = f64::from(k) / 20.0;
        Point::new(60.0 * t, -4.0 * t * (1.0 - t) * bulge)
    });
    let rest = [Point::new(60.0, 40.0), Point::new(0.0, 40.0)];
    Outline::new(hem.chain(rest).collect()).unwrap()
}

#[test]
fn a_hem_that_bulges_surprises_less_if_edges_may_bulge() {
    let surprise = |bow: f64, bulge: f64| {
        let mut parameters = FitParameters::default();
        parameters.bow = bow;
        let template = FlexibleTemplate::new(&towel(0.0), &[], &parameters);
        let seen = towel(bulge);
        let field = SeenField::new(&seen, parameters.samples, parameters.nodes);
        let fit = fit_unfolded(&field, &template, seen.centroid(), 1.0, &parameters).unwrap();
        fit.surprise
    };
    let (soft, hard) = (FitParameters::default().bow, 1e-4);
    assert!(surprise(soft, 3.0) < surprise(hard, 3.0) - 2.0);
    // Freedom that nothing asks for costs something.
    assert!(surprise(soft, 0.0) > surprise(hard, 0.0));
}

/// What is seen of a towel lying with its crease at x = 0: a picture whose flap reaches to a given x, cm; a pixel a cm.
fn picture(reach: usize) -> Picture {
    const SIZE: (usize, usize) = (52, 42);
    let pixels = || (0..SIZE.0 * SIZE.1).map(|k| k % SIZE.0);
    Picture {
        width: SIZE.0,
        height: SIZE.1,
        tensor: pixels().map(|x| [f32::from(x == reach), 0.0, 0.0]).collect(),
        steps: None,
        scale: 1.0,
        looks: Some(Looks {
            width: SIZE.0,
            height: SIZE.1,
            look: pixels().map(|x| u8::from(x < reach)).collect(),
            scale: 1.0,
            origin: Point::origin(),
        }),
    }
}

#[test]
fn the_picture_tells_how_far_a_flap_reaches_and_that_it_lies_on_top() {
    // The template is 60 cm long, so a towel folded to 50 has a flap of 10 by the outline; the true ones differ.
    let template = Outline::new(
        [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)]
            .map(|(x, y)| Point::new(x, y))
            .to_vec(),
    )
    .unwrap();
    let seen = [(0.0, 0.0), (50.0, 0.0), (50.0, 40.0), (0.0, 40.0)].map(|(x, y)| Point::new(x, y));
    let parameters = Parameters::default();
    let templates = [FlexibleTemplate::new(&template, &[], &parameters.fit)];
    let crease = [Point::new(0.0, 40.0), Point::new(0.0, 0.0)];
    let known = KnownFold {
        template: 0,
        axis: [Point::new(10.0, 40.0), Point::new(10.0, 0.0)],
        crease,
        face: Face::Seen,
    };
    let seen = Seen::new(Outline::new(seen.to_vec()).unwrap(), &parameters);
    let length = |picture: Option<&Picture>| {
        let told = explain_from(&seen, &templates, &[known], Some(1.0), picture, &parameters);
        let places: Vec<f64> = told[0]
            .outline
            .iter()
            .map(|p| told[0].to_seen.apply(p).x)
            .collect();
        let long = |sign: f64| places.iter().map(|x| sign * x).fold(f64::NEG_INFINITY, f64::max);
        (long(1.0) + long(-1.0), told[0].picture)
    };
    assert!((length(None).0 - 60.0).abs() < 2.0);
    assert_eq!(length(None).1.gain, 0.0);
    for reach in [8, 14, 16] {
        let (length, told) = length(Some(&picture(reach)));
        assert!(
            (length - 50.0 - reach as f64).abs() < 2.0,
            "{length} for a flap of {reach}"
        );
        assert!(told.gain > 10.0 && told.flap_on_top > 10.0, "{told:?}");
    }
}

#[test]
fn of_one_fold_the_smaller_part_is_the_flap() {
    let parameters = Parameters::default();
    let templates = [FlexibleTemplate::new(&shirt(), &[], &parameters.fit)];
    for (side, turn, mirrored) in [
        (1.0, 0.4, false),
        (-1.0, 0.4, false),
        (1.0, 2.0, true),
        (-1.0, 2.0, true),
    ] {
        // Across the body: of the same line one part or the other is turned over.
        let axis = [Point::new(-100.0 * side, 45.0), Point::new(100.0 * side, 48.0)];
        let Some(scene) = scene(&axis, turn, mirrored) else {
            panic!("the line folds the shirt once")
        };
        let known = KnownFold {
            template: 0,
            axis: scene.axis,
            crease: scene.crease,
            face: if mirrored { Face::Mirrored } else { Face::Seen },
        };
        let seen = Seen::new(scene.outline.clone(), &parameters);
        let told = explain_from(&seen, &templates, &[known], Some(1.0), None, &parameters);
        let lies = told[0].outline.iter().map(|p| told[0].to_seen.apply(p)).collect();
        let unfolded = Outline::new(lies).unwrap();
        let folded = fold(&unfolded, &told[0].creases[0]).unwrap();
        assert!(folded.flap_area() <= 0.5 * unfolded.signed_area().abs());
        // Its axis on the template is where its crease is.
        for (on_template, in_image) in told[0].axes[0].iter().zip(&told[0].creases[0]) {
            let ends = told[0].creases[0].iter();
            let off = |end: &Point| (told[0].to_seen.apply(on_template) - end).norm();
            assert!(ends.map(off).fold(f64::INFINITY, f64::min) < 1e-6, "{in_image}");
        }
        let seen_again = Outline::new(folded.outline.points.clone()).unwrap();
        let area = |outline: &Outline| outline.signed_area().abs();
        assert!((area(&seen_again) - area(&scene.outline)).abs() < 0.02 * area(&scene.outline));
        let axis = Axis::new(&told[0].axes[0]).unwrap();
        let left = told[0].outline.iter().filter(|p| axis.side(p) > 0.0).count();
        let flap = unfolded.points().iter();
        let crease = Axis::new(&told[0].creases[0]).unwrap();
        assert_eq!(left, flap.filter(|p| crease.side(p) > 0.0).count());
    }
}

/// Shorts of legs `gap` apart, cm; straight from hem to hem if there is none.
fn shorts(gap: f64) -> Outline {
    let mut corners = vec![[-16.0, 0.0], [-26.0, 40.0]];
    if gap > 0.0 {
        corners.extend([[-gap / 2.0, 40.0], [0.0, 15.0], [gap / 2.0, 40.0]]);
    }
    corners.extend([[26.0, 40.0], [16.0, 0.0]]);
    Outline::new(corners.iter().map(|&[x, y]| Point::new(x, y)).collect()).unwrap()
}

/// Hardly bending, so that legs cannot close; and the same to which nothing lies too deep within to be overlooked.
fn stiff_and_blind() -> [FitParameters; 2] {
    let mut stiff = FitParameters::default();
    stiff.shape = 0.005;
    let mut blind = stiff.clone();
    blind.bare = f64::INFINITY;
    [stiff, blind]
}

#[test]
fn a_gap_that_is_not_seen_speaks_against_a_template() {
    let cost_of_gap = |seen: &Outline| {
        let [with, without] = stiff_and_blind().map(|parameters| {
            let template = FlexibleTemplate::new(&shorts(8.0), &[], &parameters);
            let field = SeenField::new(seen, parameters.samples, parameters.nodes);
            let fit = fit_unfolded(&field, &template, seen.centroid(), 1.0, &parameters);
            fit.unwrap().residual
        });
        with - without
    };
    let closed = cost_of_gap(&shorts(0.0).positive());
    assert!(closed > 3.0, "{closed}");
    assert!(cost_of_gap(&shorts(8.0).positive()).abs() < 0.1);
}

#[test]
fn a_gap_that_the_flap_covers_need_not_be_seen() {
    // The left leg's outer half is turned over the gap.
    let axis = [Point::new(-8.0, -90.0), Point::new(-8.0, 110.0)];
    let scene = scene_of(&shorts(8.0), &axis, 0.5, false).unwrap();
    assert!(scene
        .outline
        .contains(&(Rotation2::new(0.5) * Point::new(0.0, 35.0) + Vector2::new(12.0, -40.0))));
    let [with, without] = stiff_and_blind().map(|parameters| {
        let template = FlexibleTemplate::new(&shorts(8.0), &[], &parameters);
        fit_with(template, &scene, false, &parameters).0.residual
    });
    assert!((with - without).abs() < 0.5, "{with} {without}");
}

/// A skirt of so many times its usual width, and its pairs of mirrored corners.
fn skirt(wide: f64) -> (Outline, [[Point; 2]; 2]) {
    let at = |x: f64, y: f64| Point::new(x * wide, y);
    let corners = [at(-18.0, 0.0), at(-30.0, 55.0), at(30.0, 55.0), at(18.0, 0.0)];
    let mirrored = [[corners[0], corners[3]], [corners[1], corners[2]]];
    (Outline::new(corners.to_vec()).unwrap(), mirrored)
}

#[test]
fn of_a_garment_folded_in_halves_the_seen_half_tells_the_hidden_one() {
    // The flap is hidden: by the template's own width it would reach less far than the part it lies on.
    let (template, mirrored) = skirt(1.0);
    let area = |outline: &[Point]| Outline::new(outline.to_vec()).unwrap().signed_area().abs();
    let known = KnownFold {
        template: 0,
        axis: [Point::new(0.0, 0.0), Point::new(0.0, 55.0)],
        crease: [Point::new(0.0, 0.0), Point::new(0.0, 55.0)],
        face: Face::Seen,
    };
    let off = |wide: f64, parameters: &Parameters| {
        let (truth, _) = skirt(wide);
        let half = truth
            .points()
            .iter()
            .map(|p| Point::new(p.x.min(0.0), p.y))
            .collect();
        let seen = Seen::new(Outline::new(half).unwrap().positive(), parameters);
        let templates = [FlexibleTemplate::new(&template, &mirrored, &parameters.fit)];
        let told = explain_from(&seen, &templates, &[known], Some(1.0), None, parameters);
        (area(&told[0].outline) / area(truth.points()) - 1.0).abs()
    };
    let halves = Parameters::default();
    let mut anyhow = Parameters::default();
    (anyhow.fit.along, anyhow.fit.across, anyhow.fit.halves) = (0.0, 0.0, 0.0);
    for wide in [1.05, 1.15, 1.25] {
        let (halves, anyhow) = (off(wide, &halves), off(wide, &anyhow));
        assert!(anyhow > 0.03, "{wide}: {anyhow}");
        assert!(halves < 0.6 * anyhow, "{wide}: {halves}, {anyhow}");
    }
}
