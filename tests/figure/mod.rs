//! A figure of a few bones, and a tracker of it, for the tests of the body.
#![allow(dead_code)] // each test uses some of it

use nalgebra::{Matrix3, Vector3};
use pytracker::body::cues::CueParameters;
use pytracker::body::cues::blobs::BlobParameters;
use pytracker::body::cues::effort::EffortParameters;
use pytracker::body::cues::keypoints::KeypointParameters;
use pytracker::body::cues::orientation::OrientationParameters;
use pytracker::body::cues::outline::OutlineParameters;
use pytracker::body::cues::posture::PostureParameters;
use pytracker::body::cues::region::RegionParameters;
use pytracker::body::edges::EdgeImage;
use pytracker::body::{
    Blend, BodyFilter, BodyLayer, BodyMethod, CueName, Diffusion, Figure, FilterMethod, Group, Mover, Part,
    ParticleMethod, Picture, Unseen,
};
use pytracker::filter::Resampling;
use pytracker::projection::Projection;
use pytracker::resample::Scheme;
use pytracker::skeleton::{Bone, Channel, Skeleton};
use pytracker::{Estimate, Observation, Result, Tracker};
use std::sync::Arc;

pub const KEYPOINT_PARAMETERS: KeypointParameters = KeypointParameters { inflation: 1.0, reach: 4.0 };

/// Arms stretched out to the sides, 0.3 m and 0.25 m long; turning a shoulder about z lifts the left arm.
fn skeleton(elbow: Matrix3<f64>) -> Skeleton {
    let all = [0, 1, 2].map(Channel::Rotation).to_vec();
    let mut bones: Vec<Bone> = Vec::new();
    let mut add = |name: &str, parent: Option<usize>, reach: [f64; 3], channels: &[Channel]| {
        let (frame, order) = (if name.ends_with("radius") { elbow } else { Matrix3::identity() }, [0, 1, 2]);
        let reach = Vector3::from(reach);
        bones.push(Bone { name: name.into(), parent, reach, frame, order, channels: channels.to_vec() });
        bones.len() - 1
    };
    let root = [[0, 1, 2].map(Channel::Translation).to_vec(), all.clone()].concat();
    let root = add("root", None, [0.0; 3], &root);
    let thorax = add("thorax", Some(root), [0.0, 0.4, 0.0], &[]);
    let neck = add("upperneck", Some(thorax), [0.0, 0.15, 0.0], &[]);
    add("head", Some(neck), [0.0, 0.15, 0.0], &[]);
    for (side, x) in [("l", 1.0), ("r", -1.0)] {
        let clavicle = add(&format!("{side}clavicle"), Some(thorax), [0.18 * x, 0.05, 0.0], &[]);
        let humerus = add(&format!("{side}humerus"), Some(clavicle), [0.3 * x, 0.0, 0.0], &all);
        let radius = add(&format!("{side}radius"), Some(humerus), [0.15 * x, 0.0, 0.0], &all[..1]);
        let wrist = add(&format!("{side}wrist"), Some(radius), [0.1 * x, 0.0, 0.0], &[]);
        add(&format!("{side}hand"), Some(wrist), [0.1 * x, 0.0, 0.0], &[]);
    }
    Skeleton::new(bones).unwrap()
}

/// The left shoulder's rz is limited to ±1 rad.
pub fn figure(free: &[usize]) -> Figure {
    figure_from(free, 0, 0.0)
}

/// The same with elbows that bend about y, across the arm.
pub fn figure_bending(free: &[usize]) -> Figure {
    made(free, 0, 0.0, Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0))
}

/// The same, one channel of its first pose being something.
pub fn figure_from(free: &[usize], channel: usize, value: f64) -> Figure {
    made(free, channel, value, Matrix3::identity())
}

fn made(free: &[usize], channel: usize, value: f64, elbow: Matrix3<f64>) -> Figure {
    let skeleton = skeleton(elbow);
    let channels = skeleton.channels().count();
    let mut pose = vec![0.0; channels];
    pose[channel] = value;
    let mut limits = vec![[f64::NEG_INFINITY, f64::INFINITY]; channels];
    limits[8] = [-1.0, 1.0];
    let part = |start: (&str, f64), end: (&str, f64), w: f64| Part {
        start: (start.0.into(), start.1),
        end: (end.0.into(), end.1),
        half_width_m: [w, w],
    };
    let parts = [
        part(("root", 0.0), ("thorax", 1.0), 0.16),
        part(("lhumerus", 0.0), ("lhumerus", 1.0), 0.05),
        part(("rhumerus", 0.0), ("rhumerus", 1.0), 0.05),
    ];
    Figure::new(&skeleton, &pose, free, &limits, &parts, &projection()).unwrap()
}

pub fn projection() -> Projection {
    Projection::weak([[100.0, 0.0, 0.0, 100.0], [0.0, -100.0, 0.0, 100.0]]).unwrap()
}

/// No edge anywhere.
pub fn blank() -> EdgeImage {
    EdgeImage::new(200, 160, &vec![0; 200 * 160]).unwrap()
}

pub fn tracker(figure: Figure, method: BodyMethod, seed: u64) -> Result<Tracker> {
    BodyFilter::new(figure, projection(), method, seed).map(Tracker::from)
}

pub fn update(tracker: &mut Tracker, time_s: f64, evidence: &Picture) -> Result<Estimate> {
    tracker
        .observe(Observation::picture(time_s, Arc::new(evidence.clone())))
        .map(|found| found.expect("an estimate of a frame"))
}

pub const ALL: [Group; 3] = [Group::Torso, Group::LeftArm, Group::RightArm];
pub const SUM: Blend = Blend::Sum { sharpness: 1.0 };

/// A layer at the whole diffusion.
pub fn layer(groups: &[Group], cues: &[CueName], blend: Blend) -> BodyLayer {
    BodyLayer { mover: Mover { groups: groups.to_vec(), spread: 1.0 }, cues: cues.to_vec(), blend }
}

pub fn particles() -> ParticleMethod {
    ParticleMethod {
        particles: 400,
        islands: 1,
        resampling: Resampling::new(Scheme::Systematic, 1.0).unwrap(),
        diffusion: Diffusion { base: 0.05, base_turn: 0.1, trunk: 0.5, joint: 0.7 },
        anew_share: 0.0,
        smoothing: None,
    }
}

pub fn method(layer: BodyLayer, edge_loss: f64) -> BodyMethod {
    BodyMethod {
        filter: FilterMethod::Particles(particles()),
        cue_parameters: CueParameters {
            outline: OutlineParameters { loss: edge_loss },
            blobs: BlobParameters { sd_m: 0.03, reach: 4.0, gate_m: 0.5 },
            regions: RegionParameters { skin_loss: 0.0, foreground_loss: 0.0, reach_m: 0.2 },
            keypoints: KEYPOINT_PARAMETERS,
            orientation: OrientationParameters { inflation: 1.0 },
            effort: EffortParameters { loss: 0.0 },
            posture: PostureParameters { weight: 0.0 },
        },
        balance: 0.0,
        unseen: Unseen { distance_m: 0.0, first_distance_m: 0.0, lean: 0.0, turn: 0.0, across_m: 0.0, bend: 0.0 },
        layers: vec![layer],
    }
}
