//! The body's cues and tracker on a figure of a few bones.

use nalgebra::{Matrix3, UnitQuaternion};
use pytracker::body::cues::blobs::{BlobDistance, Scale};
use pytracker::body::cues::effort::{Effort, EffortParameters};
use pytracker::body::cues::keypoints::{Keypoint, KeypointDistance, Person, nearest};
use pytracker::body::cues::limits::Limits;
use pytracker::body::cues::orientation::{Orientation, OrientationDistance, OrientationParameters, Segment};
use pytracker::body::cues::outline::Outline;
use pytracker::body::cues::penetration::Penetration;
use pytracker::body::cues::posture::{Posture, PostureParameters};
use pytracker::body::cues::region::{Region, RegionParameters, Regions};
use pytracker::body::weighing::{Cue, Weighing};
use pytracker::body::{BodyMethod, CueName, Figure, FilterMethod, Group, ParticleMethod, Picture};
use pytracker::filter::{Blend, Likelihood};
use pytracker::particles::ParticleSet;
use pytracker::{Error, Tracker};

mod figure;

use figure::{ALL, KEYPOINT_PARAMETERS, SUM, blank, figure, layer, method, particles, projection, tracker, update};

const CUES: [CueName; 3] = [CueName::Edges, CueName::Blobs, CueName::Limits];

/// What a cue takes from every particle of a state of some columns.
fn lost(figure: &Figure, rows: &[f64], cue: impl Cue) -> Vec<f64> {
    let set = ParticleSet::from_rows(figure.model.dim(), rows).unwrap();
    let blend = Blend::Sum { sharpness: 1.0 };
    let weighing = Weighing { figure, projection: &projection(), cues: vec![Box::new(cue)], bounds: vec![], blend };
    let mut out = vec![0.0; set.len()];
    weighing.log_likelihood(&set, &mut out);
    out.iter().map(|x| -x).collect()
}

/// Left hand at 0.18 + 0.3 + 0.25 + 0.06 m, 0.45 m up.
const LEFT_HAND: [f64; 2] = [179.0, 55.0];

#[test]
fn rescaled_distances_lie_between_nothing_and_one() {
    let figure = figure(&[8]);
    let projection = projection();
    let edges = blank();
    let weighing = |alpha, adapt| {
        let outline = Outline { edges: &edges, groups: &ALL, loss: 1.0 };
        let blobs = BlobDistance { blobs: [None, Some(LEFT_HAND), None], groups: &ALL, scale: Scale::Pixels };
        let cues: Vec<Box<dyn Cue + '_>> = vec![Box::new(outline), Box::new(blobs)];
        let blend = Blend::Rescaled { base: 1000.0, alpha, adapt };
        Weighing { figure: &figure, projection: &projection, cues, bounds: vec![], blend }
    };
    let set = ParticleSet::from_rows(1, &[0.0, 0.1, 0.4]).unwrap();
    let mut out = vec![0.0; 3];
    weighing(1.0, 0.0).log_likelihood(&set, &mut out);
    // All miss all edges alike: only the blob tells them apart, the best by nothing, the worst by ln A.
    assert!(out[0].abs() < 1e-9 && out[1] < out[0] && out[2] < out[1]);
    assert!((out[2] + 1000f64.ln()).abs() < 1e-9);
    // The cue that tells nothing loses its weight to the other.
    weighing(1.0, 1.0).log_likelihood(&set, &mut out);
    assert!((out[2] + 2.0 * 1000f64.ln()).abs() < 1e-9);
    assert!(!weighing(1.0, 0.0).has_evidence());
    // All equal: all weigh the same, whatever is seen.
    let same = ParticleSet::from_rows(1, &[0.3, 0.3, 0.3]).unwrap();
    weighing(1.0, 0.0).log_likelihood(&same, &mut out);
    assert!(out.iter().all(|x| *x == 0.0));
}

