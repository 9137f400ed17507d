//! `ArmTracker`: the online tracker, and a recording in one call.

use super::arm_arguments::{ArmArgument, extract_method, extract_views};
use super::border::compute;
use super::estimate::{Estimate, table};
use super::record::{LayerRecord, records};
use super::{rows, same_length};
use crate::Error;
use crate::arm::state::View;
use crate::arm::{self, Arm, Method, Noise, Sample};
use crate::error::guarded;
use crate::filter::History;
use crate::quaternion::Quaternion;
use nalgebra::{Vector2, Vector3};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// Follows one arm, sample by sample: `predict` at every IMU sample, `update` at every camera frame.
///
/// `arm` is a `pytracker.Arm`, `cameras` one `pytracker.Camera` or a list of them, `method` an arm method such
/// as `pytracker.Layered`. The same seed gives the same bits, online and by `run`, for any number of threads.
/// Raises `InputError` for what is out of range. Can be pickled and copied: a copy goes on where this stands.
#[pyclass(module = "pytracker._core")]
pub struct ArmTracker(arm::ArmTracker);

/// `None`, a pixel of the only camera, or one pixel a camera.
#[derive(FromPyObject)]
enum Pixels {
    #[pyo3(transparent)]
    One([f64; 2]),
    #[pyo3(transparent)]
    Several(Vec<Option<[f64; 2]>>),
}

fn seen(pixel: [f64; 2]) -> Option<Vector2<f64>> {
    // NaN in both is how arrays say "not seen".
    (!pixel.iter().all(|x| x.is_nan())).then(|| Vector2::from(pixel))
}

#[pymethods]
impl ArmTracker {
    #[new]
    #[pyo3(signature = (arm, cameras, method, seed = 0))]
    fn new(
        py: Python<'_>,
        arm: ArmArgument,
        #[pyo3(from_py_with = extract_views)] cameras: Vec<View>,
        #[pyo3(from_py_with = extract_method)] method: (Noise, Method),
        seed: u64,
    ) -> PyResult<Self> {
        let arm = Arm {
            shoulder: arm.shoulder_m.into(),
            upper_arm_m: arm.upper_arm_m,
            forearm_m: arm.forearm_m,
            wrist_start: arm.wrist_start_m.into(),
        };
        Ok(Self(compute(py, None, || arm::ArmTracker::new(arm, cameras, method.0, method.1, seed))?))
    }

    /// Take an IMU sample: time in s, specific force `(3,)` in m/s², orientation `(4,)` sensor to world (w
    /// first), and turn rate `(3,)` in rad/s where there is a gyroscope. Raises `InputError`.
    #[pyo3(signature = (time_s, acc, q_world_sensor, gyr = None))]
    fn predict(&mut self, time_s: f64, acc: [f64; 3], q_world_sensor: [f64; 4], gyr: Option<[f64; 3]>) -> PyResult<()> {
        let sample = Sample {
            time_s,
            acceleration: acc.into(),
            world_sensor: Quaternion::from_wxyz(q_world_sensor),
            turn_rate: gyr.map(Vector3::from),
        };
        Ok(guarded(|| self.0.predict(&sample))?)
    }

    /// Take a camera frame: `pixel` is `(u, v)`, `None` where nothing was seen, or one such per camera.
    /// Raises `InputError`, or `TrackingError` when no particle explains what was seen.
    #[pyo3(signature = (time_s, pixel))]
    fn update(&mut self, py: Python<'_>, time_s: f64, pixel: Option<Pixels>) -> PyResult<Estimate> {
        let pixels = self.pixels(pixel);
        Ok(Estimate(compute(py, None, || self.0.update(time_s, &pixels))?))
    }

    /// The same, with what every layer did (none for a Gaussian method): same bits, more memory. Raises as `update`.
    #[pyo3(signature = (time_s, pixel))]
    fn update_recorded(
        &mut self,
        py: Python<'_>,
        time_s: f64,
        pixel: Option<Pixels>,
    ) -> PyResult<(Estimate, Vec<LayerRecord>)> {
        let (pixels, mut history) = (self.pixels(pixel), History::default());
        let estimate = compute(py, None, || self.0.update_recorded(time_s, &pixels, Some(&mut history)))?;
        Ok((Estimate(estimate), records(history)))
    }

    /// What is known at `time_s`, between frames; draws nothing and changes nothing. Raises `InputError`.
    fn estimate(&self, py: Python<'_>, time_s: f64) -> PyResult<Estimate> {
        Ok(Estimate(compute(py, None, || self.0.estimate(time_s))?))
    }

