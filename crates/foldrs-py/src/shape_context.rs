//! Stage 4: shape contexts and their costs.

use crate::convert::{matrix, vertices};
use foldrs::inner_distance::inner_distances;
use foldrs::shape_context::{self as stage, chi_squared, ShapeContextParameters, ShapeContexts};
use foldrs::Point;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Histograms of all vertices of an outline, one a row.
#[pyfunction]
#[pyo3(signature = (points, n_dist=5, n_theta=12))]
pub(crate) fn shape_contexts<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    n_dist: usize,
    n_theta: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (points, resolution) = (vertices(&points)?, resolution(n_dist, n_theta)?);
    let histograms = py.detach(|| contexts(&points, &resolution).histograms());
    let shares: Vec<f64> = histograms.into_iter().map(f64::from).collect();
    matrix(py, &shares, points.len())
}

/// Chi-squared distances between the shape contexts of two outlines.
#[pyfunction]
#[pyo3(signature = (points_a, points_b, n_dist=5, n_theta=12))]
pub(crate) fn matching_costs<'py>(
    py: Python<'py>,
    points_a: PyReadonlyArray2<'py, f64>,
    points_b: PyReadonlyArray2<'py, f64>,
    n_dist: usize,
    n_theta: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (a, b) = (vertices(&points_a)?, vertices(&points_b)?);
    let resolution = resolution(n_dist, n_theta)?;
    let cost = py.detach(|| chi_squared(&contexts(&a, &resolution), &contexts(&b, &resolution)));
    let values: Vec<f64> = cost.values.into_iter().map(f64::from).collect();
    matrix(py, &values, cost.rows)
}

fn contexts(points: &[Point], resolution: &ShapeContextParameters) -> ShapeContexts {
    stage::shape_contexts(points, &inner_distances(points), resolution)
}

fn resolution(n_dist: usize, n_theta: usize) -> PyResult<ShapeContextParameters> {
    if n_dist == 0 || n_theta == 0 {
        return Err(PyValueError::new_err(format!(
            "a shape context needs at least one bin each way, not n_dist = {n_dist}, n_theta = {n_theta}"
        )));
    }
    let mut parameters = ShapeContextParameters::default();
    (parameters.n_dist, parameters.n_theta) = (n_dist, n_theta);
    Ok(parameters)
}