/// The left forearm and hand, lifted by 0.4 rad, as a mask: all `anywhere` is on it, or only they; and places on it.
fn lifted(anywhere: bool, points: bool) -> Region {
    let place = |along: f64| [118.0 + along * 0.4f64.cos(), 55.0 - along * 0.4f64.sin()];
    let all: Vec<[f64; 2]> = (30..=64).map(|along| place(f64::from(along))).collect();
    let distance = |k: usize| {
        let (u, v) = ((k % 200) as f64, (k / 200) as f64);
        let nearest = all.iter().map(|[x, y]| (u - x).hypot(v - y)).fold(f64::INFINITY, f64::min);
        if anywhere { 0.0 } else { (nearest - 4.0).max(0.0) as f32 }
    };
    // The other hand explains its own skin, whatever the arm does.
    let points = if points { all.clone() } else { vec![[22.0, 55.0]] };
    Region::new(200, 160, (0..200 * 160).map(distance).collect(), points).unwrap()
}

/// Each cue alone, and of each both directions alone, tells how far the arm is lifted.
#[test]
fn a_region_is_worn_and_covers_its_wearer() {
    let figure = figure(&[8]);
    let angles = [0.0, 0.2, 0.4, 0.6, 0.8];
    let lost = |skin_loss, foreground_loss, mask: &Region| {
        let parameters = RegionParameters { skin_loss, foreground_loss, reach_m: 0.5 };
        lost(
            &figure,
            &angles,
            Regions { skin: Some(mask), foreground: Some(mask), groups: &[Group::LeftArm], parameters, bare: 1.0 },
        )
    };
    for (skin_loss, foreground_loss) in [(30.0, 0.0), (0.0, 30.0)] {
        for mask in [lifted(false, false), lifted(true, true), lifted(false, true)] {
            let found = lost(skin_loss, foreground_loss, &mask);
            for other in [0, 1, 3, 4] {
                assert!(found[2] < found[other] - 0.2, "{skin_loss} {foreground_loss} {found:?}");
            }
        }
    }
    // No weight, no word.
    assert!(lost(0.0, 0.0, &lifted(false, true)).iter().all(|x| *x == 0.0));
    // All lost, and not more: what a mask counts, and a quarter of it for a limb beside it.
    let nowhere = Region::new(200, 160, vec![1e3; 200 * 160], vec![[0.0, 0.0]]).unwrap();
    assert!(lost(30.0, 0.0, &nowhere).iter().all(|x| (x - 37.5).abs() < 1e-9));
}

#[test]
fn a_fixed_scale_is_in_standard_deviations_and_ends() {
    let (figure, edges) = (figure(&[0]), blank());
    let states = [0.0, 0.05, 0.10, 5.0];
    // Three parts that miss everything, wherever they are.
    assert_eq!(lost(&figure, &states, Outline { edges: &edges, groups: &ALL, loss: 2.0 }), [6.0; 4]);
    let scale = Scale::Spread { sd_m: 0.05, reach: 4.0 };
    let found = lost(&figure, &states, BlobDistance { blobs: [None, Some(LEFT_HAND), None], groups: &ALL, scale });
    // 0, 1, 2 and at most 4 standard deviations.
    for (found, sd) in found.iter().zip([0.0, 1.0, 2.0, 4.0]) {
        assert!((found - 0.5 * sd * sd).abs() < 1e-9, "{found}");
    }
}

#[test]
fn limits_and_penetration_weigh_against_what_a_body_cannot_do() {
    let figure = figure(&[7, 8, 9]);
    let rows = [[0.0; 3], [0.0, 1.2, 0.0], [0.0, -2.0, 0.0]].concat();
    let limits = lost(&figure, &rows, Limits);
    // 0.2 rad beyond a limit is two of its standard deviations.
    assert!(limits[0] == 0.0 && (limits[1] - 2.0).abs() < 1e-9);
    // The upper arm turned inwards leads the elbow into the trunk.
    let inside = lost(&figure, &rows, Penetration);
    assert!(inside[0] == 0.0 && inside[1] == 0.0 && inside[2] > 1.0);
}

