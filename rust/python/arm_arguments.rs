//! What Python gives an arm tracker, read: the arm, its cameras, noise and method.

use crate::arm::cues::CueName;
use crate::arm::ekf::Correction;
use crate::arm::particle::{ArmLayer, Mover};
use crate::arm::process::GaussMarkov;
use crate::arm::setup::Setup;
use crate::arm::state::{JOINTS, View};
use crate::arm::{Arm, Method, Noise};
use crate::camera::Camera;
use crate::error::guarded;
use crate::filter::{Blend, Resampling};
use crate::resample::Scheme;
use crate::{Error, Result};
use nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;

/// `pytracker.Arm`, read.
#[derive(FromPyObject)]
#[allow(clippy::struct_field_names)] // the names are Python's
pub struct ArmArgument {
    shoulder_m: [f64; 3],
    upper_arm_m: f64,
    forearm_m: f64,
    wrist_start_m: [f64; 3],
}

impl From<ArmArgument> for Arm {
    fn from(arm: ArmArgument) -> Self {
        Self {
            shoulder: arm.shoulder_m.into(),
            upper_arm_m: arm.upper_arm_m,
            forearm_m: arm.forearm_m,
            wrist_start: arm.wrist_start_m.into(),
        }
    }
}

/// `pytracker.View`, read.
#[derive(FromPyObject)]
pub struct ViewArgument {
    camera: CameraArgument,
}

impl ViewArgument {
    /// The camera, checked.
    pub fn view(self) -> Result<View> {
        self.camera.try_into()
    }
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
    patch_offset: bool,
    patch_offset_start_sd_m: f64,
    patch_offset_density: f64,
}

/// What a particle method has besides, read.
#[derive(FromPyObject)]
struct ParticlesArgument {
    layers: Vec<(String, Vec<String>, (String, f64))>,
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
    shoulder_motion_sd_m: f64,
    shoulder_density: f64,
    clock_sd_s: f64,
    landmark_sd_m: f64,
    landmark_density: f64,
    upper_arm_turn_sd_rad: f64,
    upper_arm_turn_density: f64,
}

/// What an arm's recording has besides patch and IMU, read.
#[derive(FromPyObject)]
struct SensesArgument {
    landmarks: Vec<String>,
    has_upper_arm: bool,
}

/// What a smoother has besides, read.
#[derive(FromPyObject)]
struct SmootherArgument {
    upper_arm_sd_m: f64,
    forearm_sd_m: f64,
    shoulder_place_sd_m: f64,
    mount_sd_rad: f64,
    camera_turn_sd_rad: f64,
    camera_distance_sd_m: f64,
    focal_sd: f64,
}

impl SmootherArgument {
    fn setup(&self) -> Setup {
        Setup {
            upper_arm_sd_m: self.upper_arm_sd_m,
            forearm_sd_m: self.forearm_sd_m,
            shoulder_place_sd_m: self.shoulder_place_sd_m,
            mount_sd_rad: self.mount_sd_rad,
            camera_turn_sd_rad: self.camera_turn_sd_rad,
            camera_distance_sd_m: self.camera_distance_sd_m,
            focal_sd: self.focal_sd,
            cameras: 0,
        }
    }
}

impl MixtureArgument {
    fn add_to(&self, noise: &mut Noise, worn: &SensesArgument) {
        let unknown = GaussMarkov { start_sd: 0.0, density: 0.0 };
        noise.bias = noise.bias.or(Some(unknown));
        noise.tilt = Some(GaussMarkov { start_sd: self.tilt_start_sd_rad, density: self.tilt_density });
        let shoulder = GaussMarkov { start_sd: self.shoulder_motion_sd_m, density: self.shoulder_density };
        noise.shoulder = self.shoulder.then_some(shoulder);
        noise.clock = Some(GaussMarkov { start_sd: self.clock_sd_s, density: 0.0 });
        let landmark = GaussMarkov { start_sd: self.landmark_sd_m, density: self.landmark_density };
        noise.landmarks = JOINTS.map(|joint| worn.landmarks.iter().any(|name| name == joint).then_some(landmark));
        let turn = GaussMarkov { start_sd: self.upper_arm_turn_sd_rad, density: self.upper_arm_turn_density };
        noise.upper_arm = worn.has_upper_arm.then_some(turn);
        noise.accel_growth = self.accel_growth;
        noise.forearm_sd_rad = self.forearm_sd_rad;
    }
}

