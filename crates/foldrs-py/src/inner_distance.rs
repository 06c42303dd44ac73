//! Stage 4: inner distances.

use crate::convert::{matrix, vertices};
use foldrs::inner_distance as stage;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

/// Lengths of the shortest paths inside an outline between all pairs of its vertices.
#[pyfunction]
pub(crate) fn inner_distances<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = vertices(&points)?;
    let inner = py.detach(|| stage::inner_distances(&points));
    matrix(py, &inner.distance, inner.n)
}
