//! The body over a whole recording: the particles' track, smoothed.
//!
//! Not in the paper. Joints that a detector saw, or the particles where there was none, orientations of sensors, effort and the
//! limits of joints are what the trajectory must explain, with velocities ([`super::momentum`]) between the frames. It is started
//! from the particles' track and from the first pose held; from either limbs are mirrored ([`super::mirrored`]), and both are weighed,
//! with the ways in which limbs may as well have gone.
//! It is averaged with what a filter says of the same frames: where a detector saw the joints a mixture ([`super::mixture`]), else
//! the particles.

use super::cues::Picture;
use super::cues::keypoints::{Keypoint, Person};
use super::figure::Figure;
use super::gaussians::Posing;
use super::joints::KEY_JOINTS;
use super::method::BodyMethod;
use super::mirrored::{Other, Places};
use super::mixture::BodyMixture;
use super::momentum::{Momentum, Moving};
use super::trajectory::{Body, Kept, Outlined, Pulls, Trajectory};
use super::unseen::Known;
use crate::Result;
use crate::averaged::{FILTERED, steadied};
use crate::error::successes;
use crate::estimate::Point;
use crate::filter::{Gaussian, settle, smooth};
use crate::particles::Summary;
use crate::projection::Projection;
use crate::smoothing::{Window, Windowed};
use nalgebra::{DVector, Matrix3, Vector3};
use rayon::prelude::*;
use std::ops::Range;

/// How often a stretch is linearised again, and when that is enough, in standard deviations.
const TURNS: usize = 20;
const SETTLED: f64 = 0.05;
/// Where a stretch begins amid a recording it is known so many times worse than at the first frame.
const AMID: f64 = 3.0;
/// How long a posture lasts, s: as often what speaks against it is said anew.
const POSTURE_S: f64 = 2.0;
/// Limbs are mirrored in frames so far apart, s.
const STEP_S: f64 = 0.03;
/// A branch of less weight is left out.
const LEAST: f64 = 1e-3;
/// How many components the mixture keeps.
const COMPONENTS: usize = 12;
/// The particles' share where no detector saw the joints (on clips of people 0.3 to 0.7 are alike, of what is simulated less is
/// better).
const BY_PARTICLES: f64 = 0.5;

/// Weighted Gaussians of a frame.
type Components = Vec<(f64, Gaussian)>;

/// A way in which the recording may have been, smoothed.
struct Branch {
    states: Vec<Gaussian>,
    /// Of every frame, where limbs may as well be: weights against that of its state.
    others: Vec<Components>,
    cost: f64,
    weight: f64,
}

impl Branch {
    /// All that it says of a frame, its own state first.
    fn parts(&self, frame: usize) -> impl Iterator<Item = (f64, &Gaussian)> {
        let others = &self.others[frame];
        let share = self.weight / (1.0 + others.iter().map(|(weight, _)| weight).sum::<f64>());
        let others = others.iter().map(move |(weight, state)| (share * weight, state));
        std::iter::once((share, &self.states[frame])).chain(others)
    }
}

/// A recording of a body that particles have been through.
#[derive(Clone, Copy)]
pub(super) struct Recorded<'a> {
    pub figure: &'a Figure,
    pub projection: &'a Projection,
    pub method: &'a BodyMethod,
    pub momentum: &'a Momentum,
    pub frames: &'a [Kept],
}

/// Where particles see the key joints, as a detector would; they know nothing of hips.
pub(super) fn seen_by_particles(projection: &Projection, joints: &Summary) -> Person {
    let keypoint = |k: usize| {
        let first = 3 * (k + 1);
        let at: Vector3<f64> = joints.mean.fixed_rows::<3>(first).into();
        let spread: Matrix3<f64> = joints.covariance.fixed_view::<3, 3>(first, first).into();
        let (seen, away) = (projection.see(at.into()), projection.viewing_direction(at));
        let across = (0.5 * (spread.trace() - away.dot(&(spread * away)))).max(0.0).sqrt();
        seen.px_per_m.is_finite().then_some(Keypoint { pixel: [seen.u, seen.v], sd_px: across * seen.px_per_m })
    };
    std::array::from_fn(|k| if k + 1 < KEY_JOINTS.len() { keypoint(k) } else { None })
}

