//! Stage 1: partial matching by chord angles.

use crate::convert::vertices;
use foldrs::partial_match::{self as stage, ChordAngles};
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyAny;

/// First point on the seen outline, first point on the template, length, difference, affinity.
type Match = (usize, usize, usize, f64, f64);

/// All good matches between pieces of two outlines, the best first.
#[pyfunction]
pub(crate) fn partial_matches(
    py: Python<'_>,
    seen_points: PyReadonlyArray2<'_, f64>,
    template_points: PyReadonlyArray2<'_, f64>,
    parameters: &Bound<'_, PyAny>,
) -> PyResult<Vec<Match>> {
    let (seen, template) = (vertices(&seen_points)?, vertices(&template_points)?);
    let parameters = crate::matching::parameters(parameters)?.partial_match;
    let found = py.detach(|| {
        let angles = |points| ChordAngles::new(points, parameters.delta);
        stage::partial_matches(&angles(&seen), &angles(&template), &parameters)
    });
    let told = found
        .iter()
        .map(|m| (m.start, m.template_start, m.length, m.difference, m.affinity));
    Ok(told.collect())
}

/// Mean squared difference of the chord angles of one piece and another.
#[pyfunction]
#[pyo3(signature = (seen_points, start, template_points, template_start, length, delta=5))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn piece_difference(
    py: Python<'_>,
    seen_points: PyReadonlyArray2<'_, f64>,
    start: usize,
    template_points: PyReadonlyArray2<'_, f64>,
    template_start: usize,
    length: usize,
    delta: usize,
) -> PyResult<f64> {
    let (seen, template) = (vertices(&seen_points)?, vertices(&template_points)?);
    for (name, start, n) in [
        ("start", start, seen.len()),
        ("template_start", template_start, template.len()),
    ] {
        if start >= n {
            return Err(PyValueError::new_err(format!(
                "{name} = {start} is no point of an outline of {n} points"
            )));
        }
    }
    let most = seen.len().min(template.len());
    // The shortest piece that holds an angle has two points beyond delta.
    if length > most || length < delta.saturating_add(2) {
        return Err(PyValueError::new_err(format!(
            "a piece must have from delta + 2 = {} to {most} points, not {length}",
            delta.saturating_add(2)
        )));
    }
    Ok(py.detach(|| {
        let angles = |points| ChordAngles::new(points, delta);
        stage::piece_difference(&angles(&seen), start, &angles(&template), template_start, length)
    }))
}
