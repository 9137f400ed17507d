//! The arm tracker from outside, on a wrist at rest.

use nalgebra::{DVector, Matrix3, Vector2, Vector3};
use pytracker::arm::cues::CueName;
use pytracker::arm::cues::landmark::{Landmark, SeenJoint};
use pytracker::arm::ekf::Correction;
use pytracker::arm::motion::{InertialMotion, Motion, RandomWalk};
use pytracker::arm::particle::{ArmLayer, Mover};
use pytracker::arm::process::GaussMarkov;
use pytracker::arm::state::{Layout, View};
use pytracker::arm::{Arm, ArmFilter, Method, Noise};
use pytracker::camera::Camera;
use pytracker::filter::{Blend, History, Resampling, Transition};
use pytracker::particles::ParticleSet;
use pytracker::quaternion::Quaternion;
use pytracker::resample::Scheme;
use pytracker::rng::Streams;
use pytracker::{Error, Estimate, Observation, Result, Sample, Tracker};

mod faults;
mod motion;
mod tracker;

fn arm() -> Arm {
    let shoulder = Vector3::new(0.1, 0.0, 0.25);
    Arm { shoulder, upper_arm_m: 0.30, forearm_m: 0.25, wrist_start: Vector3::new(0.2, 0.3, 0.0) }
}

fn noise() -> Noise {
    Noise { gap_density: 1.0, hold_s: 0.1, ..Noise::default() }
}

fn with_bias() -> Noise {
    Noise { bias: Some(GaussMarkov { start_sd: 0.1, density: 0.01 }), ..noise() }
}

/// Two metres off along +y, looking back along -y.
fn view() -> View {
    let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
    let rotation = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, -1.0, 0.0);
    let camera = Camera::new(matrix, [0.0; 5], rotation, Vector3::new(0.0, 0.0, 2.3)).unwrap();
    View { camera, patch_offset: Vector3::zeros() }
}

fn layer(mover: Mover, cues: &[CueName]) -> ArmLayer {
    ArmLayer { mover, cues: cues.to_vec(), blend: Blend::PRODUCT }
}

fn particles(layers: Vec<ArmLayer>, particles: usize) -> Method {
    Method::Particles { layers, particles, resampling: Resampling::new(Scheme::Residual, 1.0).unwrap() }
}

fn joint(len: usize) -> Method {
    particles(vec![layer(Mover::Inertial, &[CueName::Colour, CueName::ArmLength])], len)
}

fn layered(len: usize) -> Method {
    particles(vec![layer(Mover::Inertial, &[CueName::Colour]), layer(Mover::Walk, &[CueName::ArmLength])], len)
}

fn tracker(noise: Noise, method: Method) -> Tracker {
    made(arm(), vec![view()], noise, method).unwrap()
}

fn made(arm: Arm, views: Vec<View>, noise: Noise, method: Method) -> Result<Tracker> {
    ArmFilter::new(arm, views, noise, method, 7).map(Tracker::from)
}

/// What a tracker does at a sample and at a frame.
trait Take {
    fn predict(&mut self, sample: &Sample) -> Result<()>;
    fn update(&mut self, time_s: f64, pixels: &[Option<Vector2<f64>>]) -> Result<Estimate>;
}

impl Take for Tracker {
    fn predict(&mut self, sample: &Sample) -> Result<()> {
        self.observe(Observation::inertial(*sample)).map(|found| assert!(found.is_none()))
    }

    fn update(&mut self, time_s: f64, pixels: &[Option<Vector2<f64>>]) -> Result<Estimate> {
        self.observe(Observation::patch(time_s, pixels.to_vec())).map(|found| found.expect("an estimate of a frame"))
    }
}

/// Samples and frames in order of time; a sample at a frame's own time comes before it.
fn in_order(samples: &[Sample], frames: &[Pixels]) -> Vec<Observation> {
    let samples = samples.iter().enumerate().map(|(k, sample)| Observation::inertial(*sample).numbered(k));
    let frames = frames.iter().enumerate().map(|(k, (at, pixels))| Observation::patch(*at, pixels.clone()).numbered(k));
    let mut all: Vec<Observation> = samples.chain(frames).collect();
    all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    all
}

/// Time and one pixel a camera.
type Pixels = (f64, Vec<Option<Vector2<f64>>>);

/// A second of a wrist at rest, elbow above it, read at 100 Hz, with a frame every 40 ms.
fn recording() -> (Vec<Sample>, Vec<Pixels>) {
    let world_sensor = Quaternion::from_rotation_vector(Vector3::new(0.9, 0.1, 0.3));
    let gravity = world_sensor.conjugate().rotate(Vector3::new(0.0, 0.0, 9.806_65));
    let samples = (0..100)
        .map(|k| Sample {
            time_s: f64::from(k) / 100.0,
            acceleration: gravity + Vector3::new(0.05 * f64::from(k % 7 - 3), 0.02, -0.03),
            world_sensor,
            turn_rate: Some(Vector3::new(0.0, 0.01, 0.0)),
        })
        .collect();
    let pixel = view().camera.project(arm().wrist_start).unwrap();
    let frames = (0..24)
        .map(|k| {
            let seen = (k % 9 != 4).then(|| pixel + Vector2::new(f64::from(k % 3) - 1.0, f64::from(k % 5) - 2.0));
            (0.003 + 0.04 * f64::from(k), vec![seen])
        })
        .collect();
    (samples, frames)
}

fn all(tracker: &mut Tracker) -> Vec<Estimate> {
    let (samples, frames) = recording();
    let stretch = tracker.run(in_order(&samples, &frames));
    assert_eq!(stretch.stopped, None);
    stretch.estimates
}
