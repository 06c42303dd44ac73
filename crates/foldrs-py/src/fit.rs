//! The joint fit.

use crate::convert::{array, outline, points};
use crate::matching::{map_array, PySeen};
use foldrs::fit::{explain_jointly, FlexibleTemplate, JointExplanation, Picture};
use foldrs::matching::claim_axes;
use foldrs::{Outline, Point};
use numpy::{PyArray2, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A template prepared for the joint fit.
#[pyclass(frozen, module = "foldrs._core", name = "FlexibleTemplate")]
pub(crate) struct PyFlexibleTemplate(FlexibleTemplate);

#[pymethods]
impl PyFlexibleTemplate {
    #[new]
    #[pyo3(signature = (outline, mirror_from, mirror_to, parameters, spread=None))]
    fn new(
        outline: PyReadonlyArray2<'_, f64>,
        mirror_from: PyReadonlyArray2<'_, f64>,
        mirror_to: PyReadonlyArray2<'_, f64>,
        parameters: &Bound<'_, PyAny>,
        spread: Option<Vec<f64>>,
    ) -> PyResult<Self> {
        let (from, to) = (points(&mirror_from)?, points(&mirror_to)?);
        if from.len() != to.len() {
            return Err(PyValueError::new_err("every mirrored point needs its partner"));
        }
        let pairs: Vec<[Point; 2]> = from.into_iter().zip(to).map(|(a, b)| [a, b]).collect();
        let parameters = crate::matching::parameters(parameters)?;
        let template = FlexibleTemplate::new(&self::outline(&outline)?, &pairs, &parameters.fit);
        let Some(spread) = spread else {
            return Ok(Self(template));
        };
        template
            .with_spread(&spread, &parameters.fit)
            .map(Self)
            .ok_or_else(|| PyValueError::new_err("spreads must be positive, one a vertex of the outline"))
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
    fn flap_on_top(&self) -> f64 {
        self.0.rim.flap_on_top
    }

    #[getter]
    fn picture_gain(&self) -> f64 {
        self.0.rim.gain
    }

    #[getter]
    fn surprise(&self) -> f64 {
        self.0.surprise
    }
}

/// Claims about the fold axis, without testing them, and the joint fits they lead to; the best evidence first.
#[pyfunction]
#[pyo3(signature = (seen, outlines, templates, scale=None, tensor=None, tensor_scale=1.0))]
pub(crate) fn fit_jointly(
    py: Python<'_>,
    seen: &PySeen,
    outlines: Vec<PyReadonlyArray2<'_, f64>>,
    templates: Vec<PyRef<'_, PyFlexibleTemplate>>,
    scale: Option<f64>,
    tensor: Option<PyReadonlyArray3<'_, f32>>,
    tensor_scale: f64,
) -> PyResult<(Vec<PyJointExplanation>, f64)> {
    if outlines.len() != templates.len() {
        return Err(PyValueError::new_err("every outline needs its template"));
    }
    let outlines: Vec<Outline> = outlines.iter().map(outline).collect::<PyResult<_>>()?;
    let templates: Vec<FlexibleTemplate> = templates.iter().map(|t| t.0.clone()).collect();
    let picture = tensor.map(|t| picture(&t, tensor_scale)).transpose()?;
    let fits = py.detach(|| {
        let claims = claim_axes(&seen.seen, &outlines, scale, &seen.parameters);
        let fits = explain_jointly(
            &seen.seen,
            &templates,
            &claims,
            scale,
            picture.as_ref(),
            &seen.parameters,
        );
        (
            fits.folds.into_iter().map(PyJointExplanation).collect(),
            fits.unfolded,
        )
    });
    Ok(fits)
}

/// The picture of an (h, w, 3) array of structure tensors.
fn picture(tensor: &PyReadonlyArray3<'_, f32>, scale: f64) -> PyResult<Picture> {
    let view = tensor.as_array();
    let (height, width, parts) = view.dim();
    if parts != 3 || !(scale > 0.0 && scale.is_finite()) {
        return Err(PyValueError::new_err(
            "the structure tensor must be of shape (h, w, 3) and its scale positive",
        ));
    }
    let tensor = view.rows().into_iter().map(|t| [t[0], t[1], t[2]]).collect();
    Ok(Picture {
        width,
        height,
        tensor,
        scale,
    })
}