    /// A stretch of a recording in one call, without the interpreter lock.
    ///
    /// IMU: times `(M,)`, specific force `(M, 3)`, orientation `(M, 4)`, turn rate `(M, 3)` or `None`. Frames:
    /// times `(T,)`, pixels `(T, C, 2)`, NaN where not seen; `first_frame` is the number of the first, for
    /// messages. Returns a dict of arrays, a row a frame; how many samples were used; and, where the track was
    /// lost, the message, the rows ending before that frame. `threads` limits how many work on a large set; it
    /// does not change the result. Raises `InputError`.
    #[pyo3(signature = (imu_time_s, acc, q_world_sensor, gyr, time_s, pixels, first_frame = 0, threads = None))]
    #[allow(clippy::too_many_arguments)] // one argument an array; keywords in Python
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        imu_time_s: PyReadonlyArray1<'py, f64>,
        acc: PyReadonlyArray2<'py, f64>,
        q_world_sensor: PyReadonlyArray2<'py, f64>,
        gyr: Option<PyReadonlyArray2<'py, f64>>,
        time_s: PyReadonlyArray1<'py, f64>,
        pixels: PyReadonlyArray3<'py, f64>,
        first_frame: usize,
        threads: Option<usize>,
    ) -> PyResult<(Bound<'py, PyDict>, usize, Option<String>)> {
        let samples = samples(&imu_time_s, &acc, &q_world_sensor, gyr.as_ref())?;
        let frames = frames(&time_s, &pixels)?;
        let stretch = compute(py, threads, || Ok(self.0.run(&samples, &frames, first_frame)))?;
        match stretch.stopped {
            Some(error) if !error.is_loss_of_track() => Err(error.into()),
            stopped => Ok((table(py, &stretch.estimates)?, stretch.used, stopped.map(|e| e.to_string()))),
        }
    }

    /// Frames so far, from number `first` on, each given those about it: a dict of arrays as of `run`, as many rows as are
    /// smoothed together; none beyond the last, or of a method that does not smooth. Raises `TrackingError` where no
    /// trajectory is found.
    #[pyo3(signature = (first, threads = None))]
    fn smoothed<'py>(&self, py: Python<'py>, first: usize, threads: Option<usize>) -> PyResult<Bound<'py, PyDict>> {
        table(py, &compute(py, threads, || self.0.smoothed(first))?)
    }

    /// The particles as they stand, `(N, D)`; `None` for a Gaussian method.
    #[getter]
    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let Some(set) = self.0.particles() else { return Ok(None) };
        Ok(Some(PyArray1::from_vec(py, set.rows()).reshape([set.len(), set.dim()])?))
    }

    /// Their normalised weights, `(N,)`; `None` for a Gaussian method.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.particles().map(|set| set.weights().to_pyarray(py))
    }

    /// The whole tracker as bytes, for `restore` by the same version.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &guarded(|| self.0.save())?))
    }

    /// A tracker from what `save` gave. Raises `InputError`.
    #[staticmethod]
    fn restore(state: &[u8]) -> PyResult<Self> {
        Ok(Self(guarded(|| arm::ArmTracker::restore(state))?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((py.get_type::<Self>().getattr("restore")?, (self.save(py)?,)))
    }
}

impl ArmTracker {
    /// One a camera.
    fn pixels(&self, pixel: Option<Pixels>) -> Vec<Option<Vector2<f64>>> {
        match pixel {
            None => vec![None; self.0.cameras()],
            Some(Pixels::One(pixel)) => vec![seen(pixel)],
            Some(Pixels::Several(several)) => several.into_iter().map(|p| p.and_then(seen)).collect(),
        }
    }
}

fn samples(
    times: &PyReadonlyArray1<'_, f64>,
    acc: &PyReadonlyArray2<'_, f64>,
    q_world_sensor: &PyReadonlyArray2<'_, f64>,
    gyr: Option<&PyReadonlyArray2<'_, f64>>,
) -> PyResult<Vec<Sample>> {
    let (acc, q) = (rows::<3>("acc", acc)?, rows::<4>("q_world_sensor", q_world_sensor)?);
    let gyr = gyr.map(|gyr| rows::<3>("gyr", gyr)).transpose()?;
    same_length("acc", acc.len(), times)?;
    same_length("q_world_sensor", q.len(), times)?;
    if let Some(gyr) = &gyr {
        same_length("gyr", gyr.len(), times)?;
    }
    Ok(times
        .as_array()
        .iter()
        .enumerate()
        .map(|(i, &time_s)| Sample {
            time_s,
            acceleration: acc[i].into(),
            world_sensor: Quaternion::from_wxyz(q[i]),
            turn_rate: gyr.as_ref().map(|gyr| Vector3::from(gyr[i])),
        })
        .collect())
}

type Frames = Vec<(f64, Vec<Option<Vector2<f64>>>)>;

fn frames(times: &PyReadonlyArray1<'_, f64>, pixels: &PyReadonlyArray3<'_, f64>) -> PyResult<Frames> {
    let pixels = pixels.as_array();
    same_length("pixels", pixels.shape()[0], times)?;
    if pixels.shape()[2] != 2 {
        return Err(Error::Size { name: "pixels", got: pixels.shape()[2], unit: "coordinates", expected: 2 }.into());
    }
    Ok(times
        .as_array()
        .iter()
        .zip(pixels.outer_iter())
        .map(|(&time_s, cameras)| (time_s, cameras.rows().into_iter().map(|p| seen([p[0], p[1]])).collect()))
        .collect())
}
