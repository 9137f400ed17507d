//! How particles of the arm move: folding of samples, densities.

use super::*;

/// `ln p(to | from)` of one state.
fn one(transition: &dyn Transition, from: &[f64], to: &[f64]) -> f64 {
    let mut out = [0.0];
    transition.log_densities(from, to, &mut out);
    out[0]
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
        assert!(one(&transition, &[0.0; 6], row).is_finite());
    }
}

/// Eqs (10) and (18) against densities written out.
#[test]
fn log_densities_are_the_normal_ones() {
    let ln_normal = |x: f64, variance: f64| -0.5 * (x * x / variance + (std::f64::consts::TAU * variance).ln());
    let walk = RandomWalk { sd: 0.02 };
    let expected = ln_normal(0.01, 4e-4) + ln_normal(-0.02, 4e-4) + ln_normal(0.03, 4e-4);
    assert!((one(&walk, &[0.0; 6], &[0.01, -0.02, 0.03, 0.0, 0.0, 0.0]) - expected).abs() < 1e-10);
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
    assert!((one(&transition, &[0.0; 6], &to) - expected).abs() < 1e-8 * expected.abs());
}

/// Where the IMU has gone silent, the arm's length is believed less and less, and a slow IMU is no silent one.
#[test]
fn a_stale_orientation_weighs_less() {
    let spread = |silent_s: f64| {
        let mut tracker = tracker(noise(), joint(4000));
        let (samples, _) = recording();
        samples[..10].iter().for_each(|sample| tracker.predict(sample).unwrap());
        tracker.update(0.09, &[None]).unwrap();
        tracker.update(0.09 + silent_s, &[None]).unwrap().places[0].sd.norm()
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
    let moved = slow.update(1.1, &[None]).unwrap().state.mean[3];
    assert!((moved - 1.0).abs() < 1e-9, "{moved}");
}

/// Found by the fuzzer: times whose powers underflow gave a noise that is no number, and a tracker that was none without a word.
#[test]
fn next_to_no_time_is_no_time() {
    for dt in [0.0, 1e-308, 1e-154, 1e-101] {
        let mut motion = Motion::none();
        motion.append(dt, Vector3::new(1.0, 2.0, 3.0), 0.1, with_bias().bias);
        assert_eq!(motion, Motion::none());
    }
    let mut motion = Motion::none();
    motion.append(1e-90, Vector3::zeros(), 0.1, None);
    assert!(InertialMotion::new(motion, Layout::new(&noise()), &noise()).matrices().2.iter().all(|x| x.is_finite()));
}

/// What a motion cannot reach has no density: a walk moves no velocity, one sample moves a position by its velocity alone.
#[test]
fn what_cannot_be_reached_has_no_density() {
    let walk = RandomWalk { sd: 0.02 };
    assert_eq!(one(&walk, &[0.0; 6], &[0.01, 0.0, 0.0, 0.1, 0.0, 0.0]), f64::NEG_INFINITY);
    let mut motion = Motion::none();
    motion.append(0.01, Vector3::zeros(), 0.1, None);
    let transition = InertialMotion::new(motion, Layout::new(&noise()), &noise());
    assert_eq!(one(&transition, &[0.0; 6], &[0.01, 0.0, 0.0, 0.0, 0.0, 0.0]), f64::NEG_INFINITY);
    assert!(one(&transition, &[0.0; 6], &[0.0; 6]).is_finite());
}
