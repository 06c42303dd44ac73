//! One seam for threads: ordered maps that run on rayon's current pool, or in sequence without the feature.
//!
//! The order of the results never depends on the number of threads. Between two items the work can be stopped.

#[cfg(feature = "parallel")]
use crate::interrupt::set_aside;
use crate::interrupt::{checked, current};

#[cfg(feature = "parallel")]
pub(crate) fn map<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    let interrupt = current();
    // While it waits for the other threads this one may take up work that has nothing to do with this.
    let _restored = set_aside();
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
