//! The joint fit.

use crate::convert::{array, checked_scale, outline, points, segment};
use crate::matching::{map_array, PySeen};
use foldrs::fit::{
    explain_from, explain_jointly, FlexibleTemplate, FoldCount, JointExplanation, JointFits, KnownFold,
    Looks, Picture,
};
use foldrs::hypothesis::Face;
use foldrs::matching::claim_axes;
use foldrs::{Outline, Point};
use numpy::{PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, ToPyArray};
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
        py: Python<'_>,
        outline: PyReadonlyArray2<'_, f64>,
        mirror_from: PyReadonlyArray2<'_, f64>,
        mirror_to: PyReadonlyArray2<'_, f64>,
        parameters: &Bound<'_, PyAny>,
        spread: Option<Vec<f64>>,
    ) -> PyResult<Self> {
        let pairs = mirror_pairs(&mirror_from, &mirror_to)?;
        let parameters = crate::matching::parameters(parameters)?;
        let outline = self::outline(&outline)?;
        let prepared = py.detach(|| {
            let template = FlexibleTemplate::new(&outline, &pairs, &parameters.fit);
            match spread {
                Some(spread) => template.with_spread(&spread),
                None => Some(template),
            }
        });
        prepared
            .map(Self)
            .ok_or_else(|| PyValueError::new_err("spreads must be positive, one a vertex of the outline"))
    }
}

/// How far pairs of points that are meant to mirror each other are from it, and whether the joint fit holds them alike.
#[pyfunction]
pub(crate) fn mirrorings(
    outline: PyReadonlyArray2<'_, f64>,
    mirror_from: PyReadonlyArray2<'_, f64>,
    mirror_to: PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<(f64, bool)>> {
    let pairs = mirror_pairs(&mirror_from, &mirror_to)?;
    let told = foldrs::fit::mirrorings(&self::outline(&outline)?, &pairs);
    Ok(told.iter().map(|pair| (pair.off, pair.held)).collect())
}

fn mirror_pairs(
    from: &PyReadonlyArray2<'_, f64>,
    to: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<[Point; 2]>> {
    let (from, to) = (points(from)?, points(to)?);
    if from.len() != to.len() {
        return Err(PyValueError::new_err("every mirrored point needs its partner"));
    }
    Ok(from.into_iter().zip(to).map(|(a, b)| [a, b]).collect())
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
    fn axes<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.0.axes.iter().map(|axis| array(py, axis)).collect()
    }

    #[getter]
    fn creases<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.0.creases.iter().map(|crease| array(py, crease)).collect()
    }

    #[getter]
    fn to_seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        map_array(py, &self.0.to_seen)
    }

    #[getter]
    fn flap_on_top(&self) -> f64 {
        self.0.picture.flap_on_top
    }

    #[getter]
    fn picture_gain(&self) -> f64 {
        self.0.picture.gain
    }

    #[getter]
    fn surprise(&self) -> f64 {
        self.0.surprise
    }

    #[getter]
    fn draws(&self) -> usize {
        self.0.draws.len()
    }

    fn reach_drawn<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        most: usize,
    ) -> PyResult<DrawnReach<'py>> {
        let points = self::points(&points)?;
        let drawn = crate::interrupt::run(py, || self.0.reach_drawn(&points, most))?;
        let shape = [drawn.len(), points.len()];
        let each = || drawn.iter().flatten();
        let places: Vec<f64> = each().flat_map(|mark| [mark.place.x, mark.place.y]).collect();
        let off_outline: Vec<f64> = each().map(|mark| mark.off_outline).collect();
        let to_double_layer: Vec<f64> = each().map(|mark| mark.to_double_layer).collect();
        Ok((
            places.to_pyarray(py).reshape([shape[0], shape[1], 2])?,
            off_outline.to_pyarray(py).reshape(shape)?,
            to_double_layer.to_pyarray(py).reshape(shape)?,
        ))
    }
}

/// Of d draws and k landmarks: places (d, k, 2), distances off the outline and to the double layer, (d, k).
type DrawnReach<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// Structure tensors of a picture's colours, their pixels a pixel of the picture, and perhaps those of its heights, all of
/// one shape (h, w, 3); the looks of the cloth, their pixels a pixel of the picture, and where in it the first one lies.
type PictureParts<'py> = (
    PyReadonlyArray3<'py, f32>,
    f64,
    Option<PyReadonlyArray3<'py, f32>>,
    Option<(PyReadonlyArray2<'py, u8>, f64, (f64, f64))>,
);

/// The joint fits for every number of folds tried.
#[pyclass(frozen, module = "foldrs._core", name = "JointFits")]
pub(crate) struct PyJointFits(JointFits);

#[pymethods]
impl PyJointFits {
    #[getter]
    fn most(&self) -> usize {
        self.0.by_folds.len().saturating_sub(1)
    }

