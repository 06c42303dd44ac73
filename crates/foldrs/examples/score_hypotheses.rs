//! Scores all hypotheses about a folded T-shirt, first on one core, then on all: the same result, sooner.
//!
//! `cargo run --release --package foldrs --example score_hypotheses`

use foldrs::prelude::*;
use std::error::Error;
use std::time::Instant;

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

fn main() -> Result<(), Box<dyn Error>> {
    let shirt = Outline::try_from(&SHIRT[..])?;
    let folded = fold(&shirt, &[Point::new(-30.0, 52.0), Point::new(30.0, 40.0)])?;
    let parameters = Parameters::default();
    let seen = Seen::new(Outline::new(folded.outline.points)?, &parameters);
    let templates = [shirt];

    // The crate runs on rayon's current pool: whoever calls it decides how many threads that has.
    let score = |threads: usize| -> Result<Matching, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let begin = Instant::now();
        let found = pool.install(|| match_folded(&seen, &templates, Some(1.0), &parameters));
        println!(
            "{} threads: {} hypotheses in {:.0} ms",
            pool.current_num_threads(),
            found.candidates.len(),
            begin.elapsed().as_secs_f64() * 1e3
        );
        Ok(found)
    };
    let one = score(1)?;
    let all = score(0)?; // as many threads as there are cores

    let same = one
        .candidates
        .iter()
        .map(|c| c.cost)
        .eq(all.candidates.iter().map(|c| c.cost));
    println!("the same costs: {same}");
    for candidate in all.candidates.iter().take(3) {
        let [a, b] = candidate.hypothesis.axis;
        println!(
            "cost {:.3}, confidence {:.2}, axis ({:.1}, {:.1}) - ({:.1}, {:.1})",
            candidate.cost, candidate.hypothesis.confidence, a.x, a.y, b.x, b.y
        );
    }
    Ok(())
}
