//! The arm, the noise around it, the columns of the state, and the places that a state puts joints at.

use super::process::GaussMarkov;
use super::setup::Setup;
use crate::camera::Camera;
use crate::estimate::{Estimate, Point};
use crate::filter::Gaussian;
use crate::particles::ParticleSet;
use crate::{Error, Result, error::require};
use nalgebra::{DVector, Vector3};
use serde::{Deserialize, Serialize};

/// Nothing that is measured or assumed of an arm is larger, in any unit; nor farther away, m.
pub(super) const MOST: f64 = 1e6;
const MOST_M: f64 = 1e4;

/// The subject's arm and where it starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Shoulder, world, m; assumed still (paper II-A).
    pub shoulder: Vector3<f64>,
    /// `L1`, shoulder to elbow, m.
    pub upper_arm_m: f64,
    /// `L2`, elbow to wrist, m.
    pub forearm_m: f64,
    /// Wrist at the first frame, world, m.
    pub wrist_start: Vector3<f64>,
}

impl Arm {
    /// Check the lengths.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let range = "a positive length in metres, at most 1";
        require(self.upper_arm_m > 0.0 && self.upper_arm_m <= 1.0, "upper_arm_m", self.upper_arm_m, range)?;
        require(self.forearm_m > 0.0 && self.forearm_m <= 1.0, "forearm_m", self.forearm_m, range)?;
        for value in self.shoulder.iter().chain(&self.wrist_start) {
            require(value.abs() <= MOST_M, "shoulder_m or wrist_start_m", *value, "finite metres, within ±10000")?;
        }
        Ok(())
    }

    /// `P_e^B = (0, L2, 0)`, eq. (1): the sensor's +y points from wrist to elbow.
    pub fn elbow_in_sensor(&self) -> Vector3<f64> {
        Vector3::new(0.0, self.forearm_m, 0.0)
    }
}

/// How uncertain everything is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Process noise of eq. (6) as a density, m/s/√s: a sample over `T` has `sigma_f = accel_density / T^1.5`.
    pub accel_density: f64,
    /// The same beyond `hold_s` after the last IMU sample, when nothing says how the arm accelerates.
    pub gap_density: f64,
    /// How long an IMU sample holds, s.
    pub hold_s: f64,
    /// Initial wrist, m per axis.
    pub position_start_sd_m: f64,
    /// Initial velocity, m/s per axis.
    pub velocity_start_sd: f64,
    /// Random walk of eq. (17), m/√s (the paper's 1 cm at 25 frames/s is 0.05).
    pub walk_density: f64,
    /// Colour patch, px per axis (paper: 4).
    pub pixel_sd: f64,
    /// Share of sightings that are something else, anywhere in the image; 0 is the paper.
    pub outlier_fraction: f64,
    /// Upper-arm length, m (paper: 0.01).
    pub arm_length_sd_m: f64,
    /// Velocity while at rest, m/s per axis.
    pub rest_speed: f64,
    /// Specific force varies by less at rest, m/s² RMS over all axes.
    pub rest_accel: f64,
    /// The sensor turns by less at rest, rad/s RMS over all axes.
    pub rest_turn_rate: f64,
    /// Acceleration bias in the world frame, m/s², where it is estimated.
    pub bias: Option<GaussMarkov>,
    /// Patch offset in the sensor frame, m, beyond the one given, where it is estimated.
    pub patch_offset: Option<GaussMarkov>,
    /// Error of the measured orientation, a small turn in the world frame, rad, where it is estimated (mixture only).
    pub tilt: Option<GaussMarkov>,
    /// Where the shoulder is, beyond the place given, world, m, where it is estimated (mixture only).
    pub shoulder: Option<GaussMarkov>,
    /// How much later the camera sees than the IMU's clock says, s, where it is estimated (mixture only).
    pub clock: Option<GaussMarkov>,
    /// By how much what is seen of shoulder and elbow lies beside them, world, m, of those that are seen (mixture only).
    pub landmarks: [Option<GaussMarkov>; JOINTS.len()],
    /// Error of the upper arm's sensor, a small turn in the world, rad, where there is one (mixture only).
    pub upper_arm: Option<GaussMarkov>,
    /// Lengths and cameras that are not quite known, where they are estimated (smoother only).
    pub setup: Option<Setup>,
    /// How `accel_density` grows with what the wrist accelerates by, per m/s² (mixture only).
    pub accel_growth: f64,
    /// Direction of the forearm beside the sensor's axis: skin and strap, rad (mixture only).
    pub forearm_sd_rad: f64,
}

