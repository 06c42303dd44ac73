//! Stage 3: virtual folding.

use crate::convert::{array, fold_error, outline, points, segment};
use foldrs::fold::{Folded, Piece};
use foldrs::model::Region;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
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

    /// Distance of every point from the region where two layers lie over each other; 0 within, inf if there is none.
    fn distance_to_double_layer<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let double = Region::double_layer(&self.0);
        let distances: Vec<f64> = self::points(&points)?
            .iter()
            .map(|p| double.distance(p))
            .collect();
        Ok(distances.to_pyarray(py))
    }

    /// Rings (even-odd) of the region where two layers lie over each other.
    #[getter]
    fn double_layer<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        Region::double_layer(&self.0)
            .rings
            .iter()
            .map(|r| array(py, r))
            .collect()
    }

    /// Whether each point of the unfolded outline, given by its arc length, is turned over.
    fn is_turned<'py>(&self, py: Python<'py>, arc: PyReadonlyArray1<'py, f64>) -> Bound<'py, PyArray1<bool>> {
        let turned: Vec<bool> = arc.as_array().iter().map(|&s| self.0.is_turned(s)).collect();
        turned.to_pyarray(py)
    }

    #[getter]
    fn holes(&self) -> usize {
        self.0.holes
    }
}

#[pyfunction]
#[pyo3(signature = (outline, axis))]
pub(crate) fn fold_layers(
    outline: PyReadonlyArray2<'_, f64>,
    axis: PyReadonlyArray2<'_, f64>,
) -> PyResult<FoldedLayers> {
    foldrs::fold(&self::outline(&outline)?, &segment(&axis)?)
        .map(FoldedLayers)
        .map_err(fold_error)
}