impl Recorded<'_> {
    /// The frames from `first` on, as many as are smoothed together, each given all about it; none beyond the last.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], [`crate::Error::RanAway`] where no trajectory is found.
    pub fn window(&self, first: usize) -> Result<Windowed> {
        let count = self.frames.len();
        if first >= count {
            return Ok(Windowed::default());
        }
        let Window { end, until, seen: [from, to], .. } = Window::new(first, count);
        let (branches, filtered) = self.branches(from, to)?;
        let posing = Posing { figure: self.figure, projection: self.projection, unseen: &self.method.unseen };
        let root_m = self.figure.root_height_m();
        let of_frame = |(frame, of): (usize, &Kept)| {
            let ways: Vec<_> = branches.iter().flat_map(|branch| branch.parts(frame)).collect();
            let (since_s, by_outlines) = (of.time_s - self.frames[0].time_s, of.outlined.is_some());
            let known = Known { since_s, by_outlines, root_m };
            let share = if known.by_outlines { BY_PARTICLES } else { FILTERED };
            let filtered = filtered[frame].iter().map(|(weight, state)| (share * weight, state));
            let both: Vec<_> =
                ways.iter().map(|(weight, state)| ((1.0 - share) * weight, *state)).chain(filtered).collect();
            let estimate = |parts| posing.estimate(of.time_s, known, parts, of.blobs);
            let (alone, mut both) = (estimate(&ways), estimate(&both));
            if let Some(of) = &of.outlined {
                // Between particles there is no pose: the mean of their joints is none of a pose's.
                let each = alone.places.iter().zip(&of.places);
                let together = |(a, b): (&Point, &Point)| Point {
                    mode: a.mode,
                    ..Point::together(&[(1.0 - share, a), (share, b)])
                };
                both.places = each.map(together).collect();
            }
            [alone, both]
        };
        let found: Vec<_> = self.frames[from..to].iter().enumerate().map(of_frame).collect();
        let of_frames = |frames: Range<usize>| {
            frames.map(|frame| steadied(&found, frame - from).checked()).collect::<Result<Vec<_>>>()
        };
        Ok(Windowed { own: of_frames(first..end)?, beyond: of_frames(end..until)? })
    }

    /// One window: every branch, with its weight, the heaviest first; and what a filter that forgets says of every frame.
    fn branches(&self, from: usize, to: usize) -> Result<(Vec<Branch>, Vec<Components>)> {
        let moving = self.momentum.of(self.figure);
        let frames = &self.frames[from..to];
        let pose = self.figure.model.start();
        let start = if from == 0 { moving.start(&pose, 1.0) } else { moving.start(&frames[0].mean, AMID) };
        let every_s = (frames[frames.len() - 1].time_s - frames[0].time_s) / frames.len() as f64;
        let method = self.method.for_postures(every_s, POSTURE_S);
        let layer = Body::whole(&method);
        let body =
            Body { figure: self.figure, projection: self.projection, method: &method, layer: &layer, moving: &moving };
        let fleeting = self.method.for_postures(every_s, self.momentum.lasts_s);
        let filtered = self.filtered(Body { method: &fleeting, ..body }, frames, &start)?;
        let trajectory = |frames| Trajectory { body, frames, start: start.clone(), end: None, pulls: Pulls::new() };
        // Ways that limbs may have gone are told apart by few frames as well as by many.
        let few = few(frames);
        let (sketch, whole) = (trajectory(&few), trajectory(frames));
        let held = (from == 0).then(|| vec![start.mean.clone(); few.len()]);
        let starts: Vec<_> = std::iter::once(along(&few, &moving)).chain(held).collect();
        let found = successes(starts.into_par_iter().map(|start| sketch.settled(start)).collect())?;
        let alike = found.iter().map(|at| sketch.alike(at)).fold(1.0, f64::max);
        let branch = |at| whole.branch(&few, sketch.mirrored(at, alike), alike);
        let mut branches = successes(found.into_par_iter().map(branch).collect())?;
        branches.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let least = branches[0].cost;
        for branch in &mut branches {
            branch.weight = (0.5 * (least - branch.cost)).exp();
        }
        let sum: f64 = branches.iter().map(|branch| branch.weight).sum();
        for branch in &mut branches {
            branch.weight /= sum;
        }
        // The heaviest stays, whatever it weighs.
        let heavy = branches.iter().take_while(|branch| branch.weight > LEAST).count();
        branches.truncate(heavy.max(1));
        Ok((branches, filtered))
    }

    /// What a filter says of every frame by those before it: the particles where they alone saw it, else a mixture.
    fn filtered(&self, body: Body<'_>, frames: &[Kept], start: &Gaussian) -> Result<Vec<Components>> {
        let mut mixture = BodyMixture::about(start.clone(), *self.momentum, COMPONENTS);
        let mut last_s = frames[0].time_s;
        let nothing = Picture::default();
        let update = |kept: &Kept| {
            if let Some(Outlined { covariance, .. }) = &kept.outlined {
                return Ok(vec![(1.0, body.moving.still(&kept.mean, covariance))]);
            }
            mixture.predict(body.moving, kept.time_s - last_s);
            last_s = kept.time_s;
            mixture.correct(body, &body.frame(kept, &nothing), kept.time_s)?;
            Ok(mixture.parts().into_iter().map(|(weight, state)| (weight, state.clone())).collect())
        };
        frames.iter().map(update).collect()
    }
}