impl Noise {
    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        let positive = |value: f64| value > 0.0 && value <= MOST;
        let zero_or_more = |value: f64| (0.0..=MOST).contains(&value);
        require(positive(self.accel_density), "accel_density", self.accel_density, "a positive number of m/s/√s")?;
        require(positive(self.gap_density), "gap_density", self.gap_density, "a positive number of m/s/√s")?;
        require(positive(self.hold_s), "hold_s", self.hold_s, "a positive number of seconds")?;
        require(
            zero_or_more(self.position_start_sd_m),
            "position_start_sd_m",
            self.position_start_sd_m,
            "0 m or more",
        )?;
        require(zero_or_more(self.velocity_start_sd), "velocity_start_sd", self.velocity_start_sd, "0 m/s or more")?;
        require(zero_or_more(self.walk_density), "walk_density", self.walk_density, "0 m/√s or more")?;
        require(positive(self.pixel_sd), "pixel_sd", self.pixel_sd, "a positive number of pixels")?;
        require(
            (0.0..1.0).contains(&self.outlier_fraction),
            "outlier_fraction",
            self.outlier_fraction,
            "0 to below 1",
        )?;
        require(
            positive(self.arm_length_sd_m),
            "arm_length_sd_m",
            self.arm_length_sd_m,
            "a positive length in metres",
        )?;
        require(positive(self.rest_speed), "rest_speed", self.rest_speed, "a positive number of m/s")?;
        require(zero_or_more(self.rest_accel), "rest_accel", self.rest_accel, "0 m/s² or more")?;
        require(zero_or_more(self.rest_turn_rate), "rest_turn_rate", self.rest_turn_rate, "0 rad/s or more")?;
        let walks = [&self.bias, &self.patch_offset, &self.tilt, &self.shoulder, &self.clock, &self.upper_arm];
        for walk in walks.into_iter().chain(&self.landmarks).flatten() {
            require(zero_or_more(walk.start_sd), "start_sd of what is estimated", walk.start_sd, "0 or more")?;
            require(zero_or_more(walk.density), "density of what is estimated", walk.density, "0 or more")?;
        }
        require(zero_or_more(self.accel_growth), "accel_growth", self.accel_growth, "0 s²/m or more")?;
        require((0.0..=1.0).contains(&self.forearm_sd_rad), "forearm_sd_rad", self.forearm_sd_rad, "0 to 1 rad")?;
        Ok(())
    }
}

impl Default for Noise {
    /// The paper's values where it gives them, and what `pytracker/methods/arm.py` has; nothing estimated beside.
    fn default() -> Self {
        Self {
            accel_density: 0.1,
            gap_density: 3.0,
            hold_s: 0.05,
            position_start_sd_m: 0.02,
            velocity_start_sd: 0.02,
            walk_density: 0.05,
            pixel_sd: 4.0,
            outlier_fraction: 0.0,
            arm_length_sd_m: 0.01,
            rest_speed: 0.01,
            rest_accel: 0.2,
            rest_turn_rate: 0.1,
            bias: None,
            patch_offset: None,
            tilt: None,
            shoulder: None,
            clock: None,
            landmarks: [None; JOINTS.len()],
            upper_arm: None,
            setup: None,
            accel_growth: 0.0,
            forearm_sd_rad: 0.0,
        }
    }
}

/// A camera and where, in the sensor frame, the patch that it sees sits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Patch centre in the sensor frame, m; zero is the wrist joint itself (paper II-A).
    pub patch_offset: Vector3<f64>,
}

/// Which columns the state has: position 0..3, velocity 3..6, then what is estimated beside them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layout {
    /// First column of the acceleration bias.
    pub bias: Option<usize>,
    /// First column of the patch offset.
    pub patch_offset: Option<usize>,
    /// First column of the orientation's error.
    pub tilt: Option<usize>,
    /// First column of the shoulder's displacement.
    pub shoulder: Option<usize>,
    /// First column of what is seen of shoulder and elbow, beside them.
    pub landmarks: [Option<usize>; JOINTS.len()],
    /// First column of the error of the upper arm's sensor.
    pub upper_arm: Option<usize>,
    /// Column of the clock's error.
    pub clock: Option<usize>,
    /// First column of lengths and cameras.
    pub setup: Option<usize>,
    /// Number of columns.
    pub dim: usize,
}

/// What may be seen besides the patch on the wrist, in the order of [`Noise::landmarks`].
pub const JOINTS: [&str; 2] = ["shoulder", "elbow"];

/// First column of the position.
pub const POSITION: usize = 0;
/// First column of the velocity.
pub const VELOCITY: usize = 3;

