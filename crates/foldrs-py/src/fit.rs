//! The joint fit.

use crate::convert::{array, outline, points};
use crate::matching::{map_array, PySeen};
use foldrs::fit::{explain_jointly, FlexibleTemplate, JointExplanation};
use foldrs::matching::claim_axes;
use foldrs::{Outline, Point, Segment};
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
pub(crate) struct PyJointExplanation {
    fit: JointExplanation,
    original_axis: Segment,
}

#[pymethods]
impl PyJointExplanation {
    #[getter]
    fn template(&self) -> usize {
        self.fit.template
    }

    #[getter]
    fn original_axis<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.original_axis)
    }

    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.fit.outline)
    }

    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.fit.axis)
    }

    #[getter]
    fn crease<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.fit.crease)
    }

    #[getter]
    fn to_seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        map_array(py, &self.fit.to_seen)
    }

    #[getter]
    fn surprise(&self) -> f64 {
        self.fit.surprise
    }
}

/// Claims about the fold axis, without testing them, and the joint fits they lead to; the best evidence first.
#[pyfunction]
#[pyo3(signature = (seen, outlines, templates, scale=None))]
pub(crate) fn fit_jointly(
    py: Python<'_>,
    seen: &PySeen,
    outlines: Vec<PyReadonlyArray2<'_, f64>>,
    templates: Vec<PyRef<'_, PyFlexibleTemplate>>,
    scale: Option<f64>,
) -> PyResult<(Vec<PyJointExplanation>, f64)> {
    if outlines.len() != templates.len() {
        return Err(PyValueError::new_err("every outline needs its template"));
    }
    let outlines: Vec<Outline> = outlines.iter().map(outline).collect::<PyResult<_>>()?;
    let templates: Vec<FlexibleTemplate> = templates.iter().map(|t| t.0.clone()).collect();
    let fits = py.detach(|| {
        let claims = claim_axes(&seen.seen, &outlines, scale, &seen.parameters);
        let fits = explain_jointly(&seen.seen, &templates, &claims, scale, &seen.parameters.fit);
        let folds = fits.folds.into_iter();
        let told = folds.map(|fit| PyJointExplanation {
            original_axis: claims[fit.claim].hypothesis.axis,
            fit,
        });
        (told.collect(), fits.unfolded)
    });
    Ok(fits)
}