/// Hanging costs nothing, level all, overhead twice as much; and only of the arms that are asked.
#[test]
fn a_lifted_arm_costs_effort() {
    let figure = figure(&[8]);
    let quarter = std::f64::consts::FRAC_PI_2;
    let found = lost(
        &figure,
        &[-quarter, 0.0, quarter],
        Effort { groups: &[Group::LeftArm], parameters: EffortParameters { loss: 2.0 } },
    );
    for (found, expected) in found.iter().zip([0.0, 2.0, 4.0]) {
        assert!((found - expected).abs() < 1e-12, "{found}");
    }
    // The other arm stays level, whatever the left one does.
    let other = lost(
        &figure,
        &[-quarter, quarter],
        Effort { groups: &[Group::RightArm], parameters: EffortParameters { loss: 2.0 } },
    );
    assert!(other.iter().all(|x| (x - 2.0).abs() < 1e-12));
}

/// Arms are held before the body, not behind it: reaching forwards, out to the side, and backwards.
#[test]
fn people_reach_forwards() {
    let figure = figure(&[7]);
    let posture = |group: &'static [Group], weight| Posture { groups: group, parameters: PostureParameters { weight } };
    let found = lost(&figure, &[-1.2, 0.0, 1.2], posture(&[Group::LeftArm], 1.0));
    assert!(found.iter().all(|loss| *loss >= 0.0));
    assert!(found[0] + 0.5 < found[2] && found[1] + 0.5 < found[2], "{found:?}");
    // In proportion to its weight; and the other arm stays where it is.
    let half = lost(&figure, &[-1.2, 0.0, 1.2], posture(&[Group::LeftArm], 0.5));
    assert!(found.iter().zip(&half).all(|(whole, half)| (whole - 2.0 * half).abs() < 1e-12));
    let other = lost(&figure, &[-1.2, 0.0, 1.2], posture(&[Group::RightArm], 1.0));
    assert!(other.iter().all(|loss| (loss - other[0]).abs() < 1e-12));
}

/// Either arm is the other's mirror image, and a body that is turned and moved as a whole holds its arms as before.
#[test]
fn a_posture_is_seen_from_the_trunk() {
    let cue = |group: &'static [Group]| Posture { groups: group, parameters: PostureParameters { weight: 1.0 } };
    // Turns of the left shoulder, and those of the right one that mirror them.
    let (left, right) = (figure(&[6, 7, 8]), figure(&[10, 11, 12]));
    let of_left = lost(&left, &[0.3, -0.8, -0.5], cue(&[Group::LeftArm]));
    let of_right = lost(&right, &[0.3, 0.8, 0.5], cue(&[Group::RightArm]));
    assert!((of_left[0] - of_right[0]).abs() < 1e-9, "{of_left:?} {of_right:?}");
    let turned = lost(&figure(&[0, 3, 4, 5]), &[0.0, 0.0, 0.0, 0.0, 0.7, 0.4, -0.9, 0.3], cue(&ALL));
    assert!((turned[0] - turned[1]).abs() < 1e-9);
}

/// Points of the pose with every angle 0, 3 px off at most.
fn person(right_px: f64) -> Person {
    let at = |u: f64, v: f64| Some(Keypoint { pixel: [u + right_px, v], sd_px: 2.0 });
    let [shoulders, out] = [18.0, 48.0];
    let arms = [at(100.0 + out, 55.0), at(100.0 - out, 55.0), at(173.0, 55.0), at(27.0, 55.0)];
    let trunk = [at(100.0, 30.0), at(100.0 + shoulders, 55.0), at(100.0 - shoulders, 55.0)];
    std::array::from_fn(|k| trunk.iter().chain(&arms).nth(k).copied().flatten())
}

