//! What Python gives a body tracker, read: the outer shape, the camera, the method.

use crate::body::cues::keypoints::KeypointLook;
use crate::body::{Blending, BodyLayer, BodyMethod, CueName, Diffusion, Group, Part, Unseen};
use crate::camera::Camera;
use crate::filter::Resampling;
use crate::projection::Projection;
use crate::resample::Scheme;
use crate::{Error, Result};
use pyo3::prelude::*;

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

/// What every body method has, read.
#[derive(FromPyObject)]
struct MethodArgument {
    particles: usize,
    islands: usize,
    layers: Vec<(Vec<String>, f64, f64)>,
    resampling: String,
    ess_threshold: f64,
    base_density: f64,
    base_turn_density: f64,
    trunk_density: f64,
    joint_density: f64,
    cues: Vec<String>,
    blend: String,
    blob_sd_m: f64,
    blob_reach: f64,
    gate_m: f64,
    anew_share: f64,
    unseen_distance_sd_m: f64,
    unseen_lean_sd_rad: f64,
    unseen_turn_sd_rad: f64,
    skin_loss: f64,
    foreground_loss: f64,
    region_reach_m: f64,
    keypoint_inflation: f64,
    keypoint_reach: f64,
    orientation_inflation: f64,
    effort_loss: f64,
    edge_loss: f64,
}

/// What the paper's blend has besides.
#[derive(FromPyObject)]
struct RescaledArgument {
    sharpness: f64,
    alpha: f64,
    adapt: f64,
}

pub fn extract_projection(camera: &Bound<'_, PyAny>) -> PyResult<Projection> {
    Ok(match camera.extract()? {
        ProjectionArgument::Weak(weak) => Projection::weak(weak.affine)?,
        ProjectionArgument::Pinhole(camera) => Projection::Pinhole(Box::new(Camera::try_from(camera)?)),
    })
}

pub fn extract_method(method: &Bound<'_, PyAny>) -> PyResult<BodyMethod> {
    let m: MethodArgument = method.extract()?;
    let blending = match m.blend.as_str() {
        "sum" => Blending::Sum,
        "rescaled" => {
            let RescaledArgument { sharpness, alpha, adapt } = method.extract()?;
            Blending::Rescaled { base: sharpness, alpha, adapt }
        }
        _ => return Err(Error::UnknownName { what: "blend", name: m.blend, known: "sum, rescaled" }.into()),
    };
    let layer = |(groups, spread, sharpness): (Vec<String>, f64, f64)| {
        let groups = groups.iter().map(|group| Group::from_name(group)).collect::<Result<_>>()?;
        Ok(BodyLayer { groups, spread, sharpness })
    };
    let method = BodyMethod {
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
        cues: m.cues.iter().map(|name| CueName::from_name(name)).collect::<Result<_>>()?,
        blending,
        edge_loss: m.edge_loss,
        blob_sd_m: m.blob_sd_m,
        blob_reach: m.blob_reach,
        gate_m: m.gate_m,
        skin_loss: m.skin_loss,
        foreground_loss: m.foreground_loss,
        region_reach_m: m.region_reach_m,
        keypoints: KeypointLook { inflation: m.keypoint_inflation, reach: m.keypoint_reach },
        orientation_inflation: m.orientation_inflation,
        effort_loss: m.effort_loss,
        unseen: Unseen { distance_m: m.unseen_distance_sd_m, lean: m.unseen_lean_sd_rad, turn: m.unseen_turn_sd_rad },
    };
    method.check()?;
    Ok(method)
}
