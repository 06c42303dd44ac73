//! Python bindings: every function checks and converts its arguments and calls the crate; no geometry here.

mod alignment;
mod convert;
mod fit;
mod fold;
mod inner_distance;
mod interrupt;
mod matching;
mod model;
mod outline;
mod partial_match;
mod shape_context;
mod stack;
mod threads;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::alignment::{align, alignment_costs};
    #[pymodule_export]
    use super::fit::{
        fit_jointly, fit_known, mirrorings, PyFlexibleTemplate, PyJointExplanation, PyJointFits,
    };
    #[pymodule_export]
    use super::fold::{fold_layers, FoldedLayers};
    #[pymodule_export]
    use super::inner_distance::inner_distances;
    #[pymodule_export]
    use super::interrupt::Stop;
    #[pymodule_export]
    use super::matching::{default_parameters, PyCandidate, PyExplanation, PySeen};
    #[pymodule_export]
    use super::model::{axis_difference, outline_iou, reflect};
    #[pymodule_export]
    use super::outline::{
        carried, check_outline, nearest_on_outline, points_at, resample, sides, signed_area, simplify,
    };
    #[pymodule_export]
    use super::partial_match::{partial_matches, piece_difference};
    #[pymodule_export]
    use super::shape_context::{matching_costs, shape_contexts};
    #[pymodule_export]
    use super::stack::{fold_stack, PyFoldedStack};
    #[pymodule_export]
    use super::threads::set_threads;

    #[pymodule_init]
    fn init(m: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        m.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
