//! `resample(scheme, weights, n, seed)`.

use super::border::compute;
use crate::error::{require, room};
use crate::resample::{Ancestors, Scheme};
use crate::rng::Streams;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

/// Indices of `n` particles, ascending, drawn in proportion to `weights`.
///
/// `scheme` is `multinomial`, `stratified`, `systematic` or `residual`; `weights` is `(N,)`, not negative,
/// with a positive sum, and is normalised here. Raises `InputError`.
#[pyfunction]
#[pyo3(signature = (scheme, weights, n, seed = 0))]
pub fn resample<'py>(
    py: Python<'py>,
    scheme: &str,
    weights: PyReadonlyArray1<'py, f64>,
    n: usize,
    seed: u64,
) -> PyResult<Bound<'py, PyArray1<u32>>> {
    let scheme = Scheme::from_name(scheme)?;
    let mut weights = weights.as_array().to_vec();
    if let Some(weight) = weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
        require(false, "a weight", *weight, "a finite number, 0 or more")?;
    }
    let sum: f64 = weights.iter().sum();
    require(sum > 0.0 && sum.is_finite(), "the sum of weights", sum, "positive")?;
    let scale = 1.0 / sum;
    for weight in &mut weights {
        // The reciprocal of a sum that is almost nothing is no number.
        *weight = if scale.is_finite() { *weight * scale } else { *weight / sum };
    }
    require(u32::try_from(n).is_ok(), "n", n as f64, "0 to 4294967295")?;
    room("n draws", n.saturating_mul(2))?;
    let mut ancestors = Ancestors::default();
    compute(py, None, || {
        scheme.draw(&weights, n, &mut Streams::new(seed, 0, 0).resampling(), &mut ancestors);
        Ok(())
    })?;
    Ok(PyArray1::from_slice(py, ancestors.indices()))
}