impl Layout {
    /// The columns that `noise` asks for.
    pub fn new(noise: &Noise) -> Self {
        let mut dim = 6;
        let mut take = |wanted: bool, width: usize| {
            wanted.then(|| {
                dim += width;
                dim - width
            })
        };
        let bias = take(noise.bias.is_some(), 3);
        let tilt = take(noise.tilt.is_some(), 3);
        let patch_offset = take(noise.patch_offset.is_some(), 3);
        let shoulder = take(noise.shoulder.is_some(), 3);
        let landmarks = noise.landmarks.map(|landmark| take(landmark.is_some(), 3));
        let upper_arm = take(noise.upper_arm.is_some(), 3);
        let clock = take(noise.clock.is_some(), 1);
        let setup = take(noise.setup.is_some(), noise.setup.map_or(0, |setup| setup.width()));
        Self { bias, patch_offset, tilt, shoulder, landmarks, upper_arm, clock, setup, dim }
    }

    /// What is estimated beside the columns that a worn sensor's motion mixes: first column, how many, process.
    pub fn others(self, noise: &Noise) -> Vec<(usize, usize, GaussMarkov)> {
        let others = [(self.patch_offset, 3, noise.patch_offset), (self.shoulder, 3, noise.shoulder)];
        let seen = [0, 1].map(|joint| (self.landmarks[joint], 3, noise.landmarks[joint]));
        let last = [(self.upper_arm, 3, noise.upper_arm), (self.clock, 1, noise.clock)];
        let others =
            others.into_iter().chain(seen).chain(last).filter_map(|(column, width, of)| Some((column?, width, of?)));
        others.chain(self.constants(noise)).collect()
    }

    /// Lengths and cameras: first column, how many, process.
    fn constants(self, noise: &Noise) -> Vec<(usize, usize, GaussMarkov)> {
        let (Some(first), Some(setup)) = (self.setup, &noise.setup) else { return Vec::new() };
        setup.processes().into_iter().map(|(column, width, process)| (first + column, width, process)).collect()
    }

    /// Mean `(D,)` and standard deviation `(D,)` of the state at the first frame.
    pub fn start(self, arm: &Arm, noise: &Noise) -> (DVector<f64>, DVector<f64>) {
        let mut mean = DVector::zeros(self.dim);
        mean.fixed_rows_mut::<3>(POSITION).copy_from(&arm.wrist_start);
        let mut sd = DVector::zeros(self.dim);
        sd.rows_mut(POSITION, 3).fill(noise.position_start_sd_m);
        sd.rows_mut(VELOCITY, 3).fill(noise.velocity_start_sd);
        for (column, walk) in [(self.bias, noise.bias), (self.tilt, noise.tilt)] {
            if let (Some(column), Some(walk)) = (column, walk) {
                sd.rows_mut(column, 3).fill(walk.start_sd);
            }
        }
        for (column, width, walk) in self.others(noise) {
            sd.rows_mut(column, width).fill(walk.start_sd);
        }
        (mean, sd)
    }
}

/// What an arm's estimate has places of, in order: wrist and elbow (eq. 2).
pub const PLACES: [&str; 2] = ["wrist", "elbow"];
/// The wrist among them.
pub(super) const WRIST: usize = 0;

/// The estimate of a particle set; `forearm` is wrist to elbow in the world, m.
pub(super) fn estimate_of_particles(
    time_s: f64,
    particles: &ParticleSet,
    forearm: Vector3<f64>,
    log_evidence: Option<f64>,
) -> Estimate {
    let state = particles.summary(3);
    let wrist = Point::of_columns(&state, POSITION);
    let places = vec![wrist.clone(), wrist.moved(forearm)];
    Estimate { time_s, state, places, ess: Some(particles.ess()), log_evidence, doubt: None, blobs: [None; 3] }
}

/// The estimate of a Gaussian.
pub(super) fn estimate_of_gaussian(
    time_s: f64,
    state: &Gaussian,
    forearm: Vector3<f64>,
    log_evidence: Option<f64>,
) -> Estimate {
    let wrist = Point::of_gaussian(state);
    let state = wrist.with_state(state.mean.clone(), state.covariance.clone());
    let places = vec![wrist.clone(), wrist.moved(forearm)];
    Estimate { time_s, state, places, ess: None, log_evidence, doubt: None, blobs: [None; 3] }
}

/// Check a pixel or an acceleration: a number, and none that no sensor gives.
pub(super) fn require_finite(name: &'static str, time_s: f64, values: &[f64]) -> Result<()> {
    match values.iter().find(|x| x.is_nan() || x.abs() > MOST) {
        Some(value) => Err(Error::NotFinite { name, time_s, value: *value }),
        None => Ok(()),
    }
}
