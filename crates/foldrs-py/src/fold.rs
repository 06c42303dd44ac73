//! Stage 3: virtual folding.

use crate::convert::{array, fold_error, outline, points, segment};
use foldrs::fold::{Folded, Piece};
use foldrs::model::Region;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use std::sync::OnceLock;

/// An outline folded over an axis, layer by layer.
#[pyclass(frozen, module = "foldrs._core")]
pub(crate) struct FoldedLayers {
    folded: Folded,
    /// Where two layers lie over each other, once it was asked for.
    double: OnceLock<Region>,
}

impl FoldedLayers {
    /// To be called without the GIL: another thread may be computing it.
    fn double(&self) -> &Region {
        self.double.get_or_init(|| Region::double_layer(&self.folded))
    }
}

fn arrays<'py>(py: Python<'py>, pieces: &[Piece]) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
    pieces.iter().map(|p| array(py, &p.points)).collect()
}

#[pymethods]
impl FoldedLayers {
    #[getter]
    fn kept<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        arrays(py, &self.folded.kept)
    }

    #[getter]
    fn flap<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        arrays(py, &self.folded.flap)
    }

    #[getter]
    fn creases<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.folded.creases.iter().map(|c| array(py, c)).collect()
    }

    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.folded.outline.points)
    }

    /// Distance of every point from the region where two layers lie over each other; 0 within, inf if there is none.
    fn distance_to_double_layer<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = self::points(&points)?;
        let distances: Vec<f64> = py.detach(|| {
            let double = self.double();
            points.iter().map(|p| double.distance(p)).collect()
        });
        Ok(distances.to_pyarray(py))
    }

    /// Rings (even-odd) of the region where two layers lie over each other.
    #[getter]
    fn double_layer<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        let double = py.detach(|| self.double());
        double.rings.iter().map(|r| array(py, r)).collect()
    }

    /// Whether each point of the unfolded outline, given by its arc length, is turned over.
    fn is_turned<'py>(&self, py: Python<'py>, arc: PyReadonlyArray1<'py, f64>) -> Bound<'py, PyArray1<bool>> {
        let turned: Vec<bool> = arc.as_array().iter().map(|&s| self.folded.is_turned(s)).collect();
        turned.to_pyarray(py)
    }

    #[getter]
    fn holes(&self) -> usize {
        self.folded.holes
    }
}

#[pyfunction]
#[pyo3(signature = (outline, axis))]
pub(crate) fn fold_layers(
    py: Python<'_>,
    outline: PyReadonlyArray2<'_, f64>,
    axis: PyReadonlyArray2<'_, f64>,
) -> PyResult<FoldedLayers> {
    let (outline, axis) = (self::outline(&outline)?, segment(&axis)?);
    let folded = py.detach(|| foldrs::fold(&outline, &axis)).map_err(fold_error)?;
    Ok(FoldedLayers {
        folded,
        double: OnceLock::new(),
    })
}
