//! Limbs mirrored in the picture's plane: of the ways to look alike, the one that explains a whole recording best.
//!
//! A limb that leans towards the camera looks like one that leans away by as much. Only while it lies in the picture's plane
//! can it have gone from one to the other: a trajectory is cut there, and between two cuts an upper arm, a forearm or both
//! are mirrored, drawn there, let go, and kept where that explains more ("kinematic jumps": Sminchisescu & Triggs, CVPR
//! 2003). Those that explain less stay possible: that tells little of which way it was.

use super::joints::KEY_JOINTS;
use super::trajectory::{Pulls, Trajectory};
use crate::filter::{Chain, Gaussian, settle};
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

/// Where the key joints are.
pub(super) type Places = [Vector3<f64>; KEY_JOINTS.len()];

/// Shoulder, elbow and wrist of either arm among the points of the figure.
const ARMS: [[usize; 3]; 2] = [[2, 4, 6], [3, 5, 7]];
/// Sine of the angle out of the picture's plane below which a limb may pass through it; above which it is worth mirroring.
const IN_PLANE: f64 = 0.4;
const LEANING: f64 = 0.15;
/// A cut is where it lies nearest to the plane within so many seconds.
const NEAREST_S: f64 = 0.1;
/// How much about a stretch is smoothed with it, s.
const ABOUT_S: f64 = 0.35;
/// How far off its ends may be from the trajectory that they join: channels, m or rad, and velocities.
const JOIN: f64 = 0.02;
const JOIN_VELOCITY: f64 = 0.3;
/// Turns while it is pulled, and after it was let go: some, and more where there is hope.
const PULLED_TURNS: usize = 4;
const FREE_TURNS: [usize; 2] = [4, 4];
const HOPELESS: f64 = -120.0;
/// Turns of the whole after a sweep.
const RELAXED_TURNS: usize = 3;
/// That is enough, in standard deviations.
const ABOUT: f64 = 0.1;
/// By how much minus twice the log posterior must fall: what is as likely either way stays as it is.
const GAIN: f64 = 1.0;
/// How often what explains more may take the place of what is there.
const SWEEPS: usize = 6;
/// A stretch mirrored that explains as much weighs so much against what is there; what it explains less is divided by how many frames'
/// errors are alike once more. On clips of people and on captured exercises, where some 20 are, it was nearer to the truth in 30 to
/// 45 % of the frames, whether it explained less by 1 or by 30: what a detector is off by as long explains as much.
const OTHER: f64 = 0.5;

/// What of an arm is mirrored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mirrored {
    UpperArm,
    Forearm,
    Both,
}

/// A stretch of an arm, mirrored.
struct Candidate {
    arm: [usize; 3],
    mirrored: Mirrored,
    frames: [usize; 2],
}

/// Whether a stretch shares a frame with any of some.
fn overlaps(frames: &[usize; 2], some: &[[usize; 2]]) -> bool {
    some.iter().any(|other| frames[0] < other[1] && other[0] < frames[1])
}

/// A candidate, settled: by how much it explains more, from which frame on, and the states there.
struct Tried {
    gain: f64,
    first: usize,
    states: Vec<DVector<f64>>,
}

/// Another way over a stretch.
pub(super) struct Other {
    /// Against that of the way that it would replace.
    pub weight: f64,
    /// Its first frame.
    pub first: usize,
    /// One a frame.
    pub states: Vec<DVector<f64>>,
}

impl Tried {
    fn frames(&self) -> [usize; 2] {
        [self.first, self.first + self.states.len()]
    }

    fn other(self, alike: f64) -> Other {
        let Self { gain, first, states } = self;
        Other { weight: OTHER * (0.5 * gain.min(0.0) / alike).exp(), first, states }
    }
}

