//! Online and whole runs, threads, resuming, several cameras, every list of layers.

use super::*;

#[test]
fn online_and_whole_runs_give_the_same_bytes() {
    for method in [
        layered(300),
        joint(300),
        Method::Gaussian { corrections: vec![Correction::Cue(CueName::Colour), Correction::Cue(CueName::ArmLength)] },
    ] {
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
    let observations = in_order(&samples, &frames);
    let expected = all(&mut tracker(with_bias(), layered(400)));
    let mut first = tracker(with_bias(), layered(400));
    let head = first.run(observations[..50].to_vec());
    let mut resumed = Tracker::restore(&first.save().unwrap()).unwrap();
    let tail = resumed.run(observations[50..].to_vec());
    assert_eq!([head.estimates, tail.estimates].concat(), expected);
    assert!(matches!(Tracker::restore(b"nonsense"), Err(Error::SavedState { .. })));
}

/// What comes late within the delay is put in order: the same bits, only later; beyond it it is refused by how much.
#[test]
fn late_observations_are_put_in_order() {
    let (samples, frames) = recording();
    let expected = all(&mut tracker(with_bias(), layered(300)));
    let mut observations = in_order(&samples, &frames);
    for k in (0..observations.len() - 7).step_by(7) {
        observations[k..k + 7].reverse();
    }
    let mut late = tracker(with_bias(), layered(300)).with_delay(0.2).unwrap();
    let mut found = Vec::new();
    for observation in observations {
        found.extend(late.observe(observation).unwrap());
    }
    assert!(found.len() < expected.len() && matches!(late.save(), Err(Error::Waiting { .. })));
    found.extend(late.finish().unwrap());
    assert_eq!(found, expected);
    let error = late.observe(Observation::inertial(samples[70]).numbered(70)).unwrap_err();
    let by = samples[99].time_s - samples[70].time_s;
    assert!(
        error.to_string().starts_with(&format!("IMU sample 70: IMU sample at 0.7 s comes {by} s after")),
        "{error}"
    );
    assert!(tracker(noise(), layered(10)).with_delay(-1.0).is_err());
}

/// A frame without a sighting widens the estimate; the constraint alone still holds the arm together.
#[test]
fn an_unseen_patch_shows_in_the_spread() {
    let (samples, _) = recording();
    let mut tracker = tracker(noise(), particles(vec![layer(Mover::Inertial, &[CueName::Colour])], 2000));
    let pixel = view().camera.project(arm().wrist_start);
    let mut spread = Vec::new();
    for (k, sample) in samples.iter().enumerate() {
        tracker.predict(sample).unwrap();
        if k % 4 == 0 {
            let seen = if k < 40 { pixel } else { None };
            let estimate = tracker.update(sample.time_s, &[seen]).unwrap();
            assert_eq!(estimate.log_evidence.is_some(), seen.is_some());
            spread.push(estimate.places[0].sd.x);
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
        assert!(later.state.covariance[(d, d)] > at_frame.state.covariance[(d, d)] * 0.2);
        assert!(later.places[0].lo[d] < later.places[0].mean[d] && later.places[0].mean[d] < later.places[0].hi[d]);
    }
    assert!(tracker.estimate(0.5).unwrap().places[0].sd.x > later.places[0].sd.x);
}

/// Two cameras are two sightings of one layer; where one does not see, the other does.
#[test]
fn two_cameras_fix_the_depth() {
    let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
    let sideways = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0);
    let camera = Camera::new(matrix, [0.0; 5], sideways, Vector3::new(-0.3, 0.0, 2.3)).unwrap();
    let views = vec![view(), View { camera, patch_offset: Vector3::zeros() }];
    let pixels: Vec<_> = views.iter().map(|v| v.camera.project(arm().wrist_start)).collect();
    let plain = || particles(vec![layer(Mover::Inertial, &[CueName::Colour])], 3000);
    let wide = Noise { position_start_sd_m: 0.1, ..noise() };
    let depth = |views: Vec<View>, pixels: &[Option<Vector2<f64>>]| {
        let mut tracker = made(arm(), views, wide.clone(), plain()).unwrap();
        tracker.predict(&recording().0[0]).unwrap();
        tracker.update(0.0, pixels).unwrap().places[0].sd.y
    };
    let one = depth(views[..1].to_vec(), &pixels[..1]);
    let two = depth(views.clone(), &pixels);
    assert!(one > 0.08 && two < 0.02, "{one} {two}");
    let mut tracker = made(arm(), views, wide, plain()).unwrap();
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
        let noise = Noise { outlier_fraction, position_start_sd_m: 0.05, ..noise() };
        let mut tracker = tracker(noise, particles(vec![layer(Mover::Inertial, &[CueName::Colour])], 2000));
        tracker.predict(&samples[0]).unwrap();
        (tracker.update(0.0, &[far]).unwrap().places[0].mean - arm().wrist_start).x
    };
    assert!(moved(0.0) > 0.1);
    assert!(moved(0.1).abs() < 0.01);
}

