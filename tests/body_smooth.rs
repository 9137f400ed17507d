//! What a body's cues say when they are linearised, and a recording that is smoothed by them.

mod figure;

use figure::{
    ALL, KEYPOINT_PARAMETERS, SUM, figure, figure_bending, figure_from, layer, method, particles, projection, tracker,
    update,
};
use nalgebra::{DVector, UnitQuaternion, Vector3};
use proptest::prelude::*;
use pytracker::body::cues::effort::{Effort, EffortParameters};
use pytracker::body::cues::keypoints::{Keypoint, KeypointDistance, Person};
use pytracker::body::cues::limits::Limits;
use pytracker::body::cues::orientation::{Orientation, OrientationDistance, OrientationParameters, Segment};
use pytracker::body::cues::posture::{Posture, PostureParameters};
use pytracker::body::sloped::{Rows, Sloped};
use pytracker::body::weighing::{Cue, Weighing};
use pytracker::body::{BodyMethod, CueName, Figure, FilterMethod, Group, Momentum, ParticleMethod, Picture};
use pytracker::particles::ParticleSet;
use pytracker::{Error, Estimate, Smoothing, Tracker};

/// The root's place, the left shoulder's three turns and the elbow's.
const FREE: [usize; 6] = [0, 1, 6, 7, 8, 9];

/// Residuals of a cue about a state, and their slopes.
fn linearised(figure: &Figure, cue: &dyn Cue, state: &[f64]) -> Option<(DVector<f64>, nalgebra::DMatrix<f64>)> {
    let projection = projection();
    let mut rows = Rows::default();
    cue.linearise(&Sloped::new(figure, &projection, state), &mut rows);
    rows.linear(state.len()).map(|(residual, slope, _)| (residual, slope))
}

fn person() -> Person {
    std::array::from_fn(|k| Some(Keypoint { pixel: [90.0 + 10.0 * k as f64, 60.0], sd_px: 2.0 }))
}

