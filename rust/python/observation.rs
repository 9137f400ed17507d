//! `Observation`: what reaches a tracker, read from Python.

use super::body_evidence::{extract_evidence, orientation};
use super::numbers::Numbers;
use super::{rows, same_length};
use crate::Error;
use crate::arm::cues::landmark::{Landmark, SeenJoint};
use crate::observation::{self, Sample, What};
use crate::quaternion::Quaternion;
use nalgebra::{Vector2, Vector3};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use std::sync::Arc;

/// What reaches a tracker: a time, and what was observed then. Made by `inertial`, `patch`, `landmark`,
/// `orientation` and `picture`.
///
/// `index` is its number among those of its source, for messages.
#[pyclass(frozen, module = "pytracker._core")]
pub struct Observation {
    /// What it is to the tracker.
    pub of: observation::Observation,
    /// The evidence as it was given, of a picture.
    given: Option<Py<PyAny>>,
}

/// `None`, a pixel of the only camera, or one pixel a camera.
#[derive(FromPyObject)]
enum Pixels {
    #[pyo3(transparent)]
    One(Numbers<2>),
    #[pyo3(transparent)]
    Several(Vec<Option<[f64; 2]>>),
}

fn seen(pixel: [f64; 2]) -> Option<Vector2<f64>> {
    // NaN in both is how arrays say "not seen".
    (!pixel.iter().all(|x| x.is_nan())).then(|| Vector2::from(pixel))
}

fn made(of: observation::Observation, index: Option<usize>) -> Observation {
    Observation { of: observation::Observation { index, ..of }, given: None }
}

fn sampled(
    time_s: f64,
    acc: [f64; 3],
    q_world_sensor: [f64; 4],
    gyr: Option<[f64; 3]>,
    index: Option<usize>,
) -> Observation {
    let world_sensor = Quaternion::from_wxyz(q_world_sensor);
    let sample = Sample { time_s, acceleration: acc.into(), world_sensor, turn_rate: gyr.map(Vector3::from) };
    made(observation::Observation::inertial(sample), index)
}

#[pymethods]
impl Observation {
    /// An arm's IMU sample: specific force `(3,)` in m/s², orientation `(4,)` sensor to world (w first), and turn rate
    /// `(3,)` in rad/s where there is a gyroscope.
    #[staticmethod]
    #[pyo3(signature = (time_s, acc, q_world_sensor, gyr = None, index = None))]
    fn inertial(
        time_s: f64,
        acc: Numbers<3>,
        q_world_sensor: Numbers<4>,
        gyr: Option<Numbers<3>>,
        index: Option<usize>,
    ) -> Self {
        sampled(time_s, acc.0, q_world_sensor.0, gyr.map(|gyr| gyr.0), index)
    }

    /// An arm's camera frame: where the patch was seen, `(u, v)`, `None` where it was not; of several cameras a list.
    #[staticmethod]
    #[pyo3(signature = (time_s, pixel, index = None))]
    fn patch(time_s: f64, pixel: Option<Pixels>, index: Option<usize>) -> Self {
        let pixels = match pixel {
            None => vec![None],
            Some(Pixels::One(pixel)) => vec![seen(pixel.0)],
            Some(Pixels::Several(several)) => several.into_iter().map(|p| p.and_then(seen)).collect(),
        };
        made(observation::Observation::patch(time_s, pixels), index)
    }

    /// Where a camera saw `shoulder` or `elbow` of an arm, of the frame that comes next: `(u, v)` and its standard deviation, px.
    /// Raises `InputError`.
    #[staticmethod]
    #[pyo3(signature = (time_s, joint, pixel, sd_px, camera = 0, index = None))]
    fn landmark(
        time_s: f64,
        joint: &str,
        pixel: [f64; 2],
        sd_px: f64,
        camera: usize,
        index: Option<usize>,
    ) -> PyResult<Self> {
        let landmark = Landmark { joint: SeenJoint::from_name(joint)?, camera, pixel: pixel.into(), sd: sd_px };
        Ok(made(observation::Observation::landmark(time_s, landmark), index))
    }

    /// How a segment that wears an IMU is turned, of a body or the upper arm of an arm: `left_upper_arm`, `right_forearm`...; orientation `(4,)` segment
    /// to world (w first); standard deviations of where it points and of its roll (infinite: it says nothing of it), rad.
    /// Raises `InputError`.
    #[staticmethod]
    #[pyo3(signature = (time_s, segment, q_world_segment, sd_rad, roll_sd_rad = f64::INFINITY, index = None))]
    fn orientation(
        time_s: f64,
        segment: &str,
        q_world_segment: [f64; 4],
        sd_rad: f64,
        roll_sd_rad: f64,
        index: Option<usize>,
    ) -> PyResult<Self> {
        let worn = orientation(segment, q_world_segment, sd_rad, roll_sd_rad)?;
        Ok(made(observation::Observation::orientation(time_s, worn), index))
    }

