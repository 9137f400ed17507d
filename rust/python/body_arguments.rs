//! What Python gives a body tracker, read: the outer shape, the camera, the method.

use crate::body::cues::CueParameters;
use crate::body::{
    Blend, BodyLayer, BodyMethod, CueName, Diffusion, FilterMethod, Group, MixtureMethod, Momentum, Mover, Part,
    ParticleMethod, Unseen,
};
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
    filter: String,
    unseen_distance_sd_m: f64,
    first_distance_sd_m: f64,
    unseen_lean_sd_rad: f64,
    unseen_turn_sd_rad: f64,
    unseen_bend: f64,
    balance: f64,
}

/// What a particle method has besides.
#[derive(FromPyObject)]
struct ParticlesArgument {
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
    unseen_across_sd_m: f64,
}

/// What a mixture has besides.
#[derive(FromPyObject)]
struct MixtureArgument {
    corrections: Vec<String>,
    components: usize,
}

/// What a method has besides whose channels have velocities.
#[derive(FromPyObject)]
struct MomentumArgument {
    base_accel_density: f64,
    turn_accel_density: f64,
    joint_accel_density: f64,
    velocity_lasts_s: f64,
    first_pose_sd_m: f64,
    first_pose_sd_rad: f64,
}

impl From<MomentumArgument> for Momentum {
    fn from(m: MomentumArgument) -> Self {
        Self {
            base: m.base_accel_density,
            turn: m.turn_accel_density,
            joint: m.joint_accel_density,
            lasts_s: m.velocity_lasts_s,
            first_m: m.first_pose_sd_m,
            first_rad: m.first_pose_sd_rad,
        }
    }
}

impl ParticlesArgument {
    fn layers(&self) -> Result<Vec<BodyLayer>> {
        let Self { sharpness: base, alpha, adapt, .. } = *self;
        let layer = |((groups, spread), cues, (blend, sharpness)): &LayerArgument| {
            let groups = groups.iter().map(|group| Group::from_name(group)).collect::<Result<_>>()?;
            let blend = match blend.as_str() {
                "sum" => Blend::Sum { sharpness: *sharpness },
                "rescaled" => Blend::rescaled(base, alpha, adapt, *sharpness),
                _ => return Err(Error::UnknownName { what: "blend", name: blend.clone(), known: "sum, rescaled" }),
            };
            Ok(BodyLayer { mover: Mover { groups, spread: *spread }, cues: named(cues)?, blend })
        };
        self.layers.iter().map(layer).collect()
    }

    fn method(&self, smoothing: Option<Momentum>) -> Result<ParticleMethod> {
        Ok(ParticleMethod {
            particles: self.particles,
            islands: self.islands,
            resampling: Resampling::new(Scheme::from_name(&self.resampling)?, self.ess_threshold)?,
            diffusion: Diffusion {
                base: self.base_density,
                base_turn: self.base_turn_density,
                trunk: self.trunk_density,
                joint: self.joint_density,
            },
            anew_share: self.anew_share,
            smoothing,
        })
    }
}

/// Cues by name.
fn named(cues: &[String]) -> Result<Vec<CueName>> {
    cues.iter().map(|name| CueName::from_name(name)).collect()
}

pub fn extract_projection(camera: &Bound<'_, PyAny>) -> PyResult<Projection> {
    Ok(match camera.extract()? {
        ProjectionArgument::Weak(weak) => Projection::weak(weak.affine)?,
        ProjectionArgument::Pinhole(camera) => Projection::Pinhole(Box::new(Camera::try_from(camera)?)),
    })
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
    let numbers = numbers(method)?;
    let momentum = || Ok::<_, PyErr>(Momentum::from(method.extract::<MomentumArgument>()?));
    let (filter, layers, cue_parameters, across_m) = match m.filter.as_str() {
        "particles" | "smoother" => {
            let p: ParticlesArgument = method.extract()?;
            let smoothing = if m.filter == "smoother" { Some(momentum()?) } else { None };
            let filter = FilterMethod::Particles(p.method(smoothing)?);
            (filter, p.layers()?, CueParameters::read(&numbers)?, p.unseen_across_sd_m)
        }
        "mixture" => {
            let MixtureArgument { corrections, components } = method.extract()?;
            let filter = FilterMethod::Mixture(MixtureMethod { components, momentum: momentum()? });
            let cues = corrections.iter().map(|name| CueName::smooth_from_name(name)).collect::<Result<_>>()?;
            (filter, vec![BodyLayer::whole(cues)], CueParameters::of_smooth(&numbers)?, 0.0)
        }
        _ => {
            let known = "particles, mixture, smoother";
            return Err(Error::UnknownName { what: "filter", name: m.filter, known }.into());
        }
    };
    let unseen = Unseen {
        distance_m: m.unseen_distance_sd_m,
        first_distance_m: m.first_distance_sd_m,
        lean: m.unseen_lean_sd_rad,
        turn: m.unseen_turn_sd_rad,
        across_m,
        bend: m.unseen_bend,
    };
    let found = BodyMethod { filter, layers, cue_parameters, balance: m.balance, unseen };
    found.check()?;
    Ok(found)
}
