//! The thread pool all parallel stages share: one a process, since threads are not there any more after a fork.

use std::process;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::OnceLock;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The size asked for last; 0: as rayon chooses.
static WANTED: AtomicUsize = AtomicUsize::new(0);

/// The pools of this process and those it was forked from, with their process's number, the oldest first.
static POOLS: [OnceLock<(u32, Option<ThreadPool>)>; 64] = [const { OnceLock::new() }; 64];

/// The pool of this process.
pub(crate) fn pool() -> PyResult<&'static ThreadPool> {
    let this = process::id();
    POOLS
        .iter()
        .map(|pool| pool.get_or_init(|| (this, started(WANTED.load(Ordering::Relaxed)))))
        .find_map(|(process, pool)| (*process == this).then_some(pool.as_ref()))
        .flatten()
        .ok_or_else(|| PyRuntimeError::new_err("no threads could be started for the work"))
}

/// A new pool; of one thread where so many cannot be started.
fn started(threads: usize) -> Option<ThreadPool> {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    pool(threads).or_else(|_| pool(1)).ok()
}

/// Sets the size of the pool if it has not been used yet; returns the size it has.
#[pyfunction]
#[pyo3(signature = (threads=None))]
pub(crate) fn set_threads(threads: Option<usize>) -> PyResult<usize> {
    if threads == Some(0) {
        return Err(PyValueError::new_err("the number of threads must be at least 1"));
    }
    if let Some(threads) = threads {
        WANTED.store(threads, Ordering::Relaxed);
    }
    // Once the pool is running its size stays.
    Ok(pool()?.current_num_threads())
}
