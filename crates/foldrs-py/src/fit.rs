//! The joint fit.

use crate::convert::{array, outline, points};
use crate::matching::{map_array, PyCandidate, PySeen};
use foldrs::fit::{explain_jointly, FlexibleTemplate, JointExplanation};
use foldrs::Point;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A template prepared for the joint fit.
#[pyclass(frozen, module = "foldrs._core", name = "FlexibleTemplate")]
pub(crate) struct PyFlexibleTemplate(FlexibleTemplate);

#[pymethods]
impl PyFlexibleTemplate {
    #[new]
    fn new(
        outline: PyReadonlyArray2<'_, f64>,
        mirror_from: PyReadonlyArray2<'_, f64>,
        mirror_to: PyReadonlyArray2<'_, f64>,
        parameters: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (from, to) = (points(&mirror_from)?, points(&mirror_to)?);
        if from.len() != to.len() {
            return Err(PyValueError::new_err("every mirrored point needs its partner"));
        }
        let pairs: Vec<[Point; 2]> = from.into_iter().zip(to).map(|(a, b)| [a, b]).collect();
        let parameters = crate::matching::parameters(parameters)?;
        Ok(Self(FlexibleTemplate::new(
            &self::outline(&outline)?,
            &pairs,
            &parameters.fit,
        )))
    }
}

/// A template fitted jointly with its crease.
#[pyclass(frozen, module = "foldrs._core", name = "JointExplanation")]
pub(crate) struct PyJointExplanation(JointExplanation);

#[pymethods]
impl PyJointExplanation {
    #[getter]
    fn template(&self) -> usize {
        self.0.template
    }

    #[getter]
    fn candidate(&self) -> usize {
        self.0.candidate
    }

    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.outline)
    }

    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.axis)
    }

    #[getter]
    fn crease<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.crease)
    }

    #[getter]
    fn to_seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        map_array(py, &self.0.to_seen)
    }

    #[getter]
    fn surprise(&self) -> f64 {
        self.0.surprise
    }
}

#[pyfunction]
#[pyo3(signature = (seen, templates, candidates, scale=None))]
pub(crate) fn fit_jointly(
    py: Python<'_>,
    seen: &PySeen,
    templates: Vec<PyRef<'_, PyFlexibleTemplate>>,
    candidates: Vec<PyRef<'_, PyCandidate>>,
    scale: Option<f64>,
) -> PyResult<Vec<PyJointExplanation>> {
    let templates: Vec<FlexibleTemplate> = templates.iter().map(|t| t.0.clone()).collect();
    let candidates: Vec<_> = candidates.iter().map(|c| c.0.clone()).collect();
    if candidates.iter().any(|c| c.template >= templates.len()) {
        return Err(PyValueError::new_err(
            "a candidate names a template that is not given",
        ));
    }
    let fits =
        py.detach(|| explain_jointly(&seen.seen, &templates, &candidates, scale, &seen.parameters.fit));
    Ok(fits.into_iter().map(PyJointExplanation).collect())
}
