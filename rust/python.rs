//! The Python module `pytracker._core`: convert, check shape, let the interpreter go, call, convert.
//!
//! Nothing is computed here, and nothing outside `rust/python` knows Python.

#![allow(clippy::needless_pass_by_value)] // arguments are extracted for the call and belong to it

mod arm_arguments;
mod body_arguments;
mod body_evidence;
mod border;
mod estimate;
mod numbers;
mod observation;
mod record;
mod resample;
mod skeleton;
mod tracker;

use crate::Error;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(
    pytracker._core,
    InputError,
    PyValueError,
    "What was given cannot be used; the message names the place, the value and what was expected."
);
pyo3::create_exception!(
    pytracker._core,
    TrackingError,
    PyRuntimeError,
    "The track was lost beyond recovery; the message names the frame."
);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        if error.is_loss_of_track() {
            TrackingError::new_err(error.to_string())
        } else {
            InputError::new_err(error.to_string())
        }
    }
}

/// The compiled half of pytracker.
#[pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::arm_arguments::check_camera;
    #[pymodule_export]
    use super::body_evidence::missed_edges;
    #[pymodule_export]
    use super::estimate::{Estimate, Place};
    #[pymodule_export]
    use super::observation::Observation;
    #[pymodule_export]
    use super::record::LayerRecord;
    #[pymodule_export]
    use super::resample::resample;
    #[pymodule_export]
    use super::skeleton::Skeleton;
    #[pymodule_export]
    use super::tracker::{Smoothing, Tracker};
    #[pymodule_export]
    use super::{InputError, TrackingError};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::border::hear_of_forks(module)?;
        // The frames before a loss; of a track that was lost at the first frame there are none.
        module.py().get_type::<TrackingError>().setattr("track", module.py().None())?;
        // Tuples, and a view: nobody may change them.
        module.add("ARM_DOUBTS", pyo3::types::PyTuple::new(module.py(), crate::arm::plausible::DOUBTS)?)?;
        let nothing_came = [crate::arm::incoming::UNSEEN, crate::arm::incoming::SILENT];
        module.add("ARM_NOTHING_CAME", pyo3::types::PyTuple::new(module.py(), nothing_came)?)?;
        module.add("ARM_NEWS_S", crate::arm::frame::NEWS_S)?;
        module.add("ARM_UNLIKE", crate::arm::alike::UNLIKE)?;
        let limits = std::collections::BTreeMap::from(crate::arm::alike::LIMITS).into_pyobject(module.py())?;
        module.add("ARM_ALIKE", pyo3::types::PyMappingProxy::new(module.py(), limits.as_mapping()))?;
        let joints = crate::body::KEY_JOINTS;
        module.add("KEY_JOINTS", pyo3::types::PyTuple::new(module.py(), joints.map(|(name, _, _)| name))?)?;
        module
            .add("KEY_PLACES", pyo3::types::PyTuple::new(module.py(), joints.map(|(_, bone, along)| (bone, along)))?)?;
        let points = crate::body::KEYPOINTS;
        module.add("KEYPOINTS", pyo3::types::PyTuple::new(module.py(), points.map(|(name, _, _)| name))?)
    }
}

/// Rows of a `(T, K)` array.
fn rows<const K: usize>(name: &'static str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; K]>> {
    let view = array.as_array();
    if view.ncols() != K {
        return Err(Error::Size { name, got: view.ncols(), unit: "columns", expected: K }.into());
    }
    Ok(view.rows().into_iter().map(|row| std::array::from_fn(|k| row[k])).collect())
}

/// As many rows as there are times.
fn same_length(name: &'static str, got: usize, times: &PyReadonlyArray1<'_, f64>) -> PyResult<()> {
    let expected = times.as_array().len();
    if got == expected { Ok(()) } else { Err(Error::Size { name, got, unit: "rows", expected }.into()) }
}
