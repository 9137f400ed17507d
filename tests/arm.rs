//! The arm tracker from outside: folding of samples, online and whole runs, threads, resuming, errors.

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

/// Folding n samples has the moments of n single steps.
#[test]
fn folded_motion_has_the_distribution_of_single_steps() {
    let accelerations: Vec<Vector3<f64>> =
        (0..5).map(|k| Vector3::new(f64::from(k) - 2.0, 0.5 * f64::from(k), -1.0)).collect();
    let noise = with_bias();
    let layout = Layout::new(&noise);
    let mut folded = Motion::none();
    let (mean, sd) = layout.start(&arm(), &noise);
    let mut steps = ParticleSet::new(200_000, layout.dim).unwrap();
    steps.for_each_block(|_, mut block| (0..layout.dim).for_each(|d| block.column_mut(d).fill(mean[d] + 0.1 * sd[d])));
    let mut once = steps.clone();
    for (k, acceleration) in accelerations.iter().enumerate() {
        let mut single = Motion::none();
        single.append(0.1, *acceleration, 1.0, noise.bias);
        folded.append(0.1, *acceleration, 1.0, noise.bias);
        let transition = InertialMotion::new(single, layout, &noise);
        let streams = Streams::new(1, k as u64, 0);
        steps.for_each_block(|b, block| transition.propagate(block, &mut streams.block(b)));
    }
    let transition = InertialMotion::new(folded, layout, &noise);
    let streams = Streams::new(2, 0, 0);
    once.for_each_block(|b, block| transition.propagate(block, &mut streams.block(b)));
    let ((mean_steps, covariance_steps), (mean_once, covariance_once)) = (steps.moments(), once.moments());
    let (_, _, exact) = transition.matrices();
    for d in 0..layout.dim {
        let sd = exact[(d, d)].sqrt();
        assert!((mean_steps[d] - mean_once[d]).abs() < 6.0 * sd / 200_000f64.sqrt() * 2f64.sqrt());
        for e in 0..layout.dim {
            let scale = (exact[(d, d)] * exact[(e, e)]).sqrt();
            assert!((covariance_steps[(d, e)] - exact[(d, e)]).abs() < 0.02 * scale, "steps {d} {e}");
            assert!((covariance_once[(d, e)] - exact[(d, e)]).abs() < 0.02 * scale, "folded {d} {e}");
        }
    }
}

/// The same physics at another rate: after 20 s the noise of 100 and 250 Hz agrees.
#[test]
fn noise_does_not_depend_on_the_rate() {
    let run = |rate: f64| {
        let mut motion = Motion::none();
        (0..(20.0 * rate) as usize).for_each(|_| motion.append(1.0 / rate, Vector3::zeros(), 0.1, None));
        motion.noise
    };
    let (slow, fast) = (run(100.0), run(250.0));
    for (a, b) in slow.iter().zip(fast.iter()).filter(|(a, _)| **a != 0.0) {
        assert!((a / b - 1.0).abs() < 2e-3, "{slow} {fast}");
    }
    // The continuous white-noise acceleration that both approach: q t³/3, q t²/2, q t.
    for (value, limit) in
        [(fast[(0, 0)], 0.01 * 8000.0 / 3.0), (fast[(0, 1)], 0.01 * 200.0), (fast[(1, 1)], 0.01 * 20.0)]
    {
        assert!((value / limit - 1.0).abs() < 2e-3);
    }
}

/// One sample gives noise of rank one per axis: a plain Cholesky factor would fail.
#[test]
fn a_single_sample_draws_along_one_direction() {
    let mut motion = Motion::none();
    motion.append(0.01, Vector3::zeros(), 0.1, None);
    let layout = Layout::new(&noise());
    let transition = InertialMotion::new(motion, layout, &noise());
    let mut set = ParticleSet::new(1000, layout.dim).unwrap();
    set.for_each_block(|b, block| transition.propagate(block, &mut Streams::new(1, 0, 0).block(b)));
    for row in set.rows().chunks(6) {
        // Position and velocity share one draw: T³/6 to T².
        assert!((row[0] - row[3] * 0.01 / 6.0).abs() < 1e-12);
        assert!(transition.log_density(&[0.0; 6], row).is_finite());
    }
}

