//! `LayerRecord`: what a layer did in one cycle, as NumPy arrays.

use crate::filter;
use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;

/// One layer of one cycle: the cloud it was given, moved, weighed and resampled.
#[pyclass(frozen, module = "pytracker._core")]
pub struct LayerRecord(filter::LayerRecord);

/// Those of a cycle, in order.
pub fn records(history: filter::History) -> Vec<LayerRecord> {
    history.layers.into_iter().map(LayerRecord).collect()
}

#[pymethods]
impl LayerRecord {
    /// Which layer, from 0.
    #[getter]
    fn layer(&self) -> usize {
        self.0.layer
    }

    /// Which island, from 0; 0 where there is one.
    #[getter]
    fn island(&self) -> usize {
        self.0.island
    }

    /// Recording time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s
    }

    /// The particles after the layer's transition, `(N, D)`.
    #[getter]
    fn predicted<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let len = self.0.weights.len();
        self.0.predicted.to_pyarray(py).reshape([len, self.0.predicted.len() / len])
    }

    /// Their normalised weights after its likelihoods, `(N,)`.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.weights.to_pyarray(py)
    }

    /// Whose copies the layer leaves, `(N,)`; `None` where it was not resampled.
    #[getter]
    fn ancestors<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<u32>>> {
        self.0.ancestors.as_ref().map(|ancestors| ancestors.to_pyarray(py))
    }

    fn __repr__(&self) -> String {
        let resampled = if self.0.ancestors.is_some() { "resampled" } else { "not resampled" };
        format!("LayerRecord(layer={}, time_s={:.3}, {resampled})", self.0.layer, self.0.time_s)
    }
}
