//! Folds one leg of a pair of trousers, and tells where every edge of the folded outline comes from.
//!
//! `cargo run --package foldrs --example fold_outline`

use foldrs::model::Region;
use foldrs::prelude::*;
use std::error::Error;

/// Trousers, cm, the waist at the top.
const TROUSERS: [[f64; 2]; 7] = [
    [-20.0, 0.0],
    [-25.0, 100.0],
    [-5.0, 100.0],
    [0.0, 30.0],
    [5.0, 100.0],
    [25.0, 100.0],
    [20.0, 0.0],
];

fn main() -> Result<(), Box<dyn Error>> {
    let trousers = Outline::try_from(&TROUSERS[..])?;
    // Only what hangs on the axis, on the side towards which x turns to y, is turned over: the end of one leg.
    let axis = [Point::new(0.0, 60.0), Point::new(26.0, 60.0)];
    let folded = fold(&trousers, &axis)?;

    println!(
        "{:.0} of {:.0} cm2 turned over, {:.0} cm2 lie twofold",
        folded.flap_area(),
        trousers.signed_area().abs(),
        Region::double_layer(&folded).area()
    );
    println!("edges of the folded outline, and where they come from:");
    for (vertex, source) in folded.outline.points.iter().zip(&folded.outline.sources) {
        let [from, to] = source.arc;
        println!(
            "  from ({:5.1}, {:5.1})  {:<6}  {from:5.1} to {to:5.1} cm along the unfolded outline",
            vertex.x,
            vertex.y,
            format!("{:?}", source.layer)
        );
    }
    Ok(())
}
