//! Arrays to points and back, and errors to `foldrs.errors`.

use foldrs::{FoldError, Outline, OutlineError, Point, Segment};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(foldrs.errors, InvalidOutlineError);
import_exception!(foldrs.errors, ParameterError);

/// Points of an (n, 2) array of any memory layout.
pub(crate) fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point>> {
    let view = array.as_array();
    if view.ncols() != 2 {
        return Err(PyValueError::new_err(format!(
            "expected an array of shape (n, 2), not ({}, {})",
            view.nrows(),
            view.ncols()
        )));
    }
    Ok(view.rows().into_iter().map(|r| Point::new(r[0], r[1])).collect())
}

/// The outline of an (n, 2) array.
pub(crate) fn outline(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Outline> {
    Outline::new(points(array)?).map_err(outline_error)
}

/// Three or more finite points of an (n, 2) array, all kept, for stages that index them.
pub(crate) fn vertices(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point>> {
    let points = points(array)?;
    if let Some(i) = points.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
        return Err(outline_error(OutlineError::NotFinite(i)));
    }
    if points.len() < 3 {
        return Err(outline_error(OutlineError::TooFewPoints(points.len())));
    }
    Ok(points)
}

/// The segment of a (2, 2) array.
pub(crate) fn segment(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Segment> {
    <Segment>::try_from(points(array)?)
        .map_err(|p| PyValueError::new_err(format!("expected two points, not {}", p.len())))
}

/// An (n, 2) array of points.
pub(crate) fn array<'py>(py: Python<'py>, points: &[Point]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y]).collect();
    flat.to_pyarray(py).reshape([points.len(), 2])
}

/// A (rows, k) array of values given row by row.
pub(crate) fn matrix<'py>(
    py: Python<'py>,
    values: &[f64],
    rows: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    values.to_pyarray(py).reshape([rows, values.len() / rows.max(1)])
}

/// A scale that is known.
pub(crate) fn checked_scale(px_per_unit: Option<f64>) -> PyResult<Option<f64>> {
    match px_per_unit {
        Some(s) if !(s.is_finite() && s > 0.0) => Err(parameter_error(format!(
            "the scale must be a positive number, not {s}"
        ))),
        known => Ok(known),
    }
}

pub(crate) fn parameter_error(what: String) -> PyErr {
    ParameterError::new_err(what)
}

pub(crate) fn outline_error(e: OutlineError) -> PyErr {
    InvalidOutlineError::new_err(e.to_string())
}

pub(crate) fn fold_error(e: FoldError) -> PyErr {
    PyValueError::new_err(e.to_string())
}