impl Trajectory<'_> {
    /// Where a state has the key joints.
    pub(super) fn places(&self, state: &DVector<f64>) -> Places {
        let sloped = self.body.sloped(state);
        std::array::from_fn(|joint| sloped.at(joint))
    }

    /// The nearest trajectory that explains most.
    fn settled(&self, start: Vec<DVector<f64>>) -> Result<Vec<DVector<f64>>> {
        Ok(settle(self, start, TURNS, SETTLED)?.at)
    }

    /// From the states at a few of its frames, and where limbs may as well be in those; so many of them are alike.
    fn branch(&self, few: &[Kept], (at, others): (Vec<DVector<f64>>, Vec<Other>), alike: f64) -> Result<Branch> {
        let found = settle(self, between(few, &at, self.frames), TURNS, SETTLED)?.at;
        let states = smooth(self, found)?.states;
        let means: Vec<_> = states.iter().map(|state| state.mean.clone()).collect();
        let cost = self.implausibility(&means, alike * self.frames.len() as f64 / few.len() as f64)?;
        let others = at_frames(others, few, self.frames, &states);
        Ok(Branch { states, others, cost, weight: 1.0 })
    }
}

/// Other ways over stretches of a few frames, frame by frame of all, as well known as the states there.
fn at_frames(others: Vec<Other>, few: &[Kept], frames: &[Kept], states: &[Gaussian]) -> Vec<Components> {
    let mut found: Vec<Components> = vec![Vec::new(); frames.len()];
    for Other { weight, first, states: other } in others {
        let known = &few[first..first + other.len()];
        let from = frames.partition_point(|frame| frame.time_s < known[0].time_s);
        let to = frames.partition_point(|frame| frame.time_s <= known[known.len() - 1].time_s);
        for (k, mean) in (from..to).zip(between(known, &other, &frames[from..to])) {
            found[k].push((weight, Gaussian { mean, covariance: states[k].covariance.clone() }));
        }
    }
    found
}

/// The first frame, and every one that follows the last taken by long enough.
fn few(frames: &[Kept]) -> Vec<Kept> {
    let mut few: Vec<Kept> = Vec::new();
    for frame in frames {
        if few.last().is_none_or(|last| frame.time_s - last.time_s >= STEP_S) {
            few.push(frame.clone());
        }
    }
    few
}

/// The states of all frames between those of a few.
fn between(few: &[Kept], at: &[DVector<f64>], frames: &[Kept]) -> Vec<DVector<f64>> {
    let state = |frame: &Kept| {
        let next = few.partition_point(|known| known.time_s <= frame.time_s).clamp(1, few.len());
        if next == few.len() {
            return at[next - 1].clone();
        }
        let (before, after) = (few[next - 1].time_s, few[next].time_s);
        at[next - 1].lerp(&at[next], (frame.time_s - before) / (after - before))
    };
    frames.iter().map(state).collect()
}

/// The particles' track, with the velocities that it has.
fn along(frames: &[Kept], moving: &Moving) -> Vec<DVector<f64>> {
    let state = |k: usize| {
        let (before, after) = (&frames[k.saturating_sub(1)], &frames[(k + 1).min(frames.len() - 1)]);
        let elapsed_s = (after.time_s - before.time_s).max(f64::MIN_POSITIVE);
        let count = frames[k].mean.len();
        DVector::from_fn(moving.dim(), |d, _| {
            if d < count { frames[k].mean[d] } else { (after.mean[d - count] - before.mean[d - count]) / elapsed_s }
        })
    };
    (0..frames.len()).map(state).collect()
}
