//! `Estimate` and `Place`: what a tracker says, as NumPy arrays; or all of it, one row a frame.

use crate::estimate::{self, Point};
use crate::particles::Summary;
use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Quantities of a place and of a column of the state: mean, mode, standard deviation, 2.5 % and 97.5 % quantile.
const QUANTITIES: usize = 5;

/// What a tracker knows at one time.
#[pyclass(frozen, module = "pytracker._core")]
pub struct Estimate {
    /// What it knows.
    pub of: estimate::Estimate,
    /// Names of its places.
    pub names: Vec<&'static str>,
}

/// A joint of an estimate: world, metres.
#[pyclass(frozen, module = "pytracker._core")]
pub struct Place(Point);

fn vector<'py>(py: Python<'py>, v: &[f64]) -> Bound<'py, PyArray1<f64>> {
    v.to_pyarray(py)
}

fn quantities(point: &Point) -> [f64; 3 * QUANTITIES] {
    let each = [point.mean, point.mode, point.sd, point.lo, point.hi];
    std::array::from_fn(|k| each[k / 3][k % 3])
}

/// Of the columns that have bands, `(5, K)`.
fn columns(summary: &Summary) -> Vec<f64> {
    let k = summary.bands.len();
    let sd = (0..k).map(|d| summary.covariance[(d, d)].max(0.0).sqrt());
    let numbers = summary.mean.iter().take(k).copied().chain(summary.mode.iter().copied()).chain(sd);
    let bands = summary.bands.iter().map(|b| b.lo).chain(summary.bands.iter().map(|b| b.hi));
    numbers.chain(bands).collect()
}

#[pymethods]
impl Place {
    /// Weighted mean, `(3,)` m.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.mean.as_slice())
    }

    /// Where the cloud is densest, `(3,)` m.
    #[getter]
    fn mode<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.mode.as_slice())
    }

    /// Standard deviation per axis, `(3,)` m.
    #[getter]
    fn sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.sd.as_slice())
    }

    /// 2.5 % quantile per axis, `(3,)` m.
    #[getter]
    fn lo<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.lo.as_slice())
    }

    /// 97.5 % quantile per axis, `(3,)` m.
    #[getter]
    fn hi<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.hi.as_slice())
    }

    fn __repr__(&self) -> String {
        let (m, s) = (&self.0.mean, &self.0.sd);
        format!("[{:.3}, {:.3}, {:.3}] ± [{:.3}, {:.3}, {:.3}] m", m.x, m.y, m.z, s.x, s.y, s.z)
    }
}

#[pymethods]
impl Estimate {
    /// Recording time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.of.time_s
    }

    /// The joints by name. An arm: `wrist` and `elbow` (Tao & Hu eq. 2); a body: those of `KEY_JOINTS`.
    #[getter]
    fn places<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (name, place) in self.names.iter().zip(&self.of.places) {
            out.set_item(name, Place(place.clone()))?;
        }
        Ok(out)
    }

    /// Mean of the whole state, `(D,)`. An arm: position, velocity, then bias and patch offset where estimated; a body: the
    /// free channels, m and rad.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.of.state.mean.as_slice())
    }

    /// Covariance of the whole state, `(D, D)`.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let c = &self.of.state.covariance;
        // Symmetric, so column order and row order are one.
        PyArray1::from_slice(py, c.as_slice()).reshape([c.nrows(), c.ncols()]).expect("D * D values")
    }

    /// Mean, mode, standard deviation, 2.5 % and 97.5 % quantile of the state, `(5, K)`: of an arm's position, of all of a
    /// body's channels.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let numbers = columns(&self.of.state);
        let width = numbers.len() / QUANTITIES;
        PyArray1::from_vec(py, numbers).reshape([QUANTITIES, width])
    }

    /// A body: the skin blob given to head, left hand and right hand, `(3, 2)` px; NaN where none was.
    #[getter]
    fn blobs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        PyArray1::from_iter(py, blobs(&self.of)).reshape([3, 2])
    }

    /// Effective sample size; `None` for a Gaussian method.
    #[getter]
    fn ess(&self) -> Option<f64> {
        self.of.ess
    }

    /// Log evidence of this frame's observations; `None` where nothing was observed or the weights are no likelihoods.
    #[getter]
    fn log_evidence(&self) -> Option<f64> {
        self.of.log_evidence
    }

    /// Why it must not be believed, in words; empty where nothing speaks against it.
    #[getter]
    fn doubt(&self) -> &'static str {
        self.of.doubt.unwrap_or_default()
    }

    fn __repr__(&self) -> String {
        let first = self.names.last().copied().unwrap_or_default();
        let place = self.of.places.last().map(|place| Place(place.clone()).__repr__()).unwrap_or_default();
        format!("Estimate(time_s={:.3}, {first}={place})", self.of.time_s)
    }
}