/// Eqs (10) and (18) against densities written out.
#[test]
fn log_densities_are_the_normal_ones() {
    let ln_normal = |x: f64, variance: f64| -0.5 * (x * x / variance + (std::f64::consts::TAU * variance).ln());
    let walk = RandomWalk { sd: 0.02 };
    let expected = ln_normal(0.01, 4e-4) + ln_normal(-0.02, 4e-4) + ln_normal(0.03, 4e-4);
    assert!((walk.log_density(&[0.0; 6], &[0.01, -0.02, 0.03, 0.0, 0.0, 0.0]) - expected).abs() < 1e-10);
    let layout = Layout::new(&noise());
    let mut motion = Motion::none();
    for _ in 0..3 {
        motion.append(0.1, Vector3::new(1.0, 0.0, -2.0), 0.5, None);
    }
    let (q, u) = (motion.noise, motion.input);
    let transition = InertialMotion::new(motion, layout, &noise());
    let to = [0.1, -0.1, 0.0, 0.4, 0.1, -0.5];
    // Per axis: the velocity's density times the position's given the velocity.
    let expected: f64 = (0..3)
        .map(|axis| {
            let (p, v) = (to[axis] - u[(0, axis)], to[3 + axis] - u[(1, axis)]);
            let slope = q[(0, 1)] / q[(1, 1)];
            ln_normal(v, q[(1, 1)]) + ln_normal(p - slope * v, q[(0, 0)] - slope * q[(0, 1)])
        })
        .sum();
    assert!((transition.log_density(&[0.0; 6], &to) - expected).abs() < 1e-8 * expected.abs());
}

/// Where the IMU has gone silent, the arm's length is believed less and less, and a slow IMU is no silent one.
#[test]
fn a_stale_orientation_weighs_less() {
    let spread = |silent_s: f64| {
        let mut tracker = tracker(noise(), joint(4000));
        let (samples, _) = recording();
        samples[..10].iter().for_each(|sample| tracker.predict(sample).unwrap());
        tracker.update(0.09, &[None]).unwrap();
        tracker.update(0.09 + silent_s, &[None]).unwrap().wrist.sd.norm()
    };
    assert!(spread(1.0) > 5.0 * spread(0.04));
    let mut slow = tracker(noise(), Method::Gaussian { corrections: vec![] });
    for k in 0..12 {
        let acceleration = Vector3::new(1.0, 0.0, 9.806_65);
        let world_sensor = Quaternion::identity();
        slow.predict(&Sample { time_s: 0.1 * f64::from(k), acceleration, world_sensor, turn_rate: None }).unwrap();
        if k == 1 {
            slow.update(0.1, &[None]).unwrap();
        }
    }
    let moved = slow.update(1.1, &[None]).unwrap().mean[3];
    assert!((moved - 1.0).abs() < 1e-9, "{moved}");
}

#[test]
fn online_and_whole_runs_give_the_same_bytes() {
    for method in
        [layered(300), joint(300), Method::Gaussian { corrections: vec![Correction::Colour, Correction::ArmLength] }]
    {
        let whole = all(&mut tracker(with_bias(), method.clone()));
        let mut online = tracker(with_bias(), method);
        let (samples, frames) = recording();
        let mut next = 0;
        for ((time_s, pixels), expected) in frames.iter().zip(&whole) {
            while next < samples.len() && samples[next].time_s <= *time_s {
                online.predict(&samples[next]).unwrap();
                // Asking in between draws nothing and changes nothing.
                online.estimate(samples[next].time_s + 0.001).unwrap();
                next += 1;
            }
            assert_eq!(&online.update(*time_s, pixels).unwrap(), expected);
        }
    }
}

/// Enough particles that threads share every loop, resampling included.
#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| all(&mut tracker(with_bias(), layered(40_000))))
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(7));
}

#[test]
fn a_resumed_tracker_gives_the_same_tail() {
    let (samples, frames) = recording();
    let mut whole = tracker(with_bias(), layered(400));
    let expected = all(&mut whole);
    let mut first = tracker(with_bias(), layered(400));
    let head = first.run(&samples, &frames[..10], 0);
    let mut resumed = ArmTracker::restore(&first.save().unwrap()).unwrap();
    let tail = resumed.run(&samples[head.used..], &frames[10..], 10);
    assert_eq!(head.estimates, expected[..10]);
    assert_eq!(tail.estimates, expected[10..]);
    assert!(matches!(ArmTracker::restore(b"nonsense"), Err(Error::SavedState { .. })));
}

