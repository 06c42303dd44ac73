//! Stage 0: outlines.

use crate::convert::{array, outline, outline_error, vertices};
use foldrs::landmark::Landmark;
use foldrs::outline as stage;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

#[pyfunction]
pub(crate) fn check_outline(py: Python<'_>, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
    let outline = outline(&points)?;
    py.detach(|| outline.check_simple()).map_err(outline_error)
}

#[pyfunction]
pub(crate) fn signed_area(points: PyReadonlyArray2<'_, f64>) -> PyResult<f64> {
    Ok(stage::signed_area(&crate::convert::points(&points)?))
}

type Nearest<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pyfunction]
pub(crate) fn carried<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    outline: PyReadonlyArray2<'py, f64>,
    moved: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (outline, moved) = (vertices(&outline)?, vertices(&moved)?);
    if outline.len() != moved.len() {
        return Err(PyValueError::new_err(format!(
            "both outlines must have as many corners, not {} and {}",
            outline.len(),
            moved.len()
        )));
    }
    let points = crate::convert::points(&points)?;
    let carry = |point| Landmark::nearest(&outline, point)?.on(&moved);
    array(py, &points.iter().filter_map(carry).collect::<Vec<_>>())
}

#[pyfunction]
#[pyo3(signature = (points, query))]
pub(crate) fn nearest_on_outline<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    query: PyReadonlyArray2<'py, f64>,
) -> PyResult<Nearest<'py>> {
    let outline = outline(&points)?;
    let query = crate::convert::points(&query)?;
    let nearest: Vec<stage::Nearest> = py.detach(|| query.iter().map(|q| outline.nearest(q)).collect());
    Ok((
        array(py, &nearest.iter().map(|n| n.point).collect::<Vec<_>>())?,
        nearest
            .iter()
            .map(|n| n.distance)
            .collect::<Vec<_>>()
            .to_pyarray(py),
        nearest.iter().map(|n| n.arc).collect::<Vec<_>>().to_pyarray(py),
    ))
}

#[pyfunction]
pub(crate) fn resample<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    n: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if n < 3 {
        return Err(PyValueError::new_err(format!(
            "an outline needs at least three points, n = {n} is too few"
        )));
    }
    array(py, &outline(&points)?.resample(n))
}

#[pyfunction]
pub(crate) fn simplify<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    tolerance: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let outline = outline(&points)?;
    let corners: Vec<_> = py
        .detach(|| outline.simplify(tolerance))
        .into_iter()
        .map(|i| outline.points()[i])
        .collect();
    array(py, &corners)
}

#[pyfunction]
pub(crate) fn sides<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    tolerance: f64,
) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
    let outline = outline(&points)?;
    py.detach(|| outline.sides(tolerance))
        .iter()
        .map(|s| array(py, &s.segment))
        .collect()
}

#[pyfunction]
pub(crate) fn points_at<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    arc: numpy::PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let outline = outline(&points)?;
    array(
        py,
        &arc.as_array().iter().map(|&s| outline.at(s)).collect::<Vec<_>>(),
    )
}