    #[getter]
    fn enough(&self) -> usize {
        self.0.enough()
    }

    fn surprise(&self, folds: usize) -> f64 {
        self.0.surprise(folds)
    }

    fn explanations(&self, folds: usize) -> Vec<PyJointExplanation> {
        let found = self.0.by_folds.get(folds).into_iter().flatten();
        found.cloned().map(PyJointExplanation).collect()
    }
}

/// Claims about the fold axis, without testing them, and the joint fits they lead to; the best evidence first.
#[pyfunction]
#[pyo3(signature = (seen, outlines, templates, folds, up_to=false, scale=None, picture=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn fit_jointly(
    py: Python<'_>,
    seen: &PySeen,
    outlines: Vec<PyReadonlyArray2<'_, f64>>,
    templates: Vec<PyRef<'_, PyFlexibleTemplate>>,
    folds: usize,
    up_to: bool,
    scale: Option<f64>,
    picture: Option<PictureParts<'_>>,
) -> PyResult<PyJointFits> {
    if outlines.len() != templates.len() {
        return Err(PyValueError::new_err("every outline needs its template"));
    }
    let scale = checked_scale(scale)?;
    let outlines: Vec<Outline> = outlines.iter().map(outline).collect::<PyResult<_>>()?;
    let templates: Vec<FlexibleTemplate> = templates.iter().map(|t| t.0.clone()).collect();
    let picture = picture.as_ref().map(prepared).transpose()?;
    let folds = if up_to {
        FoldCount::UpTo(folds)
    } else {
        FoldCount::Exactly(folds)
    };
    let fits = crate::interrupt::run(py, || {
        let claims = claim_axes(&seen.seen, &outlines, scale, &seen.parameters);
        explain_jointly(
            &seen.seen,
            &templates,
            &claims,
            scale,
            picture.as_ref(),
            folds,
            &seen.parameters,
        )
    })?;
    Ok(PyJointFits(fits))
}

/// The joint fits of one template from axes (kept part on the left), creases (cloth on the left) and faces known
/// beforehand; the best evidence first.
#[pyfunction]
#[pyo3(signature = (seen, template, folds, scale=None))]
pub(crate) fn fit_known(
    py: Python<'_>,
    seen: &PySeen,
    template: &PyFlexibleTemplate,
    folds: Vec<(PyReadonlyArray2<'_, f64>, PyReadonlyArray2<'_, f64>, bool)>,
    scale: Option<f64>,
) -> PyResult<Vec<PyJointExplanation>> {
    let known = |(axis, crease, mirrored): &(_, _, bool)| {
        Ok(KnownFold {
            template: 0,
            axis: segment(axis)?,
            crease: segment(crease)?,
            face: if *mirrored { Face::Mirrored } else { Face::Seen },
        })
    };
    let known: Vec<KnownFold> = folds.iter().map(known).collect::<PyResult<_>>()?;
    let templates = std::slice::from_ref(&template.0);
    let scale = checked_scale(scale)?;
    let found = crate::interrupt::run(py, || {
        explain_from(&seen.seen, templates, &known, scale, None, &seen.parameters)
    })?;
    Ok(found.into_iter().map(PyJointExplanation).collect())
}

/// The picture of its parts.
fn prepared((tensor, scale, steps, looks): &PictureParts<'_>) -> PyResult<Picture> {
    let view = tensor.as_array();
    let (height, width, parts) = view.dim();
    let alike = steps.as_ref().is_none_or(|s| s.as_array().dim() == view.dim());
    if parts != 3 || !alike || !(*scale > 0.0 && scale.is_finite()) {
        return Err(PyValueError::new_err(
            "structure tensors must be of one shape (h, w, 3) and their scale positive",
        ));
    }
    let parts_of = |array: &PyReadonlyArray3<'_, f32>| {
        let rows = array.as_array();
        rows.rows().into_iter().map(|t| [t[0], t[1], t[2]]).collect()
    };
    Ok(Picture {
        width,
        height,
        tensor: parts_of(tensor),
        steps: steps.as_ref().map(parts_of),
        scale: *scale,
        looks: looks.as_ref().map(prepared_looks).transpose()?,
    })
}

fn prepared_looks((look, scale, (x, y)): &(PyReadonlyArray2<'_, u8>, f64, (f64, f64))) -> PyResult<Looks> {
    if !(*scale > 0.0 && [*scale, *x, *y].iter().all(|v| v.is_finite())) {
        return Err(PyValueError::new_err(
            "the scale of looks must be positive and their origin finite",
        ));
    }
    let view = look.as_array();
    let (height, width) = view.dim();
    Ok(Looks {
        width,
        height,
        look: view.iter().copied().collect(),
        scale: *scale,
        origin: Point::new(*x, *y),
    })
}