/// A frame without a sighting widens the estimate; the constraint alone still holds the arm together.
#[test]
fn an_unseen_patch_shows_in_the_spread() {
    let (samples, _) = recording();
    let mut tracker = tracker(noise(), particles(vec![layer(Mover::Inertial, &[Cue::Colour])], 2000));
    let pixel = view().camera.project(arm().wrist_start);
    let mut spread = Vec::new();
    for (k, sample) in samples.iter().enumerate() {
        tracker.predict(sample).unwrap();
        if k % 4 == 0 {
            let seen = if k < 40 { pixel } else { None };
            let estimate = tracker.update(sample.time_s, &[seen]).unwrap();
            assert_eq!(estimate.log_evidence.is_some(), seen.is_some());
            spread.push(estimate.wrist.sd.x);
        }
    }
    assert!(spread[24] > 2.0 * spread[9], "{spread:?}");
}

/// Between frames: the mean moves on, the covariance and the bands grow, and the next frame is what it was.
#[test]
fn estimates_between_frames_move_and_widen() {
    let (samples, _) = recording();
    let mut tracker = tracker(noise(), layered(500));
    tracker.predict(&samples[0]).unwrap();
    let at_frame = tracker.update(0.0, &[view().camera.project(arm().wrist_start)]).unwrap();
    let before = tracker.clone();
    let later = tracker.estimate(0.09).unwrap();
    assert_eq!(tracker, before);
    for d in 0..3 {
        assert!(later.covariance[(d, d)] > at_frame.covariance[(d, d)] * 0.2);
        assert!(later.wrist.lo[d] < later.wrist.mean[d] && later.wrist.mean[d] < later.wrist.hi[d]);
    }
    assert!(tracker.estimate(0.5).unwrap().wrist.sd.x > later.wrist.sd.x);
}

/// Two cameras are two sightings of one layer; where one does not see, the other does.
#[test]
fn two_cameras_fix_the_depth() {
    let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
    let sideways = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0);
    let camera = Camera::new(matrix, [0.0; 5], sideways, Vector3::new(-0.3, 0.0, 2.3)).unwrap();
    let views = vec![view(), View { camera, patch_offset: Vector3::zeros() }];
    let pixels: Vec<_> = views.iter().map(|v| v.camera.project(arm().wrist_start)).collect();
    let plain = || particles(vec![layer(Mover::Inertial, &[Cue::Colour])], 3000);
    let wide = Noise { position_start_sd: 0.1, ..noise() };
    let depth = |views: Vec<View>, pixels: &[Option<Vector2<f64>>]| {
        let mut tracker = ArmTracker::new(arm(), views, wide.clone(), plain(), 1).unwrap();
        tracker.predict(&recording().0[0]).unwrap();
        tracker.update(0.0, pixels).unwrap().wrist.sd.y
    };
    let one = depth(views[..1].to_vec(), &pixels[..1]);
    let two = depth(views.clone(), &pixels);
    assert!(one > 0.08 && two < 0.02, "{one} {two}");
    let mut tracker = ArmTracker::new(arm(), views, wide, plain(), 1).unwrap();
    tracker.predict(&recording().0[0]).unwrap();
    let error = tracker.update(0.0, &pixels[..1]).unwrap_err();
    assert_eq!(error, Error::Size { name: "pixels", got: 1, unit: "cameras", expected: 2 });
}

/// A sighting far from every particle moves a Gaussian cue, and hardly a mixture with outliers.
#[test]
fn an_outlier_is_tolerated_where_asked() {
    let (samples, _) = recording();
    let far = view().camera.project(arm().wrist_start + Vector3::new(0.3, 0.0, 0.0));
    let moved = |outlier_fraction| {
        let noise = Noise { outlier_fraction, position_start_sd: 0.05, ..noise() };
        let mut tracker = tracker(noise, particles(vec![layer(Mover::Inertial, &[Cue::Colour])], 2000));
        tracker.predict(&samples[0]).unwrap();
        (tracker.update(0.0, &[far]).unwrap().wrist.mean - arm().wrist_start).x
    };
    assert!(moved(0.0) > 0.1);
    assert!(moved(0.1).abs() < 0.01);
}

