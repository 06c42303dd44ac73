//! Inputs that a fuzzer found worth keeping, replayed: those that once broke a promise, and those that reach every
//! line it ever reached (`make fuzz` looks for more).

use std::path::PathBuf;

#[path = "../../../fuzz/src/lib.rs"]
mod fuzzed;

fn replay(target: &str, check: fn(&[u8])) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/corpus")
        .join(target);
    let mut inputs: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    inputs.sort();
    assert!(!inputs.is_empty(), "no inputs in {}", folder.display());
    for input in inputs {
        let data = std::fs::read(&input).unwrap();
        println!("{}", input.display()); // shown if the next line panics
        check(&data);
    }
}

#[test]
fn outlines() {
    replay("outline", fuzzed::outline);
}

#[test]
fn folds() {
    replay("fold", fuzzed::fold);
}

#[test]
fn inner_distances() {
    replay("inner_distance", fuzzed::inner_distance);
}

#[test]
fn alignments() {
    replay("alignment", fuzzed::alignment);
}

#[test]
fn templates() {
    replay("template", fuzzed::template);
}

#[test]
fn explanations() {
    replay("explain", fuzzed::explain);
}