/// Which of the filters runs it.
#[derive(FromPyObject)]
struct FilterArgument {
    filter: String,
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
            position_start_sd_m: noise.position_start_sd_m,
            velocity_start_sd: noise.velocity_start_sd,
            walk_density: noise.walk_density,
            pixel_sd: noise.pixel_sd,
            outlier_fraction: noise.outlier_fraction,
            arm_length_sd_m: noise.arm_length_sd_m,
            rest_speed: noise.rest_speed,
            rest_accel: noise.rest_accel,
            rest_turn_rate: noise.rest_turn_rate,
            bias: walk(noise.bias, noise.bias_start_sd, noise.bias_density),
            patch_offset: walk(noise.patch_offset, noise.patch_offset_start_sd_m, noise.patch_offset_density),
            ..Self::default()
        }
    }
}

fn particles(p: &ParticlesArgument) -> Result<Method> {
    let layer = |(mover, cues, (blend, sharpness)): &(String, Vec<String>, (String, f64))| {
        if blend != "sum" {
            return Err(Error::UnknownName { what: "blend", name: blend.clone(), known: "sum" });
        }
        let blend = Blend::Sum { sharpness: *sharpness };
        let cues = cues.iter().map(|cue| CueName::from_name(cue)).collect::<Result<_>>()?;
        Ok(ArmLayer { mover: Mover::from_name(mover)?, cues, blend })
    };
    Ok(Method::Particles {
        layers: p.layers.iter().map(layer).collect::<Result<_>>()?,
        particles: p.particles,
        resampling: Resampling::new(Scheme::from_name(&p.resampling)?, p.ess_threshold)?,
    })
}

/// Raise `InputError` where a `pytracker.Camera` is not one: focal lengths, rotation, finite numbers.
#[pyfunction]
pub fn check_camera(camera: CameraArgument) -> PyResult<()> {
    guarded(|| View::try_from(camera))?;
    Ok(())
}

/// Noise and method of an arm, of a recording that has the senses that it says.
pub fn extract_method(method: &Bound<'_, PyAny>, recording: &Bound<'_, PyAny>) -> PyResult<(Noise, Method)> {
    let noise: NoiseArgument = method.extract()?;
    let FilterArgument { filter } = method.extract()?;
    let mut noise = Noise::from(noise);
    let method = match filter.as_str() {
        "particles" => particles(&method.extract()?)?,
        "gaussian" => {
            let names = method.extract::<GaussianArgument>()?.corrections;
            Method::Gaussian {
                corrections: names.iter().map(|name| Correction::from_name(name)).collect::<Result<_>>()?,
            }
        }
        "mixture" | "smoother" => {
            let m: MixtureArgument = method.extract()?;
            m.add_to(&mut noise, &recording.extract()?);
            let corrections = m.corrections.iter().map(|name| CueName::from_name(name)).collect::<Result<_>>()?;
            let components = m.components;
            if filter == "mixture" {
                Method::Mixture { corrections, components }
            } else {
                let smoother: SmootherArgument = method.extract()?;
                Method::Smoother { corrections, components, setup: Some(smoother.setup()) }
            }
        }
        _ => {
            let known = "particles, gaussian, mixture, smoother";
            return Err(Error::UnknownName { what: "filter", name: filter, known }.into());
        }
    };
    Ok((noise, method))
}
