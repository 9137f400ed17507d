//! The body as a mixture of Gaussians: both ways of a limb, what it forgets, and what it says of what it does not see.

use figure::{ALL, SUM, figure, figure_from, layer, method, projection, update};
use pytracker::body::cues::keypoints::{Keypoint, Person};
use pytracker::body::{
    BodyFilter, BodyMethod, CueName, FilterMethod, MixtureMethod, Momentum, ParticleMethod, Picture, Unseen,
};
use pytracker::{Error, Estimate, Tracker};

mod figure;

/// The root's place, and the left shoulder's turn out of the picture's plane.
const FREE: [usize; 3] = [0, 1, 7];
const MOMENTUM: Momentum = Momentum { base: 0.5, turn: 2.0, joint: 3.0, lasts_s: 1.0, first_m: 0.01, first_rad: 0.05 };

fn mixture(components: usize) -> BodyMethod {
    let filter = FilterMethod::Mixture(MixtureMethod { components, momentum: MOMENTUM });
    BodyMethod { filter, ..method(layer(&ALL, &[CueName::Keypoints], SUM), 0.0) }
}

/// Elbow and wrist of an arm that leans by an angle out of the plane, and the shoulders.
fn seen(lean: f64) -> Picture {
    let at = |u: f64| Some(Keypoint { pixel: [u, 55.0], sd_px: 1.0 });
    let mut person = Person::default();
    (person[1], person[2]) = (at(118.0), at(82.0));
    (person[3], person[5]) = (at(118.0 + 30.0 * lean.cos()), at(118.0 + 55.0 * lean.cos()));
    Picture { keypoints: vec![person], ..Picture::default() }
}

/// From in the plane out of it, and held there.
fn lean(time_s: f64) -> f64 {
    0.9 * (2.0 * time_s).min(1.0)
}

fn followed(components: usize, count: u32) -> (Tracker, Vec<Estimate>) {
    let figure = figure_from(&FREE, 7, 0.0);
    let mut tracker = Tracker::from(BodyFilter::new(figure, projection(), mixture(components), 1).unwrap());
    let estimates =
        (0..count).map(|k| f64::from(k) / 30.0).map(|time_s| update(&mut tracker, time_s, &seen(lean(time_s))));
    let estimates = estimates.collect::<Result<_, _>>().unwrap();
    (tracker, estimates)
}

/// An arm that left the picture's plane leans towards the camera or away, and nothing tells which: both are in the band, and
/// across the picture it is where it is seen. One Gaussian holds neither.
#[test]
fn both_ways_of_a_limb_are_kept() {
    let (_, estimates) = followed(12, 60);
    let last = estimates.last().unwrap();
    let wrist = &last.places[6];
    let depth = 0.55 * lean(2.0).sin();
    assert!(wrist.lo.z < -0.8 * depth && wrist.hi.z > 0.8 * depth, "{} to {} m", wrist.lo.z, wrist.hi.z);
    assert!((wrist.mean.x - (0.18 + 0.55 * lean(2.0).cos())).abs() < 0.05, "{} m", wrist.mean.x);
    assert!((last.state.mean[2].abs() - 0.9).abs() < 0.2, "{} rad", last.state.mean[2]);
    // Its slope along the depth is none in the plane: it stays there, beside what is seen.
    let (_, alone) = followed(1, 60);
    let one = &alone.last().unwrap().places[6];
    assert!(one.mean.x - wrist.mean.x > 0.1, "{} and {} m", one.mean.x, wrist.mean.x);
}