fn blobs(estimate: &estimate::Estimate) -> impl Iterator<Item = f64> {
    estimate.blobs.iter().flat_map(|blob| blob.unwrap_or([f64::NAN; 2])).collect::<Vec<_>>().into_iter()
}

/// One row an estimate: places by name `(T, 5, 3)`, `state` `(T, 5, K)`, `mean` and `sd` `(T, D)`, `place_covariance` of the first
/// three columns, `blobs`, `ess`, `log_evidence`, `doubt`; a quantity that the method does not have is NaN.
pub fn table<'py>(
    py: Python<'py>,
    names: &[&'static str],
    estimates: &[estimate::Estimate],
) -> PyResult<Bound<'py, PyDict>> {
    let (out, rows) = (PyDict::new(py), estimates.len());
    for (p, name) in names.iter().enumerate() {
        let numbers = estimates.iter().flat_map(|e| quantities(&e.places[p]));
        out.set_item(name, PyArray1::from_iter(py, numbers).reshape([rows, QUANTITIES, 3])?)?;
    }
    let (width, dim) = estimates.first().map_or((0, 0), |e| (e.state.bands.len(), e.state.mean.len()));
    let state = PyArray1::from_iter(py, estimates.iter().flat_map(|e| columns(&e.state)));
    out.set_item("state", state.reshape([rows, QUANTITIES, width])?)?;
    let mean = PyArray1::from_iter(py, estimates.iter().flat_map(|e| e.state.mean.iter().copied()));
    out.set_item("mean", mean.reshape([rows, dim])?)?;
    // The whole covariance of every frame of an hour would be a gigabyte.
    let sd = estimates.iter().flat_map(|e| (0..dim).map(|d| e.state.covariance[(d, d)].max(0.0).sqrt()));
    out.set_item("sd", PyArray1::from_iter(py, sd).reshape([rows, dim])?)?;
    let of_place =
        |k: usize, e: &estimate::Estimate| e.state.covariance.get((k % 3, k / 3)).copied().unwrap_or(f64::NAN);
    let place = estimates.iter().flat_map(|e| (0..9).map(move |k| of_place(k, e)));
    out.set_item("place_covariance", PyArray1::from_iter(py, place).reshape([rows, 3, 3])?)?;
    out.set_item("blobs", PyArray1::from_iter(py, estimates.iter().flat_map(blobs)).reshape([rows, 3, 2])?)?;
    let numbers = |of: fn(&estimate::Estimate) -> f64| PyArray1::from_iter(py, estimates.iter().map(of));
    out.set_item("time_s", numbers(|e| e.time_s))?;
    out.set_item("ess", numbers(|e| e.ess.unwrap_or(f64::NAN)))?;
    out.set_item("log_evidence", numbers(|e| e.log_evidence.unwrap_or(f64::NAN)))?;
    out.set_item("doubt", estimates.iter().map(|e| e.doubt.unwrap_or_default()).collect::<Vec<_>>())?;
    Ok(out)
}
