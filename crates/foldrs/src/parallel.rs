//! One seam for threads: ordered maps that run on rayon's current pool, or in sequence without the feature.
//!
//! The order of the results never depends on the number of threads. Between two items the work can be stopped.

use crate::interrupt::{checked, current};

#[cfg(feature = "parallel")]
pub(crate) fn map<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    let interrupt = current();
    items
        .par_iter()
        .map(|item| checked(&interrupt, || f(item)))
        .collect()
}

#[cfg(not(feature = "parallel"))]
pub(crate) fn map<T, R>(items: &[T], f: impl Fn(&T) -> R) -> Vec<R> {
    let interrupt = current();
    items.iter().map(|item| checked(&interrupt, || f(item))).collect()
}
