//! What is refused, and with which words.

use super::*;

#[test]
fn late_and_broken_samples_are_refused_and_change_no_estimate() {
    let (samples, frames) = recording();
    let mut tracker = tracker(noise(), joint(100));
    assert_eq!(tracker.update(0.0, &[None]).unwrap_err(), Error::NoInertialSample { time_s: 0.0 });
    tracker.predict(&samples[0]).unwrap();
    tracker.update(frames[0].0, &frames[0].1).unwrap();
    let mut before = tracker.clone();
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
    let stretch = before.run(in_order(&samples[1..], &frames[1..]));
    assert!(stretch.stopped.is_none() && !stretch.estimates.is_empty());
    assert_eq!(tracker.run(in_order(&samples[1..], &frames[1..])), stretch);
}

/// Behind the camera nothing can be seen: the run stops at that frame, and what came before is kept.
#[test]
fn a_lost_track_names_its_frame() {
    let (samples, frames) = recording();
    let behind = Arm { wrist_start: Vector3::new(0.2, 9.0, 0.0), ..arm() };
    let mut tracker = made(behind, vec![view()], noise(), layered(50)).unwrap();
    let mut unseen = frames.clone();
    unseen[..3].iter_mut().for_each(|frame| frame.1[0] = None);
    let stretch = tracker.run(in_order(&samples, &unseen));
    assert_eq!(stretch.estimates.len(), 3);
    let stopped = stretch.stopped.unwrap();
    assert!(stopped.is_loss_of_track());
    let again = tracker.update(0.5, &[None]).unwrap_err();
    assert_eq!(again, Error::Lost { time_s: 0.5, lost_at_s: unseen[3].0 });
    assert_eq!(
        stopped.to_string(),
        "frame 3: all 50 particle weights are zero at 0.123 s (layer 0), expected at least one particle that the \
         observation allows"
    );
}

#[test]
fn parameters_out_of_range_are_named() {
    let refuse = |noise: Noise| match made(arm(), vec![view()], noise, joint(10)) {
        Err(Error::Parameter { name, .. }) => name,
        _ => "accepted",
    };
    assert_eq!(refuse(Noise { accel_density: 0.0, ..noise() }), "accel_density");
    assert_eq!(refuse(Noise { pixel_sd: -1.0, ..noise() }), "pixel_sd");
    assert_eq!(refuse(Noise { outlier_fraction: 1.0, ..noise() }), "outlier_fraction");
    assert_eq!(refuse(Noise { arm_length_sd_m: f64::NAN, ..noise() }), "arm_length_sd_m");
    assert_eq!(refuse(Noise { hold_s: f64::INFINITY, ..noise() }), "hold_s");
    let short = Arm { forearm_m: 0.0, ..arm() };
    let error = made(short, vec![view()], noise(), joint(10)).unwrap_err();
    assert_eq!(error.to_string(), "forearm_m is 0, expected a positive length in metres, at most 1");
    assert!(matches!(Resampling::new(Scheme::Residual, 1.5), Err(Error::Parameter { name: "ess_threshold", .. })));
    let none = particles(vec![layer(Mover::Walk, &[CueName::ArmLength])], 10);
    assert!(matches!(made(arm(), vec![view()], noise(), none), Err(Error::Size { name: "layers", .. })));
    let empty = joint(0);
    assert!(matches!(made(arm(), vec![view()], noise(), empty), Err(Error::Parameter { name: "particles", .. })));
    assert!(Mover::from_name("inertal").is_err() && CueName::from_name("color").is_err());
    assert!(Correction::from_name("arm").is_err());
}
