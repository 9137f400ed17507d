//! What Python gives a body tracker, read: the outer shape, the camera, the method.

use crate::body::cues::CueParameters;
use crate::body::{Blend, BodyLayer, BodyMethod, CueName, Diffusion, Group, Momentum, Mover, Part, Unseen};
use crate::camera::Camera;
use crate::filter::Resampling;
use crate::parameters::Parameters;
use crate::projection::Projection;
use crate::resample::Scheme;
use crate::{Error, Result};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// `pytracker.Part`, read.
#[derive(FromPyObject)]
pub struct PartArgument {
    start: (String, f64),
    end: (String, f64),
    half_width_m: [f64; 2],
}

impl From<PartArgument> for Part {
    fn from(part: PartArgument) -> Self {
        Self { start: part.start, end: part.end, half_width_m: part.half_width_m }
    }
}

/// A camera of the body: a weak-perspective matrix or a pinhole.
#[derive(FromPyObject)]
enum ProjectionArgument {
    #[pyo3(transparent)]
    Weak(WeakArgument),
    #[pyo3(transparent)]
    Pinhole(super::arm_arguments::CameraArgument),
}

#[derive(FromPyObject)]
struct WeakArgument {
    affine: [[f64; 4]; 2],
}

/// Mover (groups, share of the diffusion), cues, blend (name, share of the sharpness).
type LayerArgument = ((Vec<String>, f64), Vec<String>, (String, f64));

/// What every body method has, read.
#[derive(FromPyObject)]
struct MethodArgument {
    particles: usize,
    islands: usize,
    layers: Vec<LayerArgument>,
    resampling: String,
    ess_threshold: f64,
    base_density: f64,
    base_turn_density: f64,
    trunk_density: f64,
    joint_density: f64,
    sharpness: f64,
    alpha: f64,
    adapt: f64,
    anew_share: f64,
    unseen_distance_sd_m: f64,
    first_distance_sd_m: f64,
    unseen_lean_sd_rad: f64,
    unseen_turn_sd_rad: f64,
    balance: f64,
}

/// What a method that smooths has besides.
#[derive(FromPyObject)]
struct SmoothingArgument {
    base_accel_density: f64,
    turn_accel_density: f64,
    joint_accel_density: f64,
    velocity_lasts_s: f64,
    first_pose_sd_m: f64,
    first_pose_sd_rad: f64,
}

pub fn extract_projection(camera: &Bound<'_, PyAny>) -> PyResult<Projection> {
    Ok(match camera.extract()? {
        ProjectionArgument::Weak(weak) => Projection::weak(weak.affine)?,
        ProjectionArgument::Pinhole(camera) => Projection::Pinhole(Box::new(Camera::try_from(camera)?)),
    })
}

fn extract_smoothing(method: &Bound<'_, PyAny>) -> PyResult<Option<Momentum>> {
    if !method.getattr("is_smoothed")?.extract::<bool>()? {
        return Ok(None);
    }
    let m: SmoothingArgument = method.extract()?;
    Ok(Some(Momentum {
        base: m.base_accel_density,
        turn: m.turn_accel_density,
        joint: m.joint_accel_density,
        lasts_s: m.velocity_lasts_s,
        first_m: m.first_pose_sd_m,
        first_rad: m.first_pose_sd_rad,
    }))
}

/// Every parameter that is a number.
fn numbers(method: &Bound<'_, PyAny>) -> PyResult<Parameters> {
    let named: Bound<'_, PyDict> = method.call_method0("parameters")?.cast_into()?;
    let number = |(name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        Some((name.extract::<String>().ok()?, value.extract::<f64>().ok()?))
    };
    Ok(named.iter().filter_map(number).collect())
}

pub fn extract_method(method: &Bound<'_, PyAny>) -> PyResult<BodyMethod> {
    let m: MethodArgument = method.extract()?;
    let MethodArgument { sharpness: base, alpha, adapt, .. } = m;
    let layer = |((groups, spread), cues, (blend, sharpness)): LayerArgument| {
        let groups = groups.iter().map(|group| Group::from_name(group)).collect::<Result<_>>()?;
        let cues = cues.iter().map(|name| CueName::from_name(name)).collect::<Result<_>>()?;
        let blend = match blend.as_str() {
            "sum" => Blend::Sum { sharpness },
            "rescaled" => Blend::rescaled(base, alpha, adapt, sharpness),
            _ => return Err(Error::UnknownName { what: "blend", name: blend, known: "sum, rescaled" }),
        };
        Ok(BodyLayer { mover: Mover { groups, spread }, cues, blend })
    };
    let found = BodyMethod {
        particles: m.particles,
        islands: m.islands,
        layers: m.layers.into_iter().map(layer).collect::<Result<_>>()?,
        resampling: Resampling::new(Scheme::from_name(&m.resampling)?, m.ess_threshold)?,
        diffusion: Diffusion {
            base: m.base_density,
            base_turn: m.base_turn_density,
            trunk: m.trunk_density,
            joint: m.joint_density,
        },
        anew_share: m.anew_share,
        cue_parameters: CueParameters::read(&numbers(method)?)?,
        balance: m.balance,
        smoothing: extract_smoothing(method)?,
        unseen: Unseen {
            distance_m: m.unseen_distance_sd_m,
            first_distance_m: m.first_distance_sd_m,
            lean: m.unseen_lean_sd_rad,
            turn: m.unseen_turn_sd_rad,
        },
    };
    found.check()?;
    Ok(found)
}
