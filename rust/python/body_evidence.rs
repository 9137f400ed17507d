//! What Python shows a body tracker of one frame, read.

use super::border::compute;
use super::rows;
use crate::body::KEYPOINTS;
use crate::body::cues::keypoints::{Keypoint, Person};
use crate::body::cues::orientation::{Orientation, Segment};
use crate::body::edges::EdgeImage;
use crate::body::{Picture, Region};
use crate::{Error, Result};
use nalgebra::{Quaternion, UnitQuaternion};
use numpy::{PyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

/// Distances `(H, W)` and points `(P, 2)` of a region.
type RegionArgument<'py> = (PyReadonlyArray2<'py, f32>, PyReadonlyArray2<'py, f64>);

#[derive(FromPyObject)]
struct EvidenceArgument<'py> {
    edges: Option<PyReadonlyArray2<'py, u8>>,
    blobs: PyReadonlyArray2<'py, f64>,
    skin_region: Option<RegionArgument<'py>>,
    foreground_region: Option<RegionArgument<'py>>,
    keypoints: Option<PyReadonlyArray3<'py, f64>>,
}

pub fn extract_evidence(evidence: &Bound<'_, PyAny>) -> PyResult<Picture> {
    let read: PyResult<EvidenceArgument<'_>> = evidence.extract();
    let e =
        read.map_err(|error| super::InputError::new_err(format!("what a picture shows cannot be read: {error}")))?;
    Ok(Picture {
        edges: e.edges.as_ref().map(image).transpose()?,
        blobs: rows("blobs", &e.blobs)?,
        skin: e.skin_region.map(region).transpose()?,
        foreground: e.foreground_region.map(region).transpose()?,
        keypoints: e.keypoints.as_ref().map_or(Ok(Vec::new()), people)?,
    })
}

fn region((distance, points): RegionArgument<'_>) -> PyResult<Region> {
    let view = distance.as_array();
    let (height, width) = view.dim();
    Ok(Region::new(width, height, view.iter().copied().collect(), rows("points of a region", &points)?)?)
}

/// `(P, 9, 3)`; a point with a NaN was not seen.
fn people(keypoints: &PyReadonlyArray3<'_, f64>) -> Result<Vec<Person>> {
    let view = keypoints.as_array();
    let (_, points, values) = view.dim();
    for (name, got, expected) in [("keypoints", points, KEYPOINTS.len()), ("values of a keypoint", values, 3)] {
        if got != expected {
            return Err(Error::Size { name, got, unit: "entries", expected });
        }
    }
    let point = |person: usize, k: usize| {
        let [u, v, sd_px] = [0, 1, 2].map(|d| view[(person, k, d)]);
        let is_seen = !(u.is_nan() || v.is_nan() || sd_px.is_nan());
        is_seen.then_some(Keypoint { pixel: [u, v], sd_px })
    };
    Ok((0..view.dim().0).map(|person| std::array::from_fn(|k| point(person, k))).collect())
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

/// Edges `(H, W)`, any strides.
pub fn image(edges: &PyReadonlyArray2<'_, u8>) -> Result<EdgeImage> {
    let view = edges.as_array();
    let (height, width) = view.dim();
    match view.as_slice() {
        Some(bytes) => EdgeImage::new(width, height, bytes),
        None => EdgeImage::new(width, height, &view.iter().copied().collect::<Vec<_>>()),
    }
}

/// Share of an outline's pixels that lie on no edge (Li & Kulić eq. 4), 0 to 1: edges `(H, W)` bytes, outlines
/// `(N, 4, 2)` px flattened to `(N, 8)`. Raises `InputError`.
#[pyfunction]
pub fn missed_edges<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u8>,
    outlines: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let image = image(&edges)?;
    let corners = |c: [f64; 8]| [[c[0], c[1]], [c[2], c[3]], [c[4], c[5]], [c[6], c[7]]];
    let outlines: Vec<_> = rows::<8>("outlines", &outlines)?.into_iter().map(corners).collect();
    let mut missed = vec![0.0; outlines.len()];
    compute(py, None, || {
        image.missed_all(&outlines, &mut missed);
        Ok(())
    })?;
    Ok(PyArray1::from_vec(py, missed))
}
