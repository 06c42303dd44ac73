//! Folds a drawn T-shirt over a line and finds that line again from the folded outline alone.
//!
//! `cargo run --release --package foldrs --example match_folded`

use foldrs::model::axis_difference;
use foldrs::prelude::*;
use std::error::Error;

/// A T-shirt, cm, its collar at the top.
const SHIRT: [[f64; 2]; 12] = [
    [-9.0, 0.0],
    [-22.0, 3.0],
    [-40.0, 22.0],
    [-28.0, 32.0],
    [-22.0, 25.0],
    [-22.0, 70.0],
    [22.0, 70.0],
    [22.0, 25.0],
    [28.0, 32.0],
    [40.0, 22.0],
    [22.0, 3.0],
    [9.0, 0.0],
];

/// A towel, cm: another garment that it could be.
const TOWEL: [[f64; 2]; 4] = [[0.0, 0.0], [50.0, 0.0], [50.0, 70.0], [0.0, 70.0]];

fn main() -> Result<(), Box<dyn Error>> {
    let templates = [Outline::try_from(&SHIRT[..])?, Outline::try_from(&TOWEL[..])?];
    let names = ["T-shirt", "towel"];
    let axis = [Point::new(-30.0, 52.0), Point::new(30.0, 40.0)];
    let folded = fold(&templates[0], &axis)?;
    println!(
        "folded {:.0} of {:.0} cm2",
        folded.flap_area(),
        templates[0].signed_area().abs()
    );

    let parameters = Parameters::default();
    let seen = Seen::new(Outline::new(folded.outline.points)?, &parameters);
    let found = match_folded(&seen, &templates, Some(1.0), &parameters);
    println!(
        "{} hypotheses tested, the best of each kind:",
        found.candidates.len()
    );
    for (template, name) in names.iter().enumerate() {
        if let Some(best) = found.candidates.iter().find(|c| c.template == template) {
            let [a, b] = best.hypothesis.axis;
            println!(
                "{name:<8} cost {:.3} (unfolded {:.3}), axis ({:.1}, {:.1}) - ({:.1}, {:.1})",
                best.cost, found.unfolded[template], a.x, a.y, b.x, b.y
            );
        }
    }
    if let Some(best) = found.candidates.first() {
        // The shirt's left and right look alike, so the mirror image of the axis is as right.
        let mirrored = axis.map(|p| Point::new(-p.x, p.y));
        let off = [axis, mirrored].map(|a| axis_difference(&best.hypothesis.axis, &a));
        println!(
            "area between the axis found and the true one: {:.1} cm2",
            off[0].min(off[1])
        );
    }
    Ok(())
}
