//! Whatever is done to an arm's tracker, in whatever order and with whatever numbers: an estimate that is one, or an error.
//!
//! Guided by coverage (libFuzzer): `make fuzz-core`. The bytes are a method, then operations with their numbers.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nalgebra::{Matrix3, UnitQuaternion, Vector2, Vector3};
use pytracker::arm::cues::CueName;
use pytracker::arm::ekf::Correction;
use pytracker::arm::cues::landmark::{Landmark, SeenJoint};
use pytracker::arm::particle::{ArmLayer, Mover};
use pytracker::arm::setup::Setup;
use pytracker::arm::process::GaussMarkov;
use pytracker::arm::state::View;
use pytracker::arm::{Arm, ArmFilter, Method, Noise};
use pytracker::body::cues::orientation::{Orientation, Segment};
use pytracker::body::joints::{Group};
use pytracker::camera::Camera;
use pytracker::filter::{Blend, Resampling};
use pytracker::quaternion::Quaternion;
use pytracker::resample::Scheme;
use pytracker::{Estimate, Observation, Point, Sample, Smoothing, Tracker};

/// Numbers out of bytes: mostly such as sensors give, now and then such as they never do.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn number(&mut self, scale: f64) -> f64 {
        match self.byte() {
            255 => f64::NAN,
            254 => f64::INFINITY,
            253 => 1e308,
            252 => -1e-308,
            251 => 1e12,
            250 => 0.0,
            high => scale * (f64::from(high) + f64::from(self.byte()) / 256.0 - 125.0) / 125.0,
        }
    }

    fn vector(&mut self, scale: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.number(scale))
    }
}

fn arm() -> Arm {
    let shoulder = Vector3::new(0.1, 0.0, 0.25);
    Arm { shoulder, upper_arm_m: 0.30, forearm_m: 0.25, wrist_start: Vector3::new(0.2, 0.3, 0.0) }
}

fn view() -> View {
    let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
    let rotation = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, -1.0, 0.0);
    let camera = Camera::new(matrix, [0.0; 5], rotation, Vector3::new(0.0, 0.0, 2.3)).unwrap();
    View { camera, patch_offset: Vector3::zeros() }
}

fn worn() -> Noise {
    let walk = |start_sd, density| Some(GaussMarkov { start_sd, density });
    Noise {
        bias: walk(0.1, 0.03),
        tilt: walk(0.02, 0.003),
        patch_offset: walk(0.01, 0.0),
        shoulder: walk(0.03, 0.04),
        clock: walk(0.05, 0.0),
        landmarks: [walk(0.03, 0.005), None],
        upper_arm: walk(0.07, 0.08),
        accel_growth: 0.3,
        forearm_sd_rad: 0.08,
        ..Noise::default()
    }
}

fn method(which: u8) -> (Noise, Method) {
    let particles = |layers| {
        let resampling = Resampling::new(Scheme::Residual, 1.0).unwrap();
        (Noise::default(), Method::Particles { layers, particles: 30, resampling })
    };
    let layer = |mover, cues: &[CueName]| ArmLayer { mover, cues: cues.to_vec(), blend: Blend::PRODUCT };
    let corrections = vec![CueName::ArmLength, CueName::Rest];
    let setup = Setup {
        upper_arm_sd_m: 0.01,
        forearm_sd_m: 0.01,
        shoulder_place_sd_m: 0.02,
        mount_sd_rad: 0.03,
        camera_turn_sd_rad: 0.01,
        camera_distance_sd_m: 0.1,
        focal_sd: 0.01,
        cameras: 0,
    };
    match which % 5 {
        0 => particles(vec![layer(Mover::Inertial, &[CueName::Colour, CueName::ArmLength])]),
        1 => particles(vec![layer(Mover::Inertial, &[CueName::Colour]), layer(Mover::Walk, &[CueName::ArmLength])]),
        2 => (Noise::default(), Method::Gaussian { corrections: vec![Correction::Cue(CueName::Colour), Correction::Cue(CueName::ArmLength)] }),
        3 => (worn(), Method::Mixture { corrections, components: 4 }),
        _ => (worn(), Method::Smoother { corrections, components: 3, setup: Some(setup) }),
    }
}

fn is_one(estimate: &Estimate) {
    for Point { mean, sd, lo, hi, .. } in &estimate.places {
        for d in 0..3 {
            assert!(mean[d].is_finite() && sd[d] >= 0.0 && lo[d] <= hi[d], "{estimate:?}");
        }
    }
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let (noise, method) = method(bytes.byte());
    let delay_s = bytes.number(0.1).clamp(0.0, 0.1);
    let tracker = Tracker::from(ArmFilter::new(arm(), vec![view()], noise, method, 7).unwrap());
    let mut tracker = tracker.with_delay(if delay_s > 0.05 { delay_s } else { 0.0 }).unwrap();
    let mut time_s = 0.0;
    let mut frames = 0;
    while !bytes.0.is_empty() && frames < 40 {
        match bytes.byte() % 10 {
            0..=2 => {
                time_s += bytes.number(0.02).abs();
                let acceleration = bytes.vector(20.0) + Vector3::new(0.0, 0.0, 9.8);
                let world_sensor = Quaternion::from_rotation_vector(bytes.vector(3.0));
                let turn_rate = (bytes.byte() % 2 == 0).then(|| bytes.vector(5.0));
                let sample = Sample { time_s, acceleration, world_sensor, turn_rate };
                let _ = tracker.observe(Observation::inertial(sample));
            }
            3..=5 => {
                frames += 1;
                time_s += bytes.number(0.05).abs();
                let pixel = (bytes.byte() % 4 != 0)
                    .then(|| Vector2::new(320.0 + bytes.number(400.0), 240.0 + bytes.number(300.0)));
                let found = tracker.observe(Observation::patch(time_s, vec![pixel]));
                found.iter().flatten().for_each(is_one);
            }
            8 => {
                let joint = if bytes.byte() % 2 == 0 { SeenJoint::Shoulder } else { SeenJoint::Elbow };
                let pixel = Vector2::new(320.0 + bytes.number(400.0), 240.0 + bytes.number(300.0));
                let (camera, sd) = (usize::from(bytes.byte() == 0), bytes.number(10.0));
                let _ = tracker.observe(Observation::landmark(time_s, Landmark { joint, camera, pixel, sd }));
            }
            9 => {
                let q_world_segment = UnitQuaternion::from_scaled_axis(bytes.vector(3.0));
                let segment = Segment::UpperArm(Group::RightArm);
                let (sd, roll_sd) = (bytes.number(0.2), f64::INFINITY);
                let turned = Orientation { segment, q_world_segment, sd, roll_sd };
                let _ = tracker.observe(Observation::orientation(time_s + bytes.number(0.01), turned));
            }
            6 => {
                if let Ok(estimate) = tracker.estimate(time_s + bytes.number(0.1)) {
                    is_one(&estimate);
                }
            }
            _ => {
                let Ok(mut saved) = tracker.save() else { continue };
                assert_eq!(Tracker::restore(&saved).as_ref(), Ok(&tracker));
                let at = usize::from(bytes.byte()) * 7 % saved.len();
                saved[at] ^= 1 << (bytes.byte() % 8);
                assert!(Tracker::restore(&saved).is_err());
            }
        }
    }
    tracker.finish().iter().flatten().for_each(is_one);
    for estimate in tracker.smoothed(&mut Smoothing::default()).unwrap_or_default() {
        is_one(&estimate);
    }
});
