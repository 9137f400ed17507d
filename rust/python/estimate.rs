//! What a tracker says, as NumPy arrays: one estimate, or one row a frame.

use crate::arm;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What a tracker knows at one time: joints in the world, metres.
#[pyclass(frozen, module = "pytracker._core")]
pub struct Estimate(pub arm::Estimate);

fn vector<'py>(py: Python<'py>, v: &[f64]) -> Bound<'py, PyArray1<f64>> {
    v.to_pyarray(py)
}

#[pymethods]
impl Estimate {
    /// Recording time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s
    }

    /// Mean of the wrist, `(3,)` m.
    #[getter]
    fn wrist<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.wrist.mean.as_slice())
    }

    /// Where the wrist's cloud is densest, `(3,)` m.
    #[getter]
    fn wrist_mode<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.wrist.mode.as_slice())
    }

    /// Standard deviation of the wrist per axis, `(3,)` m.
    #[getter]
    fn wrist_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.wrist.sd.as_slice())
    }

    /// 2.5 % quantile of the wrist per axis, `(3,)` m.
    #[getter]
    fn wrist_lo<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.wrist.lo.as_slice())
    }

    /// 97.5 % quantile of the wrist per axis, `(3,)` m.
    #[getter]
    fn wrist_hi<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.wrist.hi.as_slice())
    }

    /// Mean of the elbow, `(3,)` m (Tao & Hu eq. 2); its spread is the wrist's.
    #[getter]
    fn elbow<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.elbow.mean.as_slice())
    }

    /// Mean of the whole state, `(D,)`: position, velocity, then bias and patch offset where estimated.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.mean.as_slice())
    }

    /// Covariance of the whole state, `(D, D)`.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let c = &self.0.covariance;
        // Symmetric, so column order and row order are one.
        PyArray1::from_slice(py, c.as_slice()).reshape([c.nrows(), c.ncols()]).expect("D * D values")
    }

    /// Effective sample size; `None` for a Gaussian method.
    #[getter]
    fn ess(&self) -> Option<f64> {
        self.0.ess
    }

    /// Log evidence of this frame's observations; `None` where nothing was observed.
    #[getter]
    fn log_evidence(&self) -> Option<f64> {
        self.0.log_evidence
    }

    /// Why it must not be believed, in words; empty where nothing speaks against it.
    #[getter]
    fn doubt(&self) -> &'static str {
        self.0.doubt.unwrap_or_default()
    }

    fn __repr__(&self) -> String {
        let (w, s) = (&self.0.wrist.mean, &self.0.wrist.sd);
        format!(
            "Estimate(time_s={:.3}, wrist=[{:.3}, {:.3}, {:.3}] ± [{:.3}, {:.3}, {:.3}] m)",
            self.0.time_s, w.x, w.y, w.z, s.x, s.y, s.z
        )
    }
}

/// Picks a joint of an estimate.
type Joint = fn(&arm::Estimate) -> &arm::Point;

/// One row an estimate, by name; a quantity that the method does not have is left out or NaN.
pub fn table<'py>(py: Python<'py>, estimates: &[arm::Estimate]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let joints: [(&str, Joint); 2] = [("wrist", |e| &e.wrist), ("elbow", |e| &e.elbow)];
    for (joint, point) in joints {
        out.set_item(joint, triples(py, estimates, |e| point(e).mean.as_slice())?)?;
        out.set_item(format!("{joint}_mode"), triples(py, estimates, |e| point(e).mode.as_slice())?)?;
        out.set_item(format!("{joint}_sd"), triples(py, estimates, |e| point(e).sd.as_slice())?)?;
        out.set_item(format!("{joint}_lo"), triples(py, estimates, |e| point(e).lo.as_slice())?)?;
        out.set_item(format!("{joint}_hi"), triples(py, estimates, |e| point(e).hi.as_slice())?)?;
    }
    let numbers = |of: fn(&arm::Estimate) -> f64| PyArray1::from_iter(py, estimates.iter().map(of));
    out.set_item("ess", numbers(|e| e.ess.unwrap_or(f64::NAN)))?;
    out.set_item("log_evidence", numbers(|e| e.log_evidence.unwrap_or(f64::NAN)))?;
    out.set_item("doubt", estimates.iter().map(|e| e.doubt.unwrap_or_default()).collect::<Vec<_>>())?;
    let dim = estimates.first().map_or(0, |e| e.mean.len());
    let mean = PyArray1::from_iter(py, estimates.iter().flat_map(|e| e.mean.iter().copied()));
    out.set_item("mean", mean.reshape([estimates.len(), dim])?)?;
    let covariance: Bound<'py, PyArray3<f64>> =
        PyArray1::from_iter(py, estimates.iter().flat_map(|e| e.covariance.iter().copied())).reshape([
            estimates.len(),
            dim,
            dim,
        ])?;
    out.set_item("covariance", covariance)?;
    Ok(out)
}

fn triples<'py>(
    py: Python<'py>,
    estimates: &[arm::Estimate],
    of: impl Fn(&arm::Estimate) -> &[f64],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    PyArray1::from_iter(py, estimates.iter().flat_map(|e| of(e).iter().copied())).reshape([estimates.len(), 3])
}
