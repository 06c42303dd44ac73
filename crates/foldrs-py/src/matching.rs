//! Stages 1 to 4: matching.

use crate::convert::{array, checked_scale, outline, parameter_error};
use foldrs::fold::Layer;
use foldrs::hypothesis::Face;
use foldrs::matching::{cheapest_folds, explain, match_folded, Candidate, Seen};
use foldrs::registration::PlaneMap;
use foldrs::{Outline, Parameters};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyAny;

pub(crate) fn parameters(any: &Bound<'_, PyAny>) -> PyResult<Parameters> {
    let parameters: Parameters =
        pythonize::depythonize(any).map_err(|e| parameter_error(format!("parameters: {e}")))?;
    parameters.check().map_err(|e| parameter_error(e.to_string()))?;
    Ok(parameters)
}

#[pyfunction]
pub(crate) fn default_parameters(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    Ok(pythonize::pythonize(py, &Parameters::default())?)
}

/// A seen outline prepared for matching.
#[pyclass(frozen, module = "foldrs._core", name = "Seen")]
pub(crate) struct PySeen {
    pub(crate) seen: Seen,
    pub(crate) parameters: Parameters,
}

#[pymethods]
impl PySeen {
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        parameters: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let parameters = self::parameters(parameters)?;
        let outline = outline(&points)?;
        let seen = py.detach(|| Seen::new(outline, &parameters));
        Ok(Self { seen, parameters })
    }

    /// The equally spaced points that are aligned.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, self.seen.points())
    }

    /// The candidate creases.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.seen.sides().iter().map(|s| array(py, &s.segment)).collect()
    }

    /// Matches against templates; candidates best first, and the cost of every template unfolded.
    #[pyo3(signature = (templates, scale=None, cheapest_only=false))]
    fn matches(
        &self,
        py: Python<'_>,
        templates: Vec<PyReadonlyArray2<'_, f64>>,
        scale: Option<f64>,
        cheapest_only: bool,
    ) -> PyResult<(Vec<PyCandidate>, Vec<f64>)> {
        let templates: Vec<Outline> = templates.iter().map(outline).collect::<PyResult<_>>()?;
        let find = if cheapest_only {
            cheapest_folds
        } else {
            match_folded
        };
        let scale = checked_scale(scale)?;
        let matching = crate::interrupt::run(py, || find(&self.seen, &templates, scale, &self.parameters))?;
        Ok((
            matching.candidates.into_iter().map(PyCandidate).collect(),
            matching.unfolded,
        ))
    }

    /// Lays a fold of a template over the seen outline; `None` where that cannot be done.
    #[pyo3(signature = (template, candidate))]
    fn explain(
        &self,
        py: Python<'_>,
        template: PyReadonlyArray2<'_, f64>,
        candidate: &PyCandidate,
    ) -> PyResult<Option<PyExplanation>> {
        let template = outline(&template)?;
        let axis = candidate.0.hypothesis.axis;
        Ok(py
            .detach(|| explain(&self.seen, &template, &axis, &self.parameters))
            .map(PyExplanation))
    }
}

/// A fold of a template compared with the seen outline.
#[pyclass(frozen, module = "foldrs._core", name = "Candidate")]
pub(crate) struct PyCandidate(pub(crate) Candidate);

#[pymethods]
impl PyCandidate {
    #[getter]
    fn template(&self) -> usize {
        self.0.template
    }

    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.hypothesis.axis)
    }

    #[getter]
    fn cost(&self) -> f64 {
        self.0.cost
    }

    #[getter]
    fn confidence(&self) -> f64 {
        self.0.hypothesis.confidence
    }

    #[getter]
    fn side(&self) -> usize {
        self.0.hypothesis.side
    }

    #[getter]
    fn mirrored(&self) -> bool {
        self.0.face == Face::Mirrored
    }
}

/// A fold of a template laid over the seen outline.
#[pyclass(frozen, module = "foldrs._core", name = "Explanation")]
pub(crate) struct PyExplanation(foldrs::matching::Explanation);

#[pymethods]
impl PyExplanation {
    #[getter]
    fn folded<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.folded.iter().map(|p| p.point).collect::<Vec<_>>())
    }

    /// 0 kept, 1 flap, 2 crease.
    #[getter]
    fn layer<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        let code = |layer| match layer {
            Layer::Kept => 0u8,
            Layer::Flap => 1,
            Layer::Crease => 2,
        };
        self.0
            .folded
            .iter()
            .map(|p| code(p.layer))
            .collect::<Vec<_>>()
            .to_pyarray(py)
    }

    /// Arc length of every folded point on the unfolded template.
    #[getter]
    fn arc<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0
            .folded
            .iter()
            .map(|p| p.arc)
            .collect::<Vec<_>>()
            .to_pyarray(py)
    }

    /// Index of every folded point's partner among the seen points; -1 for none.
    #[getter]
    fn partner<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.0
            .partner
            .iter()
            .map(|p| p.map_or(-1, |j| j as i64))
            .collect::<Vec<_>>()
            .to_pyarray(py)
    }

    /// The map of the folded template onto the seen outline, (2, 3).
    #[getter]
    fn to_seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        map_array(py, &self.0.to_seen)
    }

    #[getter]
    fn crease<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &self.0.crease)
    }

    #[getter]
    fn cost(&self) -> f64 {
        self.0.cost
    }
}

/// The (2, 3) array of a map.
pub(crate) fn map_array<'py>(py: Python<'py>, m: &PlaneMap) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = vec![
        vec![m.linear.m11, m.linear.m12, m.offset.x],
        vec![m.linear.m21, m.linear.m22, m.offset.y],
    ];
    Ok(PyArray2::from_vec2(py, &rows)?)
}