/// The list of IV-B weighs its first layer by the arm as it was at the last frame, before the motion.
#[test]
fn from_constraint_weighs_the_last_frame_first() {
    let from_constraint = vec![layer(Mover::Walk, &[Cue::ArmLength]), layer(Mover::Inertial, &[Cue::Colour])];
    let mut tracker = tracker(noise(), particles(from_constraint, 300));
    let (samples, _) = recording();
    let turned = Quaternion::from_rotation_vector(Vector3::new(0.0, 0.0, 1.0)) * samples[0].world_sensor;
    tracker.predict(&samples[0]).unwrap();
    tracker.update(0.0, &[None]).unwrap();
    tracker.predict(&Sample { time_s: 0.04, world_sensor: turned, turn_rate: None, ..samples[0] }).unwrap();
    let mut history = History::default();
    tracker.update_recorded(0.04, &[None], Some(&mut history)).unwrap();
    assert_eq!(history.layers.iter().map(|l| l.layer).collect::<Vec<_>>(), [0, 1]);
    let forearm = samples[0].world_sensor.rotate(Vector3::new(0.0, 0.25, 0.0));
    let likelihood: Vec<f64> = history.layers[0]
        .predicted
        .chunks(6)
        .map(|row| {
            let upper_arm = Vector3::new(row[0], row[1], row[2]) + forearm - arm().shoulder;
            (-0.5 * ((upper_arm.norm() - 0.30) / 0.01).powi(2)).exp()
        })
        .collect();
    let sum: f64 = likelihood.iter().sum();
    for (weight, likelihood) in history.layers[0].weights.iter().zip(&likelihood) {
        assert!((weight - likelihood / sum).abs() < 1e-12);
    }
}

#[test]
fn late_and_broken_samples_are_refused_and_change_nothing() {
    let (samples, frames) = recording();
    let mut tracker = tracker(noise(), joint(100));
    assert_eq!(tracker.update(0.0, &[None]).unwrap_err(), Error::NoInertialSample { time_s: 0.0 });
    tracker.predict(&samples[0]).unwrap();
    tracker.update(frames[0].0, &frames[0].1).unwrap();
    let before = tracker.clone();
    let with = |change: &dyn Fn(&mut Sample)| {
        let mut sample = samples[1];
        change(&mut sample);
        sample
    };
    let late = Error::Late { what: "IMU sample", time_s: 0.001, latest_s: 0.003 };
    assert_eq!(tracker.predict(&with(&|s| s.time_s = 0.001)).unwrap_err(), late);
    let error = tracker.predict(&with(&|s| s.acceleration.y = f64::INFINITY)).unwrap_err();
    assert_eq!(error, Error::NotFinite { name: "acceleration", time_s: 0.01, value: f64::INFINITY });
    let error = tracker.predict(&with(&|s| s.world_sensor.w *= 3.0)).unwrap_err();
    assert!(matches!(error, Error::QuaternionNorm { .. }));
    let error = tracker.update(0.002, &[None]).unwrap_err();
    assert_eq!(error, Error::Late { what: "frame", time_s: 0.002, latest_s: 0.003 });
    let error = tracker.update(0.01, &[Some(Vector2::new(f64::INFINITY, 3.0))]).unwrap_err();
    assert!(matches!(error, Error::NotFinite { name: "pixel", .. }));
    assert_eq!(tracker, before);
}

/// Behind the camera nothing can be seen: the run stops at that frame, and what came before is kept.
#[test]
fn a_lost_track_names_its_frame() {
    let (samples, frames) = recording();
    let behind = Arm { wrist_start: Vector3::new(0.2, 9.0, 0.0), ..arm() };
    let mut tracker = ArmTracker::new(behind, vec![view()], noise(), layered(50), 1).unwrap();
    let mut unseen = frames.clone();
    unseen[..3].iter_mut().for_each(|frame| frame.1[0] = None);
    let stretch = tracker.run(&samples, &unseen, 100);
    assert_eq!(stretch.estimates.len(), 3);
    let stopped = stretch.stopped.unwrap();
    assert!(stopped.is_loss_of_track());
    let again = tracker.update(0.5, &[None]).unwrap_err();
    assert_eq!(again, Error::Lost { time_s: 0.5, lost_at_s: unseen[3].0 });
    assert_eq!(
        stopped.to_string(),
        "frame 103: all 50 particle weights are zero at 0.123 s (layer 0), expected at least one particle that the \
         observation allows"
    );
}