#[test]
fn a_wild_keypoint_says_nothing_and_the_nearest_person_is_followed() {
    let figure = figure(&[0]);
    let mut seen = person(0.0);
    let one = |person: &Person| {
        lost(
            &figure,
            &[0.0, 0.03, 0.06, 3.0],
            KeypointDistance { person, groups: &ALL, parameters: KEYPOINT_PARAMETERS },
        )
    };
    let found = one(&seen);
    assert!(found[0] < 1e-3 && found[1] > 0.5 && found[2] > found[1] && found[3] > found[2], "{found:?}");
    // Each at most reach²/2 and a little.
    assert!(found[3] <= 7.0 * (8.0 + 1e-3));
    // One of them anywhere costs every particle the same.
    seen[5] = Some(Keypoint { pixel: [20.0, 150.0], sd_px: 2.0 });
    let wild = one(&seen);
    assert!((wild[0] - found[0] - 8.0).abs() < 0.01);
    assert!(wild[1] - wild[0] > 0.8 * (found[1] - found[0]));
    // What is not seen says nothing at all; neither do the groups that are not asked.
    assert_eq!(one(&[None; 9]), [0.0; 4]);
    let arm = KeypointDistance { person: &seen, groups: &[Group::RightArm], parameters: KEYPOINT_PARAMETERS };
    assert!(lost(&figure, &[0.0], arm)[0] < 1e-3);
    let people = [person(60.0), person(4.0), person(-50.0)];
    let expected = figure.seen(&projection(), &[0.0]);
    assert_eq!(nearest(&people, &figure, &expected, KEYPOINT_PARAMETERS), Some(people[1]));
    // As it came, or with left and right as the figure has them.
    let mut mirrored = people[1];
    for [left, right] in [[1, 2], [3, 4], [5, 6], [7, 8]] {
        mirrored.swap(left, right);
    }
    assert_eq!(nearest(&[people[2], mirrored], &figure, &expected, KEYPOINT_PARAMETERS), Some(people[1]));
    // Hands that cross are not exchanged.
    let mut crossed = people[1];
    crossed.swap(5, 6);
    assert_eq!(nearest(&[crossed], &figure, &expected, KEYPOINT_PARAMETERS), Some(crossed));
    assert_eq!(nearest(&[person(900.0)], &figure, &expected, KEYPOINT_PARAMETERS), None);
    assert_eq!(nearest(&[], &figure, &expected, KEYPOINT_PARAMETERS), None);
}

#[test]
fn a_sensor_says_where_its_segment_points() {
    // Left shoulder about x, y, z.
    let figure = figure(&[6, 7, 8]);
    let measured = |segment: &str, turn: f64| {
        // Elbow to shoulder is -x here; as the bones of this figure lie the elbow's axis is along it too, and shows no roll.
        let frame = UnitQuaternion::from_matrix(&Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0));
        let q_world_segment = UnitQuaternion::from_euler_angles(0.0, 0.0, turn) * frame;
        let segment = Segment::from_name(segment).unwrap();
        Orientation { segment, q_world_segment, sd: 0.1, roll_sd: f64::INFINITY }
    };
    let cue = |orientations: &[Orientation], rows: &[f64]| {
        lost(
            &figure,
            rows,
            OrientationDistance { orientations, groups: &ALL, parameters: OrientationParameters { inflation: 1.0 } },
        )
    };
    for segment in ["left_upper_arm", "left_forearm"] {
        let found = cue(&[measured(segment, 0.3)], &[0.0, 0.0, 0.3, 0.0, 0.0, 0.1, 0.7, 0.0, 0.3]);
        assert!(found[0] < 1e-9 && (found[1] - 2.0).abs() < 1e-9 && found[2] < 1e-9, "{found:?}");
        // Far off it is as bad as any.
        assert!((cue(&[measured(segment, 2.0)], &[0.0; 3])[0] - 8.0).abs() < 1e-9);
    }
    assert!(Segment::from_name("left_leg").is_err());
}

