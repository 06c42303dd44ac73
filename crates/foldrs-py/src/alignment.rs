//! Stage 4: order-preserving alignment.

use foldrs::alignment::{self as stage, AlignmentParameters};
use foldrs::shape_context::CostMatrix;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The cheapest alignment over all starts: its cost a row, and the matched pairs.
#[pyfunction]
#[pyo3(signature = (cost, skip_penalty=0.6))]
pub(crate) fn align<'py>(
    py: Python<'py>,
    cost: PyReadonlyArray2<'py, f64>,
    skip_penalty: f64,
) -> PyResult<(f64, Bound<'py, PyArray2<i64>>)> {
    let (cost, parameters) = (matrix(&cost)?, parameters(skip_penalty)?);
    let found = py
        .detach(|| stage::align(&cost, &parameters, None))
        .ok_or_else(|| PyValueError::new_err("there is no alignment of finite cost"))?;
    let flat: Vec<i64> = found
        .pairs
        .iter()
        .flat_map(|&(i, j)| [i.into(), j.into()])
        .collect();
    Ok((found.cost, flat.to_pyarray(py).reshape([found.pairs.len(), 2])?))
}

/// Costs of the cheapest alignments from given starts, a row each.
#[pyfunction]
#[pyo3(signature = (cost, starts, skip_penalty=0.6))]
pub(crate) fn alignment_costs<'py>(
    py: Python<'py>,
    cost: PyReadonlyArray2<'py, f64>,
    starts: Vec<i64>,
    skip_penalty: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (cost, parameters) = (matrix(&cost)?, parameters(skip_penalty)?);
    let start = |&s: &i64| {
        usize::try_from(s)
            .ok()
            .filter(|&s| s < cost.columns)
            .ok_or_else(|| {
                PyValueError::new_err(format!("start {s} is no column: there are {}", cost.columns))
            })
    };
    let starts: Vec<usize> = starts.iter().map(start).collect::<PyResult<_>>()?;
    let costs = py.detach(|| stage::alignment_costs(&cost, &parameters, &starts));
    Ok(costs.to_pyarray(py))
}

fn matrix(cost: &PyReadonlyArray2<'_, f64>) -> PyResult<CostMatrix> {
    let view = cost.as_array();
    if view.is_empty() {
        return Err(PyValueError::new_err(
            "a cost matrix needs at least one row and one column",
        ));
    }
    if let Some(c) = view.iter().find(|c| !(c.is_finite() && **c >= 0.0)) {
        return Err(PyValueError::new_err(format!(
            "costs must be finite and not negative, not {c}"
        )));
    }
    Ok(CostMatrix {
        rows: view.nrows(),
        columns: view.ncols(),
        values: view.iter().map(|&c| c as f32).collect(),
    })
}

fn parameters(skip_penalty: f64) -> PyResult<AlignmentParameters> {
    if !(skip_penalty.is_finite() && skip_penalty >= 0.0) {
        return Err(PyValueError::new_err(format!(
            "the skip penalty must be finite and not negative, not {skip_penalty}"
        )));
    }
    let mut parameters = AlignmentParameters::default();
    parameters.skip_penalty = skip_penalty;
    Ok(parameters)
}
