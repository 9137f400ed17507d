//! `Numbers`: so many numbers from a NumPy array or any sequence.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// `K` numbers. A sequence of floats costs 60 ns an element, which a stream pays for every IMU sample: an array of floats is
/// read as it lies.
pub struct Numbers<const K: usize>(pub [f64; K]);

impl<'py, const K: usize> FromPyObject<'_, 'py> for Numbers<K> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let lying = given.cast::<PyArray1<f64>>().ok().filter(|array| array.len().is_ok_and(|len| len == K));
        let read = lying.and_then(|array| {
            let mut numbers = [0.0; K];
            numbers
                .iter_mut()
                .enumerate()
                .try_for_each(|(k, x)| array.get_owned(k).map(|value| *x = value))
                .map(|()| numbers)
        });
        read.map_or_else(|| given.extract(), Ok).map(Self)
    }
}
