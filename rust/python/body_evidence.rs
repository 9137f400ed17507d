//! What Python shows a body tracker of one frame, read.

use super::border::compute;
use super::rows;
use crate::Result;
use crate::body::cues::orientation::{Orientation, Segment};
use crate::body::cues::{Given, Table};
use crate::body::edges::EdgeImage;
use crate::body::{Picture, Region, Smaller};
use nalgebra::{Quaternion, UnitQuaternion};
use numpy::{PyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;

/// What Python shows of a picture, by attribute.
struct Shown<'a, 'py>(&'a Bound<'py, PyAny>);

impl<'py> Shown<'_, 'py> {
    /// The attribute, where it is not `None`.
    fn get<T: FromPyObjectOwned<'py>>(&self, name: &str) -> PyResult<Option<T>> {
        let odd =
            |error: PyErr| super::InputError::new_err(format!("what a picture shows cannot be read: {name}: {error}"));
        let found = self.0.getattr(name).map_err(odd)?;
        if found.is_none() { Ok(None) } else { found.extract::<T>().map(Some).map_err(Into::into).map_err(odd) }
    }
}

impl<'py> Given for Shown<'_, 'py> {
    type Error = PyErr;

    fn bytes<T>(&self, name: &'static str, made: impl FnOnce(usize, usize, &[u8]) -> Result<T>) -> PyResult<Option<T>> {
        let found: Option<PyReadonlyArray2<'py, u8>> = self.get(name)?;
        Ok(found.map(|array| contiguous(&array, made)).transpose()?)
    }

    fn points(&self, name: &'static str) -> PyResult<Vec<[f64; 2]>> {
        let found: Option<PyReadonlyArray2<'py, f64>> = self.get(name)?;
        found.map_or(Ok(Vec::new()), |array| rows(name, &array))
    }

    fn region(&self, name: &'static str) -> PyResult<Option<Region>> {
        let found: Option<(PyReadonlyArray2<'py, f32>, PyReadonlyArray2<'py, f64>)> = self.get(name)?;
        let Some((distance, points)) = found else { return Ok(None) };
        let view = distance.as_array();
        let (height, width) = view.dim();
        let points = rows("points of a region", &points)?;
        Ok(Some(Region::new(width, height, view.iter().copied().collect(), points)?))
    }

    fn table(&self, name: &'static str) -> PyResult<Option<Table>> {
        let found: Option<PyReadonlyArray3<'py, f64>> = self.get(name)?;
        Ok(found.map(|array| (array.as_array().dim().into(), array.as_array().iter().copied().collect())))
    }

    fn smaller(&self, name: &'static str) -> PyResult<Smaller> {
        Ok(self.get(name)?.map_or(Ok(Smaller::default()), Smaller::new)?)
    }
}

/// Of any strides, as bytes row by row.
fn contiguous<T>(array: &PyReadonlyArray2<'_, u8>, made: impl FnOnce(usize, usize, &[u8]) -> Result<T>) -> Result<T> {
    let view = array.as_array();
    let (height, width) = view.dim();
    match view.as_slice() {
        Some(bytes) => made(width, height, bytes),
        None => made(width, height, &view.iter().copied().collect::<Vec<_>>()),
    }
}

/// What a picture shows, by the names of its evidence.
pub fn extract_evidence(evidence: &Bound<'_, PyAny>) -> PyResult<Picture> {
    Picture::read(&Shown(evidence))
}

/// How a segment that wears a sensor is turned.
pub fn orientation(segment: &str, [w, x, y, z]: [f64; 4], sd: f64, roll_sd: f64) -> Result<Orientation> {
    let q = Quaternion::new(w, x, y, z);
    crate::error::require((q.norm() - 1.0).abs() < 0.01, "length of q_world_segment", q.norm(), "1")?;
    Ok(Orientation {
        segment: Segment::from_name(segment)?,
        q_world_segment: UnitQuaternion::from_quaternion(q),
        sd,
        roll_sd,
    })
}

/// Share of an outline's pixels that lie on no edge (Li & Kulić eq. 4), 0 to 1: edges `(H, W)` bytes, outlines
/// `(N, 4, 2)` px flattened to `(N, 8)`. Raises `InputError`.
#[pyfunction]
pub fn missed_edges<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u8>,
    outlines: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let image = contiguous(&edges, EdgeImage::new)?;
    let corners = |c: [f64; 8]| [[c[0], c[1]], [c[2], c[3]], [c[4], c[5]], [c[6], c[7]]];
    let outlines: Vec<_> = rows::<8>("outlines", &outlines)?.into_iter().map(corners).collect();
    let mut missed = vec![0.0; outlines.len()];
    compute(py, None, || {
        image.missed_all(&outlines, &mut missed);
        Ok(())
    })?;
    Ok(PyArray1::from_vec(py, missed))
}
