//! Several folds.

use crate::convert::{array, fold_error, outline, points, segment};
use foldrs::model::Region;
use foldrs::stack::{self, FoldedStack};
use foldrs::{Outline, Segment};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// An outline folded several times, layer by layer.
#[pyclass(frozen, module = "foldrs._core", name = "FoldedStack")]
pub(crate) struct PyFoldedStack {
    stack: FoldedStack,
    outline: Outline,
    double: Region,
}

#[pymethods]
impl PyFoldedStack {
    #[getter]
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.stack.layers.iter().map(|l| array(py, &l.ring())).collect()
    }

    #[getter]
    fn turned(&self) -> Vec<Vec<bool>> {
        let folds = self.stack.axes.len();
        let layers = self.stack.layers.iter();
        layers
            .map(|l| (0..folds).map(|k| l.turned.by(k)).collect())
            .collect()
    }

    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, self.outline.points())
    }

    fn creases<'py>(&self, py: Python<'py>, fold: usize) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        let seen = self.stack.creases_seen(fold);
        seen.iter().map(|crease| array(py, crease)).collect()
    }

    #[getter]
    fn double_layer<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.double.rings.iter().map(|ring| array(py, ring)).collect()
    }

    fn distance_to_double_layer<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = self::points(&points)?;
        let distances = py.detach(|| points.iter().map(|p| self.double.distance(p)).collect());
        Ok(PyArray1::from_vec(py, distances))
    }

    fn place<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        arc: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (points, arc) = (self::points(&points)?, arc.as_array());
        if points.len() != arc.len() {
            return Err(PyValueError::new_err("every point needs its arc length"));
        }
        let placed: Vec<_> = points
            .iter()
            .zip(arc)
            .map(|(p, s)| self.stack.place(p, *s))
            .collect();
        array(py, &placed)
    }
}

#[pyfunction]
#[pyo3(signature = (outline, axes, on_top=None))]
pub(crate) fn fold_stack(
    py: Python<'_>,
    outline: PyReadonlyArray2<'_, f64>,
    axes: Vec<PyReadonlyArray2<'_, f64>>,
    on_top: Option<Vec<bool>>,
) -> PyResult<PyFoldedStack> {
    let axes = axes.iter().map(segment).collect::<PyResult<Vec<Segment>>>()?;
    let (outline, on_top) = (self::outline(&outline)?, on_top.unwrap_or_default());
    let folded = || {
        let stack = stack::fold_stack(&outline, &axes, &on_top)?;
        Ok(PyFoldedStack {
            outline: stack.outline()?,
            double: stack.double_layer(),
            stack,
        })
    };
    py.detach(folded).map_err(fold_error)
}