#[test]
fn parameters_out_of_range_are_named() {
    let refuse = |noise: Noise| match ArmTracker::new(arm(), vec![view()], noise, joint(10), 0) {
        Err(Error::Parameter { name, .. }) => name,
        _ => "accepted",
    };
    assert_eq!(refuse(Noise { accel_density: 0.0, ..noise() }), "accel_density");
    assert_eq!(refuse(Noise { pixel_sd: -1.0, ..noise() }), "pixel_sd");
    assert_eq!(refuse(Noise { outlier_fraction: 1.0, ..noise() }), "outlier_fraction");
    assert_eq!(refuse(Noise { arm_length_sd: f64::NAN, ..noise() }), "arm_length_sd_m");
    assert_eq!(refuse(Noise { hold_s: f64::INFINITY, ..noise() }), "hold_s");
    let short = Arm { forearm_m: 0.0, ..arm() };
    let error = ArmTracker::new(short, vec![view()], noise(), joint(10), 0).unwrap_err();
    assert_eq!(error.to_string(), "forearm_m is 0, expected a positive length in metres, at most 1");
    assert!(matches!(Resampling::new(Scheme::Residual, 1.5), Err(Error::Parameter { name: "ess_threshold", .. })));
    let none = particles(vec![layer(Mover::Walk, &[Cue::ArmLength])], 10);
    assert!(matches!(ArmTracker::new(arm(), vec![view()], noise(), none, 0), Err(Error::Size { name: "layers", .. })));
    let empty = joint(0);
    assert!(matches!(
        ArmTracker::new(arm(), vec![view()], noise(), empty, 0),
        Err(Error::Parameter { name: "particles", .. })
    ));
    assert!(Mover::from_name("inertal").is_err() && Cue::from_name("color").is_err());
    assert!(Correction::from_name("arm").is_err());
}

/// The authors' earlier correction puts the elbow at its length from the shoulder.
#[test]
fn arm_projection_restores_the_length() {
    let corrections = vec![Correction::Colour, Correction::ArmProjection];
    let mut tracker = tracker(noise(), Method::Gaussian { corrections });
    for estimate in all(&mut tracker) {
        assert!(((estimate.elbow.mean - arm().shoulder).norm() - 0.30).abs() < 1e-12);
        assert_eq!((estimate.ess, estimate.wrist.mode), (None, estimate.wrist.mean));
    }
}

/// Inertial only integrates the samples: constant acceleration gives a parabola.
#[test]
fn inertial_only_integrates_twice() {
    let mut tracker = tracker(noise(), Method::Gaussian { corrections: vec![] });
    let at = |k: u32| Sample {
        time_s: f64::from(k) / 100.0,
        acceleration: Vector3::new(1.0, 0.0, 9.806_65),
        world_sensor: Quaternion::identity(),
        turn_rate: None,
    };
    tracker.predict(&at(0)).unwrap();
    tracker.update(0.0, &[None]).unwrap();
    (1..=100).for_each(|k| tracker.predict(&at(k)).unwrap());
    let estimate = tracker.update(1.0, &[None]).unwrap();
    let moved = estimate.wrist.mean - arm().wrist_start;
    assert!((moved - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-12, "{moved}");
    assert!(
        (DVector::from_column_slice(&estimate.mean.as_slice()[3..6]) - DVector::from_vec(vec![1.0, 0.0, 0.0])).norm()
            < 1e-12
    );
}

/// The orientation at a frame is the latest sample's, advanced by the gyroscope.
#[test]
fn the_gyroscope_advances_the_orientation() {
    let turning = |turn_rate| {
        let mut tracker = tracker(noise(), Method::Gaussian { corrections: vec![] });
        let acceleration = Vector3::new(0.0, 0.0, 9.806_65);
        tracker
            .predict(&Sample { time_s: 0.0, acceleration, world_sensor: Quaternion::identity(), turn_rate })
            .unwrap();
        let estimate = tracker.update(0.05, &[None]).unwrap();
        estimate.elbow.mean - estimate.wrist.mean
    };
    assert!((turning(None) - Vector3::new(0.0, 0.25, 0.0)).norm() < 1e-15);
    let expected = Vector3::new(-(0.1f64.sin()), 0.1f64.cos(), 0.0) * 0.25;
    assert!((turning(Some(Vector3::new(0.0, 0.0, 2.0))) - expected).norm() < 1e-15);
}
