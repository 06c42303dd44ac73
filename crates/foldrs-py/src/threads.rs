//! The thread pool all parallel stages share.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Sets the size of the pool if it has not been used yet; returns the size it has.
#[pyfunction]
#[pyo3(signature = (threads=None))]
pub(crate) fn set_threads(threads: Option<usize>) -> PyResult<usize> {
    match threads {
        Some(0) => return Err(PyValueError::new_err("the number of threads must be at least 1")),
        // Once the pool is running its size stays: the error of a second call says just that.
        Some(n) => drop(rayon::ThreadPoolBuilder::new().num_threads(n).build_global()),
        None => {}
    }
    Ok(rayon::current_num_threads())
}