    /// A body's camera frame: what it shows, such as a `pytracker.evidence.BodyEvidence`: `edges` `(H, W)` bytes (0 is none), `None` without an image,
    /// `blobs` `(B, 2)`, centres, px, in no order; `skin_region` and `foreground_region`, each `None` or a pair: distance of
    /// every pixel `(H, W)`, px, and some points `(P, 2)`, px; `keypoints` `(P, 9, 3)`: of each person u, v and standard
    /// deviation, px, in the order of `KEYPOINTS`, NaN where not seen; `shrunk`: how many times smaller than the frame the picture
    /// was that all but the keypoints were found in. Raises `InputError`.
    #[staticmethod]
    #[pyo3(signature = (time_s, evidence, index = None))]
    fn picture(time_s: f64, evidence: Bound<'_, PyAny>, index: Option<usize>) -> PyResult<Self> {
        let read = Arc::new(extract_evidence(&evidence)?);
        let of = observation::Observation { index, ..observation::Observation::picture(time_s, read) };
        Ok(Self { of, given: Some(evidence.unbind()) })
    }

    /// Many samples of an arm's IMU, numbered from `first`: times `(M,)`, specific force `(M, 3)`, orientation `(M, 4)`, turn rate
    /// `(M, 3)` or `None`. Raises `InputError`.
    #[staticmethod]
    #[pyo3(signature = (time_s, acc, q_world_sensor, gyr = None, first = 0))]
    fn inertials(
        time_s: PyReadonlyArray1<'_, f64>,
        acc: PyReadonlyArray2<'_, f64>,
        q_world_sensor: PyReadonlyArray2<'_, f64>,
        gyr: Option<PyReadonlyArray2<'_, f64>>,
        first: usize,
    ) -> PyResult<Vec<Self>> {
        let (acc, q) = (rows::<3>("acc", &acc)?, rows::<4>("q_world_sensor", &q_world_sensor)?);
        let gyr = gyr.as_ref().map(|gyr| rows::<3>("gyr", gyr)).transpose()?;
        same_length("acc", acc.len(), &time_s)?;
        same_length("q_world_sensor", q.len(), &time_s)?;
        if let Some(gyr) = &gyr {
            same_length("gyr", gyr.len(), &time_s)?;
        }
        let one = |(i, &at): (usize, &f64)| sampled(at, acc[i], q[i], gyr.as_ref().map(|gyr| gyr[i]), Some(first + i));
        Ok(time_s.as_array().iter().enumerate().map(one).collect())
    }

    /// Many frames of an arm, numbered from `first`: times `(T,)`, pixels of every camera `(T, C, 2)`, NaN where not seen.
    /// Raises `InputError`.
    #[staticmethod]
    #[pyo3(signature = (time_s, pixels, first = 0))]
    fn patches(
        time_s: PyReadonlyArray1<'_, f64>,
        pixels: PyReadonlyArray3<'_, f64>,
        first: usize,
    ) -> PyResult<Vec<Self>> {
        let pixels = pixels.as_array();
        same_length("pixels", pixels.shape()[0], &time_s)?;
        if pixels.shape()[2] != 2 {
            let (name, got, unit) = ("pixels", pixels.shape()[2], "coordinates");
            return Err(Error::Size { name, got, unit, expected: 2 }.into());
        }
        let one = |(i, (&at, cameras)): (usize, (&f64, numpy::ndarray::ArrayView2<'_, f64>))| {
            let pixels = cameras.rows().into_iter().map(|p| seen([p[0], p[1]])).collect();
            made(observation::Observation::patch(at, pixels), Some(first + i))
        };
        Ok(time_s.as_array().iter().zip(pixels.outer_iter()).enumerate().map(one).collect())
    }

    /// Recording time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.of.time_s
    }

    /// Its number among those of its source; `None` where nobody counted.
    #[getter]
    fn index(&self) -> Option<usize> {
        self.of.index
    }

    /// Who observed it: `forearm` or another segment that wears an IMU, `camera[0]`, all `cameras` of an arm.
    #[getter]
    fn source(&self) -> String {
        self.of.source.to_string()
    }

    /// What it is: `IMU sample`, `landmark`, `orientation` or `frame`.
    #[getter]
    fn what(&self) -> &'static str {
        self.of.what.name()
    }

    /// Whether there is an estimate at it.
    #[getter]
    fn is_frame(&self) -> bool {
        self.of.what.is_frame()
    }

    /// What a picture shows, as it was given; `None` of anything else.
    #[getter]
    fn evidence(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.given.as_ref().map(|given| given.clone_ref(py))
    }

    /// Of a patch: where each camera saw it, `None` where it did not; nothing of anything else.
    #[getter]
    fn pixels(&self) -> Vec<Option<[f64; 2]>> {
        match &self.of.what {
            What::Patch(pixels) => pixels.iter().map(|pixel| pixel.map(Into::into)).collect(),
            _ => Vec::new(),
        }
    }

    fn __repr__(&self) -> String {
        format!("Observation({} of {} at {:.3} s)", self.of.what.name(), self.of.source, self.of.time_s)
    }
}