/// A soft limit that is hardly passed loses hardly anything: that it is there at all tells nothing of where the limb is.
#[test]
fn a_limit_that_is_just_passed_decides_nothing() {
    for upper in [0.93, 0.89, 0.87] {
        let mut figure = figure_from(&FREE, 7, 0.0);
        figure.limits[2] = [-2.0, upper];
        let cues = [CueName::Keypoints, CueName::Limits];
        let method = BodyMethod { layers: vec![layer(&ALL, &cues, SUM)], ..mixture(12) };
        let mut tracker = Tracker::from(BodyFilter::new(figure, projection(), method, 1).unwrap());
        let seen = |k: u32| seen(lean(f64::from(k) / 30.0));
        let last = (0..90).map(|k| update(&mut tracker, f64::from(k) / 30.0, &seen(k)).unwrap()).last().unwrap();
        let wrist = &last.places[6];
        assert!(wrist.lo.z < -0.3 && wrist.hi.z > 0.3, "{upper} rad: {} to {} m", wrist.lo.z, wrist.hi.z);
    }
}

/// What is not seen is known worse and worse, but no worse than a joint of which nothing is known; what is found again is known.
#[test]
fn what_is_not_seen_is_anywhere_and_found_again() {
    let (mut tracker, estimates) = followed(12, 30);
    let known = estimates.last().unwrap().state.covariance[(2, 2)].sqrt();
    let mut unseen = Vec::new();
    for k in 30..330 {
        let estimate = update(&mut tracker, f64::from(k) / 30.0, &Picture::default()).unwrap();
        unseen.push(estimate.state.covariance[(2, 2)].sqrt());
    }
    assert!(unseen[10] > known && unseen[299] > 0.9);
    // Either way of it, each no wider than a radian.
    assert!(unseen.iter().all(|sd| *sd < 1.0_f64.hypot(1.2)), "{unseen:?}");
    let found = (330..345).map(|k| update(&mut tracker, f64::from(k) / 30.0, &seen(0.0)).unwrap()).last().unwrap();
    let wrist = &found.places[6];
    assert!((wrist.mean.x - 0.73).abs() < 0.05, "{} m", wrist.mean.x);
}

/// The same bits for any seed, and from where it was saved; there are no particles.
#[test]
fn there_is_no_chance_in_it() {
    let (tracker, _) = followed(12, 20);
    let mut again = Tracker::restore(&tracker.save().unwrap()).unwrap();
    let mut other = Tracker::from(BodyFilter::new(figure_from(&FREE, 7, 0.0), projection(), mixture(12), 99).unwrap());
    for k in 0..20 {
        update(&mut other, f64::from(k) / 30.0, &seen(lean(f64::from(k) / 30.0))).unwrap();
    }
    let (from_saved, from_other) =
        (update(&mut again, 0.7, &seen(0.9)).unwrap(), update(&mut other, 0.7, &seen(0.9)).unwrap());
    assert_eq!(from_saved, from_other);
    assert!(tracker.particles().is_none() && from_saved.ess.is_none() && from_saved.log_evidence.is_none());
}

/// What the camera does not see of the body as a whole widens its bands as it widens those of particles.
#[test]
fn depth_that_is_not_seen_is_in_the_bands() {
    let wide = |distance_m: f64| {
        let unseen = Unseen { distance_m, first_distance_m: 0.0, lean: 0.0, turn: 0.0, across_m: 0.0, bend: 0.0 };
        let filter = BodyFilter::new(figure(&FREE), projection(), BodyMethod { unseen, ..mixture(12) }, 1);
        let mut tracker = Tracker::from(filter.unwrap());
        let last = (0..90).map(|k| update(&mut tracker, f64::from(k) / 30.0, &seen(0.0)).unwrap()).last().unwrap();
        last.places[0].sd.z
    };
    assert!(wide(0.1) > wide(0.0) + 0.05, "{} and {} m", wide(0.1), wide(0.0));
}

#[test]
fn ranges_are_checked() {
    let with = |method: BodyMethod| BodyFilter::new(figure(&FREE), projection(), method, 1).map(|_| ());
    assert!(matches!(with(mixture(0)), Err(Error::Parameter { name: "components", .. })));
    let filter = FilterMethod::Particles(ParticleMethod { islands: 0, ..figure::particles() });
    assert!(matches!(with(BodyMethod { filter, ..mixture(1) }), Err(Error::Parameter { name: "islands", .. })));
}