proptest! {
    /// A residual falls as its slope says.
    #[test]
    fn slopes_are_those_of_the_residuals(state in prop::array::uniform6(-0.9_f64..0.9), turn in prop::array::uniform3(-1.0_f64..1.0)) {
        let figure = figure(&FREE);
        // The shoulder's rz is beyond its limit of 1 rad: that, too, has a slope.
        let mut state = state;
        state[4] += 1.1_f64.copysign(state[4]);
        let q_world_segment = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
        let orientation = Orientation { segment: Segment::UpperArm(Group::LeftArm), q_world_segment, sd: 0.1, roll_sd: 1e9 };
        let seen = person();
        let (orientations, inflation) = ([Orientation { roll_sd: f64::INFINITY, ..orientation }], 1.0);
        let cues: [Box<dyn Cue>; 4] = [
            Box::new(KeypointDistance { person: &seen, groups: &ALL, parameters: KEYPOINT_PARAMETERS }),
            Box::new(Effort { groups: &ALL, parameters: EffortParameters { loss: 1.0 } }),
            Box::new(OrientationDistance { orientations: &orientations, groups: &ALL, parameters: OrientationParameters { inflation } }),
            Box::new(Limits),
        ];
        let mut told = 0;
        for cue in &cues {
            let Some((residual, slope)) = linearised(&figure, cue.as_ref(), &state) else { continue };
            told += 1;
            for d in 0..state.len() {
                let at = |by: f64| {
                    let mut moved = state;
                    moved[d] += by;
                    linearised(&figure, cue.as_ref(), &moved).map(|(residual, _)| residual)
                };
                let (Some(after), Some(before)) = (at(1e-5), at(-1e-5)) else { continue };
                if after.len() == residual.len() && before.len() == residual.len() {
                    let found = (before - after) / 2e-5;
                    prop_assert!((found - slope.column(d)).amax() < 1e-3 * (1.0 + slope.amax()));
                }
            }
        }
        prop_assert_eq!(told, cues.len());
    }

    /// The square of what a posture tells is twice what it takes from particles, and falls as its slope says, as root and arm turn.
    #[test]
    fn a_posture_is_the_square_of_a_number(state in prop::array::uniform7(-1.0_f64..1.0)) {
        let figure = figure(&[3, 4, 5, 6, 7, 8, 9]);
        let cue = Posture { groups: &[Group::LeftArm], parameters: PostureParameters { weight: 0.7 } };
        let at = |d: usize, by: f64| {
            let mut moved = state;
            moved[d] += by;
            linearised(&figure, &cue, &moved).unwrap()
        };
        let (residual, slope) = at(0, 0.0);
        for d in 0..state.len() {
            let found = (at(d, -1e-6).0[0] - at(d, 1e-6).0[0]) / 2e-6;
            prop_assert!((found - slope[(0, d)]).abs() < 1e-4 * (1.0 + slope.amax()), "{found} {}", slope[(0, d)]);
        }
        let set = ParticleSet::from_rows(7, &state).unwrap();
        let projection = projection();
        let weighing = Weighing { figure: &figure, projection: &projection, cues: vec![Box::new(cue)], bounds: vec![], blend: SUM };
        let lost = weighing.losses(&set)[0][0];
        prop_assert!((0.5 * residual[0].powi(2) - lost).abs() < 1e-9 + 0.7e-3, "{} {lost}", residual[0]);
    }

    /// The roll is the last of four rows: the angle between the sensor's elbow axis and the arm's, and its slope.
    #[test]
    fn a_roll_is_told(roll in -1.0_f64..1.0, turned in -1.0_f64..1.0) {
        let figure = figure_bending(&FREE);
        // The arm lies along x and turns about itself by its x; +y of a sensor on it points from elbow to shoulder, -x.
        let lying = |turned: f64| [0.0, 0.0, turned, 0.0, 0.0, 0.0];
        let along = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let residual = |roll: f64, turned: f64| {
            let q_world_segment = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), roll) * along;
            let segment = Segment::UpperArm(Group::LeftArm);
            let orientations = [Orientation { segment, q_world_segment, sd: 0.1, roll_sd: 0.1 }];
            let cue = OrientationDistance { orientations: &orientations, groups: &ALL, parameters: OrientationParameters { inflation: 1.0 } };
            linearised(&figure, &cue, &lying(turned)).unwrap()
        };
        let (found, slope) = residual(roll, turned);
        prop_assert_eq!(found.len(), 4);
        let by_sensor = (residual(roll + 1e-5, turned).0[3] - residual(roll - 1e-5, turned).0[3]) / 2e-5;
        let by_arm = (residual(roll, turned - 1e-5).0[3] - residual(roll, turned + 1e-5).0[3]) / 2e-5;
        prop_assert!((slope[(3, 2)] - by_arm).abs() < 1e-3, "{} is not {by_arm}", slope[(3, 2)]);
        // Both turn about the same axis: the arm's turn takes away what the sensor's adds.
        prop_assert!((by_sensor.abs() - 1.0).abs() < 1e-3 && (by_sensor - by_arm).abs() < 1e-3);
    }
}

/// How far the left arm is turned out of the picture's plane: through it at half a second, and at one and a half.
fn turned(time_s: f64) -> f64 {
    0.8 * (std::f64::consts::PI * time_s).cos()
}

fn seen_at(time_s: f64) -> Picture {
    seen_of(turned(time_s))
}

/// What a detector sees of an arm that is turned so far: elbow and wrist.
fn seen_of(turned: f64) -> Picture {
    let wide = turned.cos();
    let at = |reach: f64| Some(Keypoint { pixel: [118.0 + 100.0 * reach * wide, 55.0], sd_px: 1.0 });
    let mut person: Person = Default::default();
    (person[3], person[5]) = (at(0.3), at(0.55));
    person[1] = Some(Keypoint { pixel: [118.0, 55.0], sd_px: 1.0 });
    person[2] = Some(Keypoint { pixel: [82.0, 55.0], sd_px: 1.0 });
    Picture { keypoints: vec![person], ..Picture::default() }
}

fn smoothed_by(momentum: Momentum) -> BodyMethod {
    let layer = layer(&ALL, &[CueName::Keypoints, CueName::Limits], SUM);
    let filter = FilterMethod::Particles(ParticleMethod { smoothing: Some(momentum), ..particles() });
    BodyMethod { filter, ..method(layer, 0.0) }
}

const MOMENTUM: Momentum = Momentum { base: 0.5, turn: 2.0, joint: 3.0, lasts_s: 1.0, first_m: 0.01, first_rad: 0.05 };

fn followed(count: u32, seed: u64) -> Tracker {
    let mut tracker = tracker(figure_from(&[0, 1, 7], 7, turned(0.0)), smoothed_by(MOMENTUM), seed).unwrap();
    for k in 0..count {
        let time_s = f64::from(k) / 30.0;
        update(&mut tracker, time_s, &seen_at(time_s)).unwrap();
    }
    tracker
}

