//! One camera frame of the arm: four IMU samples composed, then the layers; and a smoothed recording. `cargo bench --bench arm`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, Vector2, Vector3};
use pytracker::arm::cues::CueName;
use pytracker::arm::particle::{ArmLayer, Mover};
use pytracker::arm::process::GaussMarkov;
use pytracker::arm::state::View;
use pytracker::arm::{Arm, ArmFilter, Method, Noise};
use pytracker::camera::Camera;
use pytracker::filter::{Blend, Resampling};
use pytracker::quaternion::Quaternion;
use pytracker::resample::Scheme;
use pytracker::{Observation, Sample, Smoothing, Tracker};
use std::hint::black_box;

fn tracker(method: Method, noise: Noise) -> Tracker {
    let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
    let rotation = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, -1.0, 0.0);
    let camera = Camera::new(matrix, [0.0; 5], rotation, Vector3::new(0.0, 0.0, 2.3)).expect("a camera");
    let arm = Arm {
        shoulder: Vector3::new(0.1, 0.0, 0.25),
        upper_arm_m: 0.30,
        forearm_m: 0.25,
        wrist_start: Vector3::new(0.2, 0.3, 0.0),
    };
    let views = vec![View { camera, patch_offset: Vector3::zeros() }];
    ArmFilter::new(arm, views, noise, method, 1).expect("a tracker").into()
}

fn particles(layers: &[(Mover, &[CueName])], len: usize, bias: bool) -> Tracker {
    let noise = Noise { bias: bias.then_some(GaussMarkov { start_sd: 0.15, density: 0.01 }), ..Noise::default() };
    let method = Method::Particles {
        layers: layers
            .iter()
            .map(|(mover, cues)| ArmLayer { mover: *mover, cues: cues.to_vec(), blend: Blend::PRODUCT })
            .collect(),
        particles: len,
        resampling: Resampling::new(Scheme::Residual, 1.0).expect("a threshold"),
    };
    tracker(method, noise)
}

/// What the defaults of the worn methods estimate.
fn worn() -> Noise {
    let some = |start_sd, density| Some(GaussMarkov { start_sd, density });
    Noise {
        bias: some(0.08, 0.03),
        tilt: some(0.017, 0.003),
        patch_offset: some(0.01, 0.005),
        shoulder: some(0.03, 0.045),
        clock: some(0.05, 0.0),
        ..Noise::default()
    }
}

/// A frame after four samples; time runs on from call to call.
fn frame(tracker: &mut Tracker, time_s: &mut f64) {
    frame_at(tracker, time_s, 250.0);
}

fn frame_at(tracker: &mut Tracker, time_s: &mut f64, u: f64) {
    for _ in 0..4 {
        tracker.observe(Observation::inertial(still(*time_s))).expect("in order");
        *time_s += 0.01;
    }
    let seen = Observation::patch(*time_s - 0.0001, vec![Some(Vector2::new(u, 240.0))]);
    black_box(tracker.observe(seen).expect("a frame"));
}

/// A sample of a sensor that lies still.
fn still(time_s: f64) -> Sample {
    let world_sensor = Quaternion::from_rotation_vector(Vector3::new(0.9, 0.1, 0.3));
    let acceleration = world_sensor.conjugate().rotate(Vector3::new(0.0, 0.0, 9.806_65));
    Sample { time_s, acceleration, world_sensor, turn_rate: None }
}

fn camera_frame(c: &mut Criterion) {
    let colour: &[CueName] = &[CueName::Colour];
    let length: &[CueName] = &[CueName::ArmLength];
    let both: &[CueName] = &[CueName::Colour, CueName::ArmLength];
    let mut group = c.benchmark_group("arm_frame");
    for len in [500, 5_000, 50_000] {
        let methods = [
            ("layered", vec![(Mover::Inertial, colour), (Mover::Walk, length)], false),
            ("joint_bias", vec![(Mover::Inertial, both)], true),
        ];
        for (name, layers, bias) in methods {
            let (mut tracker, mut time_s) = (particles(&layers, len, bias), 0.0);
            group.bench_function(BenchmarkId::new(name, len), |b| b.iter(|| frame(&mut tracker, &mut time_s)));
        }
    }
    let corrections = vec![CueName::ArmLength];
    let (mut mixture, mut time_s) = (tracker(Method::Mixture { corrections, components: 12 }, worn()), 0.0);
    group.bench_function("mixture", |b| b.iter(|| frame(&mut mixture, &mut time_s)));
    group.finish();
}

/// Twenty seconds of a wrist that hardly moves, at 25 frames/s.
fn recording(c: &mut Criterion) {
    let corrections = vec![CueName::ArmLength];
    let mut smoother = tracker(Method::Smoother { corrections, components: 12, setup: None }, worn());
    let mut time_s = 0.0;
    for k in 0..500 {
        frame_at(&mut smoother, &mut time_s, 250.0 + 3.0 * (0.1 * f64::from(k)).sin());
    }
    let mut group = c.benchmark_group("arm_recording");
    group.sample_size(10);
    group.bench_function("smooth_20_s", |b| {
        b.iter(|| black_box(smoother.smoothed(&mut Smoothing::default()).expect("a trajectory")));
    });
    group.finish();
}

criterion_group!(benches, camera_frame, recording);
criterion_main!(benches);