#[test]
fn a_hand_is_followed_and_what_a_layer_does_not_move_stays() {
    let method = method(layer(&[Group::LeftArm], &CUES, SUM), 0.0);
    let mut tracker = tracker(figure(&[0, 1, 8, 12]), method, 3).unwrap();
    let mut estimate = None;
    for k in 0..30 {
        // The left arm goes up by 0.6 rad in a second.
        let lift = 0.02 * f64::from(k);
        let hand = [118.0 + 61.0 * lift.cos(), 55.0 - 61.0 * lift.sin()];
        let evidence = Picture { blobs: vec![hand], ..Picture::new(blank()) };
        estimate = Some(update(&mut tracker, f64::from(k) / 30.0, &evidence).unwrap());
    }
    let estimate = estimate.unwrap();
    assert!((estimate.state.mean[2] - 0.58).abs() < 0.08, "{}", estimate.state.mean);
    // The root and the right arm belong to no layer.
    assert_eq!([estimate.state.mean[0], estimate.state.mean[1], estimate.state.mean[3]], [0.0; 3]);
    assert_eq!(estimate.blobs[1].map(|_| ()), Some(()));
    assert!(matches!(update(&mut tracker, 0.5, &Picture::new(blank())), Err(Error::Late { what: "frame", .. })));
}

/// Islands are filters side by side: the first is what it would be alone, and together they have every particle.
#[test]
fn islands_are_filters_side_by_side() {
    let with = |islands: usize, count: usize| {
        let filter = FilterMethod::Particles(ParticleMethod { islands, particles: count, ..particles() });
        let method = BodyMethod { filter, ..method(layer(&ALL, &CUES, SUM), 1.0) };
        tracker(figure(&[0, 1, 8]), method, 5)
    };
    let (mut alone, mut three) = (with(1, 14).unwrap(), with(3, 40).unwrap());
    for k in 0..6 {
        let evidence = Picture { blobs: vec![LEFT_HAND], ..Picture::new(blank()) };
        update(&mut alone, f64::from(k) / 30.0, &evidence).unwrap();
        let estimate = update(&mut three, f64::from(k) / 30.0, &evidence).unwrap();
        assert!(estimate.ess.is_some_and(|ess| ess > 1.0 && ess <= 40.0));
    }
    let (first, all) = (alone.particles().unwrap(), three.particles().unwrap());
    assert_eq!((first.len(), all.len()), (14, 40));
    assert_eq!(first.rows(), all.rows()[..14 * first.dim()]);
    let mut again = Tracker::restore(&three.save().unwrap()).unwrap();
    let evidence = Picture { blobs: vec![LEFT_HAND], ..Picture::new(blank()) };
    assert_eq!(update(&mut three, 1.0, &evidence).unwrap(), update(&mut again, 1.0, &evidence).unwrap());
    assert!(matches!(with(0, 40), Err(Error::Parameter { name: "islands", .. })));
    assert!(matches!(with(41, 40), Err(Error::Parameter { name: "islands", .. })));
}

#[test]
fn a_saved_tracker_goes_on_with_the_same_bits() {
    let blend = Blend::Rescaled { base: 100.0, alpha: 1.0, adapt: 0.0 };
    let method = method(layer(&ALL, &[CueName::Edges, CueName::Blobs], blend), 0.0);
    let mut tracker = tracker(figure(&[0, 1, 8]), method, 5).unwrap();
    let evidence = Picture { blobs: vec![LEFT_HAND], ..Picture::new(blank()) };
    for k in 0..5 {
        update(&mut tracker, f64::from(k) / 30.0, &evidence).unwrap();
    }
    let mut again = Tracker::restore(&tracker.save().unwrap()).unwrap();
    for k in 5..10 {
        let (one, other) =
            (update(&mut tracker, f64::from(k) / 30.0, &evidence), update(&mut again, f64::from(k) / 30.0, &evidence));
        assert_eq!(one.unwrap(), other.unwrap());
    }
    assert!(Tracker::restore(&[1, 2, 3]).is_err());
}
