//! `BodyEstimate`: what a body tracker knows at one frame.

use crate::body::{self, KEY_JOINTS};
use crate::particles::Summary;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;

/// What a body tracker knows at one frame: key joints in the world, metres; the state in metres and radians.
#[pyclass(frozen, module = "pytracker._core")]
pub struct BodyEstimate(pub body::BodyEstimate);

/// Mean, mode, standard deviation, 2.5 % and 97.5 % quantile, `(5, K)`.
fn five<'py>(py: Python<'py>, summary: &Summary) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let k = summary.bands.len();
    let sd = (0..k).map(|d| summary.covariance[(d, d)].max(0.0).sqrt());
    let numbers = summary.mean.iter().take(k).copied().chain(summary.mode.iter().copied()).chain(sd);
    let bands = summary.bands.iter().map(|b| b.lo).chain(summary.bands.iter().map(|b| b.hi));
    PyArray1::from_iter(py, numbers.chain(bands)).reshape([5, k])
}

#[pymethods]
impl BodyEstimate {
    /// Recording time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s
    }

    /// Mean, mode, standard deviation, 2.5 % and 97.5 % quantile of the key joints, `(5, 8, 3)` m, in the order of
    /// `KEY_JOINTS`.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        five(py, &self.0.joints)?.reshape([5, KEY_JOINTS.len(), 3])
    }

    /// The same of the state, `(5, D)`.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        five(py, &self.0.state)
    }

    /// Covariance of the state, `(D, D)`.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let c = &self.0.state.covariance;
        c.as_slice().to_pyarray(py).reshape([c.nrows(), c.ncols()])
    }

    /// The blob given to head, left hand and right hand, `(3, 2)` px; NaN where none was.
    #[getter]
    fn blobs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let numbers = self.0.blobs.iter().flat_map(|blob| blob.unwrap_or([f64::NAN; 2]));
        PyArray1::from_iter(py, numbers).reshape([3, 2])
    }

    /// Effective sample size.
    #[getter]
    fn ess(&self) -> f64 {
        self.0.ess
    }

    fn __repr__(&self) -> String {
        format!("BodyEstimate(time_s={:.3}, ess={:.1})", self.0.time_s, self.0.ess)
    }
}