impl Trajectory<'_> {
    /// `at` with limbs mirrored wherever that explains more, so many frames' errors being alike; and where they may as well be.
    pub(super) fn mirrored(&self, mut at: Vec<DVector<f64>>, alike: f64) -> (Vec<DVector<f64>>, Vec<Other>) {
        let (mut changed, mut others) = (vec![[0, at.len()]], Vec::<Tried>::new());
        for sweep in 0..=SWEEPS {
            let places: Vec<Places> = at.iter().map(|state| self.places(state)).collect();
            let mut candidates = self.candidates(&places);
            // Where nothing has changed it has been tried.
            candidates.retain(|candidate| overlaps(&self.window(candidate, at.len()), &changed));
            others.retain(|other| !overlaps(&other.frames(), &changed));
            let mut tried: Vec<Tried> =
                candidates.par_iter().filter_map(|candidate| self.tried(candidate, &at, &places, alike)).collect();
            tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            changed.clear();
            for tried in tried {
                let frames = tried.frames();
                // Others that overlap it were tried against what it replaces. The last sweep is for what else may be.
                if sweep < SWEEPS && tried.gain > GAIN && !overlaps(&frames, &changed) {
                    changed.push(frames);
                    at.splice(frames[0]..frames[1], tried.states);
                } else {
                    others.push(tried);
                }
            }
            if changed.is_empty() {
                break;
            }
            if let Ok(relaxed) = settle(self, at.clone(), RELAXED_TURNS, ABOUT) {
                at = relaxed.at;
            }
        }
        (at, others.into_iter().map(|one| one.other(alike)).collect())
    }

    /// Stretches between frames at which a limb may have passed through the picture's plane.
    fn candidates(&self, places: &[Places]) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        for arm in ARMS {
            for (mirrored, from, to) in
                [(Mirrored::UpperArm, 0, 1), (Mirrored::Forearm, 1, 2), (Mirrored::Both, 0, 1), (Mirrored::Both, 1, 2)]
            {
                let lean: Vec<f64> = places.iter().map(|place| self.lean(place[arm[from]], place[arm[to]])).collect();
                for frames in self.between_cuts(&lean) {
                    let most = lean[frames[0]..frames[1]].iter().fold(0.0, |most: f64, lean| most.max(lean.abs()));
                    if most > LEANING {
                        candidates.push(Candidate { arm, mirrored, frames });
                    }
                }
            }
        }
        candidates
    }

    /// Sine of the angle between a limb and the picture's plane.
    fn lean(&self, near: Vector3<f64>, far: Vector3<f64>) -> f64 {
        let limb = (far - near).try_normalize(1e-9).unwrap_or_default();
        limb.dot(&self.body.projection.viewing_direction(near))
    }

    /// Frames from one cut to the next.
    fn between_cuts(&self, lean: &[f64]) -> Vec<[usize; 2]> {
        let is_nearest = |k: usize| {
            let near = |j: &usize| (self.time_s(*j) - self.time_s(k)).abs() <= NEAREST_S;
            let before = (0..k).rev().take_while(near).all(|j| lean[j].abs() > lean[k].abs());
            before && (k + 1..lean.len()).take_while(near).all(|j| lean[j].abs() >= lean[k].abs())
        };
        let mut cuts: Vec<usize> = (1..lean.len()).filter(|k| lean[*k].abs() < IN_PLANE && is_nearest(*k)).collect();
        cuts.push(lean.len());
        let starts = std::iter::once(0).chain(cuts.clone());
        starts.zip(cuts.clone()).map(|(first, end)| [first, end]).filter(|[first, end]| end > first).collect()
    }

    /// A candidate pulled there, let go, and smoothed where it stays; none where that explains far less.
    fn tried(&self, candidate: &Candidate, at: &[DVector<f64>], places: &[Places], alike: f64) -> Option<Tried> {
        let [first, end] = candidate.frames;
        let [from, to] = self.window(candidate, at.len());
        let pulls = (first..end).flat_map(|frame| self.pull(candidate, &places[frame], frame - from)).collect();
        let pulled = settle(&self.part(from, to, at, pulls), at[from..to].to_vec(), PULLED_TURNS, ABOUT).ok()?;
        let free = self.part(from, to, at, Pulls::new());
        let before = free.implausibility(&at[from..to], alike).ok()?;
        let mut states = pulled.at;
        let mut gain = f64::NEG_INFINITY;
        for turns in FREE_TURNS {
            states = settle(&free, states, turns, ABOUT).ok()?.at;
            gain = before - free.implausibility(&states, alike).ok()?;
            if gain < HOPELESS {
                return None;
            }
        }
        Some(Tried { gain, first: from, states })
    }

    /// The frames that are smoothed with it, of so many.
    fn window(&self, candidate: &Candidate, count: usize) -> [usize; 2] {
        let [first, end] = candidate.frames;
        let (from_s, to_s) = (self.time_s(first) - ABOUT_S, self.time_s(end - 1) + ABOUT_S);
        let from = (0..first).find(|k| self.time_s(*k) >= from_s).unwrap_or(first);
        [from, (end..count).find(|k| self.time_s(*k) > to_s).unwrap_or(count)]
    }

    /// Where elbow and wrist would be.
    fn pull(&self, candidate: &Candidate, places: &Places, step: usize) -> Pulls {
        let [shoulder, elbow, wrist] = candidate.arm;
        let away = self.body.projection.viewing_direction(places[shoulder]);
        let mirror = |limb: Vector3<f64>, is: bool| if is { limb - 2.0 * limb.dot(&away) * away } else { limb };
        let upper = mirror(places[elbow] - places[shoulder], candidate.mirrored != Mirrored::Forearm);
        let lower = mirror(places[wrist] - places[elbow], candidate.mirrored != Mirrored::UpperArm);
        let at = places[shoulder] + upper;
        vec![(step, elbow, at), (step, wrist, at + lower)]
    }

    /// A part of it that joins the rest.
    fn part(&self, from: usize, to: usize, at: &[DVector<f64>], pulls: Pulls) -> Trajectory<'_> {
        let join = |state: &DVector<f64>| {
            let count = state.len() / 2;
            let sd = DVector::from_fn(state.len(), |d, _| if d < count { JOIN } else { JOIN_VELOCITY });
            Gaussian { mean: state.clone(), covariance: DMatrix::from_diagonal(&sd.component_mul(&sd)) }
        };
        let start = if from == 0 { self.start.clone() } else { join(&at[from]) };
        let end = if to == at.len() { self.end.clone() } else { Some(join(&at[to - 1])) };
        Trajectory { body: self.body, frames: &self.frames[from..to], start, end, pulls }
    }
}