/// The list of IV-B weighs its first layer by the arm as it was at the last frame, before the motion.
#[test]
fn from_constraint_weighs_the_last_frame_first() {
    let from_constraint = vec![layer(Mover::Walk, &[CueName::ArmLength]), layer(Mover::Inertial, &[CueName::Colour])];
    let mut tracker = tracker(noise(), particles(from_constraint, 300));
    let (samples, _) = recording();
    let turned = Quaternion::from_rotation_vector(Vector3::new(0.0, 0.0, 1.0)) * samples[0].world_sensor;
    tracker.predict(&samples[0]).unwrap();
    tracker.update(0.0, &[None]).unwrap();
    tracker.predict(&Sample { time_s: 0.04, world_sensor: turned, turn_rate: None, ..samples[0] }).unwrap();
    let mut history = History::default();
    tracker.observe_recorded(Observation::patch(0.04, vec![None]), Some(&mut history)).unwrap();
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

/// The authors' earlier correction puts the elbow at its length from the shoulder.
#[test]
fn arm_projection_restores_the_length() {
    let corrections = vec![Correction::Cue(CueName::Colour), Correction::ArmProjection];
    let mut tracker = tracker(noise(), Method::Gaussian { corrections });
    for estimate in all(&mut tracker) {
        assert!(((estimate.places[1].mean - arm().shoulder).norm() - 0.30).abs() < 1e-12);
        assert_eq!((estimate.ess, estimate.places[0].mode), (None, estimate.places[0].mean));
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
    let moved = estimate.places[0].mean - arm().wrist_start;
    assert!((moved - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-12, "{moved}");
    assert!(
        (DVector::from_column_slice(&estimate.state.mean.as_slice()[3..6]) - DVector::from_vec(vec![1.0, 0.0, 0.0]))
            .norm()
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
        estimate.places[1].mean - estimate.places[0].mean
    };
    assert!((turning(None) - Vector3::new(0.0, 0.25, 0.0)).norm() < 1e-15);
    let expected = Vector3::new(-(0.1f64.sin()), 0.1f64.cos(), 0.0) * 0.25;
    assert!((turning(Some(Vector3::new(0.0, 0.0, 2.0))) - expected).norm() < 1e-15);
}

/// A shoulder that is seen elsewhere takes the elbow's sphere along; one that was seen well before the frame is not of it.
#[test]
fn a_landmark_is_of_its_frame() {
    let walk = |start_sd, density| Some(GaussMarkov { start_sd, density });
    let noise = Noise {
        bias: walk(0.1, 0.03),
        tilt: walk(0.02, 0.003),
        shoulder: walk(0.03, 0.04),
        landmarks: [walk(0.03, 0.005), None],
        ..noise()
    };
    let wrist_after = |before_s: Option<f64>| {
        let method = Method::Mixture { corrections: vec![CueName::ArmLength], components: 4 };
        let (samples, frames) = recording();
        let pixel = view().camera.project(arm().shoulder).unwrap() + Vector2::new(30.0, 0.0);
        let landmark = Landmark { joint: SeenJoint::Shoulder, camera: 0, pixel, sd: 2.0 };
        let seen = frames.iter().filter_map(|(at, _)| Some(Observation::landmark(at - before_s?, landmark)));
        let mut all: Vec<Observation> = seen.chain(in_order(&samples, &frames)).collect();
        all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        tracker(noise.clone(), method).run(all).estimates.pop().unwrap().places[0].mean
    };
    let (unseen, seen) = (wrist_after(None), wrist_after(Some(0.0)));
    assert_eq!(wrist_after(Some(0.02)), unseen, "of no frame");
    assert!((seen - unseen).norm() > 0.002, "{seen} {unseen}");
}
