//! Stage 6: the polygon model.

use crate::convert::{outline, points, segment};
use foldrs::model;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

#[pyfunction]
pub(crate) fn outline_iou(
    py: Python<'_>,
    a: PyReadonlyArray2<'_, f64>,
    b: PyReadonlyArray2<'_, f64>,
) -> PyResult<f64> {
    let (a, b) = (outline(&a)?, outline(&b)?);
    Ok(py.detach(|| model::intersection_over_union(&a, &b)))
}

#[pyfunction]
pub(crate) fn axis_difference(a: PyReadonlyArray2<'_, f64>, b: PyReadonlyArray2<'_, f64>) -> PyResult<f64> {
    Ok(model::axis_difference(&segment(&a)?, &segment(&b)?))
}

#[pyfunction]
pub(crate) fn reflect<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    axis: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, numpy::PyArray2<f64>>> {
    let axis = foldrs::crease::Axis::new(&segment(&axis)?).map_err(crate::convert::fold_error)?;
    let turned: Vec<_> = self::points(&points)?.iter().map(|p| axis.reflect(p)).collect();
    crate::convert::array(py, &turned)
}
