//! One recording of an arm as a chain of states that is smoothed ([`crate::arm::smooth`]).

use crate::Result;
use crate::arm::cues::landmark::Landmark;
use crate::arm::cues::upper_arm::Direction;
use crate::arm::cues::{Cue, CueName, robust};
use crate::arm::frame::Frame;
use crate::arm::mixture::ArmMixture;
use crate::arm::posed::{Moment, Posed, sightings};
use crate::arm::state::{Arm, Layout, Noise, View};
use crate::arm::worn::Moved;
use crate::filter::{Chain, Gaussian, Linear, LinearTransition, Settled, Spread, settle};
use crate::quaternion::Quaternion;
use nalgebra::{DVector, Vector2};

/// How often the recording is linearised again, and when that is enough, in standard deviations.
const TURNS: usize = 8;
const SETTLED: f64 = 0.1;

/// A frame as it is smoothed: seen at some delay.
pub(super) struct Step<'a> {
    /// Recording time, s.
    pub time_s: f64,
    /// Motion since the frame before.
    pub moved: Moved,
    /// Spread that it gives to the columns that it mixes, factored once for all passes.
    pub spread: Spread,
    /// Orientation when it was seen.
    pub world_sensor: Quaternion,
    /// For how long nothing had said how the sensor is oriented, s.
    pub stale_s: f64,
    /// Where the wrist rests: by how much it trembles, standard deviation of its velocity, m/s per axis.
    pub rest: Option<f64>,
    /// Whether it says something new.
    pub is_new: bool,
    /// Where each camera saw the patch.
    pub pixels: &'a [Option<Vector2<f64>>],
    /// Which joints were seen besides, and where.
    pub landmarks: &'a [Landmark],
    /// Where the upper arm points, by its sensor.
    pub upper_arm: Option<Direction>,
    /// What was known beforehand, where the chain starts here.
    pub start: Option<Gaussian>,
    /// The mixture's mean, and that of its heaviest component.
    pub means: [DVector<f64>; 2],
}

/// A recording with all that bends it known.
pub(super) struct ArmBranch<'a> {
    pub arm: &'a Arm,
    pub noise: &'a Noise,
    pub views: &'a [View],
    pub filter: &'a ArmMixture,
    pub steps: &'a [Step<'a>],
}

impl ArmBranch<'_> {
    /// Where a trajectory settles.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], [`crate::Error::RanAway`].
    pub fn settled(&self, start: Vec<DVector<f64>>) -> Result<Settled> {
        settle(self, start, TURNS, SETTLED)
    }

    /// What the IMU says at every step.
    pub fn moments(&self) -> Vec<Moment> {
        (0..self.steps.len()).map(|step| self.frame(step).moment()).collect()
    }

    /// How well a trajectory of some cost explains what was measured and how it moves: by prior and likelihood, all of what is known
    /// beforehand told once ([`crate::arm::cues::told_once`]).
    ///
    /// # Errors
    /// As [`crate::arm::cues::Cue::linearise`].
    pub fn log_fit(&self, at: &[DVector<f64>], cost: f64) -> Result<f64> {
        let layout = Layout::new(self.noise);
        let mut widths = 0.0;
        for (step, state) in at.iter().enumerate().filter(|(step, _)| self.steps[*step].is_new) {
            let frame = self.frame(step);
            let posed = Posed::new(layout, self.arm, self.noise, frame.moment());
            for cue in self.cues(&frame, layout).filter(|cue| !cue.is_seen()) {
                let noise = cue.linearise(&posed, state, None)?.map(|(_, _, noise)| noise);
                widths += noise.map_or(0.0, |noise| noise.diagonal().iter().map(|variance| variance.ln()).sum());
            }
        }
        Ok(-0.5 * (cost - widths))
    }

    /// What the filter is corrected by, and rest.
    fn cues<'f>(&'f self, frame: &'f Frame<'f>, layout: Layout) -> impl Iterator<Item = Box<dyn Cue + 'f>> {
        let rest = (!self.filter.cues().contains(&CueName::Rest)).then_some(CueName::Rest);
        let names = self.filter.cues().iter().copied().chain(rest);
        names.flat_map(move |name| frame.cues(name, layout, self.noise))
    }

    fn frame(&self, step: usize) -> Frame<'_> {
        let Step { time_s, world_sensor, stale_s, rest, pixels, landmarks, upper_arm, .. } = self.steps[step];
        let landmarks = landmarks.iter().map(|landmark| landmark.seen_by(self.views)).collect();
        let sightings = sightings(self.views, pixels);
        Frame { stale_s, rest, sightings, landmarks, upper_arm, ..Frame::empty(time_s, world_sensor) }
    }
}

impl Chain for ArmBranch<'_> {
    fn len(&self) -> usize {
        self.steps.len()
    }

    fn time_s(&self, step: usize) -> f64 {
        self.steps[step].time_s
    }

    fn start(&self, step: usize) -> Option<Gaussian> {
        self.steps[step].start.clone()
    }

    fn predict(&self, step: usize, state: &mut Gaussian) {
        self.steps[step].moved.predict(state);
    }

    fn transition(&self, step: usize) -> LinearTransition {
        self.steps[step].moved.transition()
    }

    fn surprise(&self, step: usize, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
        let Step { moved, spread, .. } = &self.steps[step];
        moved.surprise(spread, from, to)
    }

    fn measure(&self, step: usize, at: &DVector<f64>) -> Result<Vec<Linear>> {
        if !self.steps[step].is_new {
            return Ok(Vec::new());
        }
        let frame = self.frame(step);
        let layout = Layout::new(self.noise);
        let posed = Posed::new(layout, self.arm, self.noise, frame.moment());
        // A trajectory is one place at a time: nothing bends over its spread.
        let mut measured = Vec::with_capacity(4);
        for cue in self.cues(&frame, layout) {
            measured.extend(robust(&*cue, &posed, at, None)?);
        }
        Ok(measured)
    }
}
