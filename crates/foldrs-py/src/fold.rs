//! Stage 3: virtual folding.

use crate::convert::{array, fold_error, outline, segment};
use foldrs::fold::{Folded, Piece};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

/// An outline folded over an axis, layer by layer.
#[pyclass(frozen, module = "foldrs._core")]
pub(crate) struct FoldedLayers(Folded);

fn arrays<'py>(py: Python<'py>, pieces: &[Piece]) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
    pieces.iter().map(|p| array(py, &p.points)).collect()
}

#[pymethods]
impl FoldedLayers {
    #[getter]
    fn kept<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        arrays(py, &self.0.kept)
    }

    #[getter]
    fn flap<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        arrays(py, &self.0.flap)
    }

    #[getter]
    fn creases<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.0.creases.iter().map(|c| array(py, c)).collect()
    }

    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.outline.points)
    }

    #[getter]
    fn holes(&self) -> usize {
        self.0.holes
    }
}

#[pyfunction]
#[pyo3(signature = (outline, axis))]
pub(crate) fn fold_layers(outline: PyReadonlyArray2<'_, f64>, axis: PyReadonlyArray2<'_, f64>) -> PyResult<FoldedLayers> {
    foldrs::fold(&self::outline(&outline)?, &segment(&axis)?).map(FoldedLayers).map_err(fold_error)
}
