//! The arm tracker from outside, on a wrist at rest.

use nalgebra::{DVector, Matrix3, Vector2, Vector3};
use pytracker::Error;
use pytracker::arm::ekf::Correction;
use pytracker::arm::motion::{InertialMotion, Motion, RandomWalk};
use pytracker::arm::particle::{ArmLayer, Cue, Mover};
use pytracker::arm::state::{GaussMarkov, Layout, View};
use pytracker::arm::{Arm, ArmTracker, Estimate, Method, Noise, Sample};
use pytracker::camera::Camera;
use pytracker::filter::{History, Resampling, Transition};
use pytracker::particles::ParticleSet;
use pytracker::quaternion::Quaternion;
use pytracker::resample::Scheme;
use pytracker::rng::Streams;

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

fn layer(mover: Mover, cues: &[Cue]) -> ArmLayer {
    ArmLayer { mover, cues: cues.to_vec() }
}

fn particles(layers: Vec<ArmLayer>, len: usize) -> Method {
    Method::Particles { layers, len, resampling: Resampling::new(Scheme::Residual, 1.0).unwrap() }
}

fn joint(len: usize) -> Method {
    particles(vec![layer(Mover::Inertial, &[Cue::Colour, Cue::ArmLength])], len)
}

fn layered(len: usize) -> Method {
    particles(vec![layer(Mover::Inertial, &[Cue::Colour]), layer(Mover::Walk, &[Cue::ArmLength])], len)
}

fn tracker(noise: Noise, method: Method) -> ArmTracker {
    ArmTracker::new(arm(), vec![view()], noise, method, 7).unwrap()
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

fn all(tracker: &mut ArmTracker) -> Vec<Estimate> {
    let (samples, frames) = recording();
    let stretch = tracker.run(&samples, &frames, 0);
    assert_eq!(stretch.stopped, None);
    stretch.estimates
}