fn smoothed(tracker: &Tracker) -> Vec<Estimate> {
    tracker.smoothed(&mut Smoothing::default()).unwrap()
}

/// Two ways on look alike where a limb passes through the picture's plane: how it moves tells them apart.
#[test]
fn a_limb_goes_on_as_it_moves() {
    for seed in 0..4 {
        let (tracker, mut smoothing) = (followed(61, seed), Smoothing::default());
        let estimates = tracker.smoothed(&mut smoothing).unwrap();
        assert_eq!(estimates.len(), 61);
        for estimate in &estimates {
            let (found, truth) = (estimate.state.mean[2], turned(estimate.time_s));
            assert!((found - truth).abs() < 0.25, "at {} s: {found} is not {truth}", estimate.time_s);
            let wrist = &estimate.places[6];
            assert!(wrist.lo.z <= wrist.mean.z && wrist.mean.z <= wrist.hi.z);
        }
        assert!(tracker.smoothed(&mut smoothing).unwrap().is_empty());
    }
}

/// From rest in the picture's plane a limb may have left it either way: both are in the band, and neither is the mean.
#[test]
fn a_limb_that_left_the_plane_from_rest_may_lean_either_way() {
    let leant = |time_s: f64| 0.35 * (1.0 - (std::f64::consts::PI * (time_s - 0.7).clamp(0.0, 1.0)).cos());
    let mut tracker = tracker(figure_from(&[0, 1, 7], 7, 0.0), smoothed_by(MOMENTUM), 1).unwrap();
    for k in 0..75 {
        let time_s = f64::from(k) / 30.0;
        update(&mut tracker, time_s, &seen_of(leant(time_s))).unwrap();
    }
    for estimate in &smoothed(&tracker)[55..] {
        let (wrist, depth) = (&estimate.places[6], 0.55 * leant(estimate.time_s).sin());
        assert!(wrist.lo.z < 0.03 - depth && wrist.hi.z > depth - 0.03, "{wrist:?}");
        assert!((wrist.mode.z.abs() - depth).abs() < 0.05 && wrist.mean.z.abs() < 0.5 * depth, "{wrist:?}");
    }
}

/// Beyond 800 frames there is more than one window: every frame once, no jump, and poses are where the joints are.
#[test]
fn windows_of_a_long_recording_go_over_into_each_other() {
    let (tracker, mut smoothing) = (followed(900, 1), Smoothing::default());
    let mut estimates = tracker.smoothed(&mut smoothing).unwrap();
    assert_eq!(estimates.len(), 600);
    estimates.extend(tracker.smoothed(&mut smoothing).unwrap());
    assert_eq!(estimates.len(), 900);
    assert!(estimates.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
    let jump = |pair: &[Estimate]| {
        let off = |one: &Estimate| one.state.mean[2] - turned(one.time_s);
        (off(&pair[1]) - off(&pair[0])).abs()
    };
    let most = |frames: &[Estimate]| frames.windows(2).map(jump).fold(0.0, f64::max);
    assert!(most(&estimates[595..705]) <= most(&estimates[..595]), "{} rad", most(&estimates[595..705]));
    for estimate in &estimates {
        let posed = tracker.pose(&ParticleSet::from_rows(3, estimate.state.mean.as_slice()).unwrap()).unwrap().rows();
        let wrist = Vector3::from_column_slice(&posed[18..21]);
        let off_m = (wrist - estimate.places[6].mode).norm();
        assert!(off_m < 1e-3, "{off_m} m at {} s", estimate.time_s);
    }
}

/// A tracker that was saved in between smooths to the same bits; one that does not smooth has nothing to say.
#[test]
fn what_is_kept_is_saved() {
    let kept = followed(20, 1);
    let again = Tracker::restore(&kept.save().unwrap()).unwrap();
    assert_eq!(smoothed(&kept), smoothed(&again));
    let mut plain = tracker(figure(&FREE), method(layer(&ALL, &[CueName::Keypoints], SUM), 0.0), 1).unwrap();
    update(&mut plain, 0.0, &seen_at(0.0)).unwrap();
    assert!(smoothed(&plain).is_empty());
}

#[test]
fn ranges_are_checked() {
    let bad = smoothed_by(Momentum { lasts_s: 0.0, ..MOMENTUM });
    assert!(matches!(tracker(figure(&FREE), bad, 1), Err(Error::Parameter { name: "velocity_lasts_s", .. })));
}
