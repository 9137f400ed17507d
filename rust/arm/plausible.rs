//! Whether an estimate is one that an arm can have and that the picture bears out: what makes a frame not to be believed.
//!
//! Not in the paper. A filter whose heading, tilt or clock is wrong is sure and wrong, and its cloud may collapse far from
//! the arm without one weight being zero. Three things tell: the wrist lies beyond the arm's reach and its own band, the
//! cloud is narrower than the pixels allow or stands on one particle, and the patch is seen where the estimate is not.

use super::posed::Sighting;
use super::state::{Arm, Layout, Noise, POSITION, WRIST};
use crate::estimate::Estimate;
use crate::particles::NORMAL_UPPER;
use crate::quaternion::Quaternion;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// What is said of an estimate: beyond the arm's reach, collapsed, beside the patch.
pub const DOUBTS: [&str; 3] = [
    "the wrist is beyond the arm's reach and its own band",
    "the cloud of particles has collapsed",
    "the estimate lies beside the patch that is seen",
];

/// After a pause, until the patch is seen again.
pub const UNKNOWN: &str = "neither IMU nor patch has said where the arm is since a pause";

/// A shoulder that is taken to be still moves by as much, and lengths are measured that badly, m.
const SLACK_M: f64 = 0.10;
/// Standard deviations of a 95 % band.
const BAND: f64 = NORMAL_UPPER;
/// A cloud whose effective size is below this stands on one particle.
const LEAST_ESS: f64 = 1.5;
/// A cloud this much narrower than one sighting tells has collapsed: no filter of independent sightings gets so sure.
const LEAST_SPREAD: f64 = 0.01;
/// So many frames on end, before a small or narrow cloud is called collapsed.
const FRAMES: u32 = 5;
/// Memory of the mean squared distance between patch and estimate, s.
const MEMORY_S: f64 = 0.5;
/// That distance is normalised: 1 is right, this is not.
const ASIDE: f64 = 9.0;
/// One sighting adds no more than this: it may be something else.
const MOST_ASIDE: f64 = 40.0;
/// An estimate that is implausible for so long is of no use any more, s.
pub const PATIENCE_S: f64 = 1.0;

/// What has been seen of it so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plausibility {
    narrow_frames: u32,
    aside: f64,
    beyond_since_s: Option<f64>,
    last_s: Option<f64>,
}

/// What a frame is judged by, besides its estimate.
pub struct Judged<'a> {
    /// The arm.
    pub arm: &'a Arm,
    /// What noise is assumed.
    pub noise: &'a Noise,
    /// Where the patch was seen.
    pub sightings: &'a [Sighting<'a>],
    /// Orientation of the sensor.
    pub world_sensor: Quaternion,
}

impl Plausibility {
    /// Nothing speaks against it yet.
    pub fn new() -> Self {
        Self { narrow_frames: 0, aside: 1.0, beyond_since_s: None, last_s: None }
    }

    /// What speaks against `estimate`, if anything does.
    pub fn doubt(&mut self, estimate: &Estimate, judged: &Judged<'_>) -> Option<&'static str> {
        let elapsed_s = self.last_s.map_or(0.0, |last| estimate.time_s - last);
        self.last_s = Some(estimate.time_s);
        let is_narrow = is_narrow(estimate, judged);
        self.narrow_frames = if is_narrow { self.narrow_frames.saturating_add(1) } else { 0 };
        if let Some(aside) = aside(estimate, judged) {
            let keep = (-elapsed_s / MEMORY_S).exp();
            self.aside = keep * self.aside + (1.0 - keep) * aside.min(MOST_ASIDE);
        }
        let is_beyond = is_beyond_reach(estimate, judged.arm);
        self.beyond_since_s = if is_beyond { self.beyond_since_s.or(Some(estimate.time_s)) } else { None };
        if is_beyond {
            Some(DOUBTS[0])
        } else if self.narrow_frames >= FRAMES {
            Some(DOUBTS[1])
        } else if self.aside > ASIDE {
            Some(DOUBTS[2])
        } else {
            None
        }
    }

    /// For how long the wrist has been where no arm reaches, s.
    pub fn beyond_s(&self) -> f64 {
        self.beyond_since_s.zip(self.last_s).map_or(0.0, |(since, last)| last - since)
    }
}

impl Default for Plausibility {
    fn default() -> Self {
        Self::new()
    }
}

/// Farther from the shoulder than both bones are long, by more than the band along that line and what a shoulder moves.
fn is_beyond_reach(estimate: &Estimate, arm: &Arm) -> bool {
    let from_shoulder = estimate.places[WRIST].mean - arm.shoulder;
    let distance = from_shoulder.norm();
    let along = from_shoulder / distance.max(f64::MIN_POSITIVE);
    let sd = along.dot(&(covariance(estimate) * along)).max(0.0).sqrt();
    distance - BAND * sd > arm.upper_arm_m + arm.forearm_m + SLACK_M
}

fn is_narrow(estimate: &Estimate, judged: &Judged<'_>) -> bool {
    let Some(ess) = estimate.ess else { return false };
    let finest = judged.sightings.iter().map(|sighting| {
        let camera = &sighting.view.camera;
        judged.noise.pixel_sd * camera.depth(estimate.places[WRIST].mean).abs() / camera.matrix()[(0, 0)]
    });
    ess < LEAST_ESS || estimate.places[WRIST].sd.max() < LEAST_SPREAD * finest.fold(f64::INFINITY, f64::min).min(1.0)
}

/// Squared distance of the patches from where the estimate puts them, over what noise and its own spread allow; 1 is
/// expected. None where nothing was seen.
fn aside(estimate: &Estimate, judged: &Judged<'_>) -> Option<f64> {
    let world_sensor = judged.world_sensor.to_matrix();
    let mut sum = 0.0;
    for sighting in judged.sightings {
        let mut offset = sighting.view.patch_offset;
        if let Some(column) = Layout::new(judged.noise).patch_offset {
            offset += estimate.state.mean.fixed_rows::<3>(column);
        }
        let patch: Vector3<f64> = estimate.state.mean.fixed_rows::<3>(POSITION) + world_sensor * offset;
        // A patch that is seen lies before its camera.
        let Some((pixel, slope)) = sighting.view.camera.project_with_jacobian(patch) else { return Some(MOST_ASIDE) };
        let spread = slope * covariance(estimate) * slope.transpose();
        let variance = judged.noise.pixel_sd * judged.noise.pixel_sd;
        let residual = sighting.pixel - pixel;
        sum += 0.5 * (0..2).map(|d| residual[d] * residual[d] / (variance + spread[(d, d)].max(0.0))).sum::<f64>();
    }
    (!judged.sightings.is_empty()).then(|| sum / judged.sightings.len() as f64)
}

fn covariance(estimate: &Estimate) -> Matrix3<f64> {
    estimate.state.covariance.fixed_view::<3, 3>(POSITION, POSITION).into_owned()
}
