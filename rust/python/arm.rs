//! `ArmTracker`: the online tracker, and a recording in one call.

use super::border::compute;
use super::estimate::{Estimate, table};
use super::record::{LayerRecord, records};
use super::{rows, same_length};
use crate::arm::ekf::Correction;
use crate::arm::particle::{ArmLayer, Cue, Mover};
use crate::arm::state::{GaussMarkov, View};
use crate::arm::{self, Arm, Method, Noise, Sample};
use crate::camera::Camera;
use crate::error::guarded;
use crate::filter::{History, Resampling};
use crate::quaternion::Quaternion;
use crate::resample::Scheme;
use crate::{Error, Result};
use nalgebra::{Matrix3, Vector2, Vector3};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// `pytracker.Arm`, read.
#[derive(FromPyObject)]
#[allow(clippy::struct_field_names)] // the names are Python's
struct ArmArgument {
    shoulder_m: [f64; 3],
    upper_arm_m: f64,
    forearm_m: f64,
    wrist_start_m: [f64; 3],
}

/// `pytracker.Camera`, read.
#[derive(FromPyObject)]
pub struct CameraArgument {
    matrix: [[f64; 3]; 3],
    distortion: [f64; 5],
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    patch_offset_m: [f64; 3],
}

/// What every arm method has, read.
#[derive(FromPyObject)]
struct NoiseArgument {
    accel_density: f64,
    gap_density: f64,
    hold_s: f64,
    position_start_sd_m: f64,
    velocity_start_sd: f64,
    walk_density: f64,
    pixel_sd: f64,
    outlier_fraction: f64,
    arm_length_sd_m: f64,
    rest_speed: f64,
    rest_accel: f64,
    rest_turn_rate: f64,
    bias: bool,
    bias_start_sd: f64,
    bias_density: f64,
    offset: bool,
    offset_start_sd_m: f64,
    offset_density: f64,
}

/// What a particle method has besides, read.
#[derive(FromPyObject)]
struct ParticlesArgument {
    layers: Vec<(String, Vec<String>)>,
    particles: usize,
    resampling: String,
    ess_threshold: f64,
}

/// What a Gaussian method has besides, read.
#[derive(FromPyObject)]
struct GaussianArgument {
    corrections: Vec<String>,
}

/// What a mixture has besides, read.
#[derive(FromPyObject)]
struct MixtureArgument {
    corrections: Vec<String>,
    components: usize,
    accel_growth: f64,
    forearm_sd_rad: f64,
    tilt_start_sd_rad: f64,
    tilt_density: f64,
    shoulder: bool,
    shoulder_sd_m: f64,
    shoulder_density: f64,
    clock_sd_s: f64,
}

impl MixtureArgument {
    fn add_to(&self, noise: &mut Noise) {
        let unknown = GaussMarkov { start_sd: 0.0, density: 0.0 };
        noise.bias = noise.bias.or(Some(unknown));
        noise.tilt = Some(GaussMarkov { start_sd: self.tilt_start_sd_rad, density: self.tilt_density });
        let shoulder = GaussMarkov { start_sd: self.shoulder_sd_m, density: self.shoulder_density };
        noise.shoulder = self.shoulder.then_some(shoulder);
        noise.clock = Some(GaussMarkov { start_sd: self.clock_sd_s, density: 0.0 });
        noise.accel_growth = self.accel_growth;
        noise.forearm_sd = self.forearm_sd_rad;
    }
}

/// Any of them, told apart by what it has.
#[derive(FromPyObject)]
enum MethodArgument {
    #[pyo3(transparent)]
    Particles(ParticlesArgument),
    #[pyo3(transparent)]
    Mixture(MixtureArgument),
    #[pyo3(transparent)]
    Gaussian(GaussianArgument),
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| rows[r][c])
}

impl TryFrom<CameraArgument> for Camera {
    type Error = Error;

    fn try_from(camera: CameraArgument) -> Result<Self> {
        let (intrinsics, rotation) = (matrix(camera.matrix), matrix(camera.rotation));
        Camera::new(intrinsics, camera.distortion, rotation, Vector3::from(camera.translation_m))
    }
}

impl TryFrom<CameraArgument> for View {
    type Error = Error;

    fn try_from(camera: CameraArgument) -> Result<Self> {
        let patch_offset = Vector3::from(camera.patch_offset_m);
        Ok(Self { camera: camera.try_into()?, patch_offset })
    }
}

impl From<NoiseArgument> for Noise {
    fn from(noise: NoiseArgument) -> Self {
        let walk = |wanted: bool, start_sd, density| wanted.then_some(GaussMarkov { start_sd, density });
        Self {
            accel_density: noise.accel_density,
            gap_density: noise.gap_density,
            hold_s: noise.hold_s,
            position_start_sd: noise.position_start_sd_m,
            velocity_start_sd: noise.velocity_start_sd,
            walk_density: noise.walk_density,
            pixel_sd: noise.pixel_sd,
            outlier_fraction: noise.outlier_fraction,
            arm_length_sd: noise.arm_length_sd_m,
            rest_speed: noise.rest_speed,
            rest_accel: noise.rest_accel,
            rest_turn_rate: noise.rest_turn_rate,
            bias: walk(noise.bias, noise.bias_start_sd, noise.bias_density),
            offset: walk(noise.offset, noise.offset_start_sd_m, noise.offset_density),
            ..Self::default()
        }
    }
}

impl TryFrom<MethodArgument> for Method {
    type Error = Error;

    fn try_from(method: MethodArgument) -> Result<Self> {
        Ok(match method {
            MethodArgument::Particles(p) => Self::Particles {
                layers: p
                    .layers
                    .iter()
                    .map(|(mover, cues)| {
                        let cues = cues.iter().map(|cue| Cue::from_name(cue)).collect::<Result<_>>()?;
                        Ok(ArmLayer { mover: Mover::from_name(mover)?, cues })
                    })
                    .collect::<Result<_>>()?,
                len: p.particles,
                resampling: Resampling::new(Scheme::from_name(&p.resampling)?, p.ess_threshold)?,
            },
            MethodArgument::Mixture(m) => Self::Mixture {
                components: m.components,
                corrections: m.corrections.iter().map(|c| Correction::from_name(c)).collect::<Result<_>>()?,
            },
            MethodArgument::Gaussian(g) => Self::Gaussian {
                corrections: g.corrections.iter().map(|c| Correction::from_name(c)).collect::<Result<_>>()?,
            },
        })
    }
}

/// Raise `InputError` where a `pytracker.Camera` is not one: focal lengths, rotation, finite numbers.
#[pyfunction]
pub fn check_camera(camera: CameraArgument) -> PyResult<()> {
    guarded(|| View::try_from(camera))?;
    Ok(())
}

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

/// One camera or a list of them.
fn extract_views(cameras: &Bound<'_, PyAny>) -> PyResult<Vec<View>> {
    let several = match cameras.extract::<CameraArgument>() {
        Ok(one) => vec![one],
        Err(_) => cameras.extract()?,
    };
    Ok(several.into_iter().map(View::try_from).collect::<Result<_>>()?)
}

fn extract_method(method: &Bound<'_, PyAny>) -> PyResult<(Noise, Method)> {
    let noise: NoiseArgument = method.extract()?;
    let kind: MethodArgument = method.extract()?;
    let mut noise = Noise::from(noise);
    if let MethodArgument::Mixture(mixture) = &kind {
        mixture.add_to(&mut noise);
    }
    Ok((noise, kind.try_into()?))
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
