//! One recording of an arm as a chain of states that is smoothed ([`super::smooth`]).

use super::cues::landmark::Landmark;
use super::cues::robust;
use super::cues::upper_arm::Direction;
use super::frame::Frame;
use super::mixture::ArmMixture;
use super::posed::{Posed, sightings};
use super::state::{Arm, Layout, Noise, View};
use super::worn::{CORE, WornMotion};
use crate::Result;
use crate::estimate::Estimate;
use crate::filter::{Chain, Component, Gaussian, Linear, Settled, Smoothed, settle, smooth, surprise};
use crate::quaternion::Quaternion;
use nalgebra::{DMatrix, DVector, Vector2};

/// How often the recording is linearised again, and when that is enough, in standard deviations.
const TURNS: usize = 8;
const SETTLED: f64 = 0.1;

/// A frame as it is smoothed: seen at some delay.
pub(super) struct Step<'a> {
    /// Recording time, s.
    pub time_s: f64,
    /// Motion since the frame before.
    pub worn: WornMotion,
    /// Orientation when it was seen.
    pub world_sensor: Quaternion,
    /// For how long nothing had said how the sensor is oriented, s.
    pub stale_s: f64,
    /// Whether the sensor lay still.
    pub is_rest: bool,
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
    /// From a trajectory.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], [`crate::Error::RanAway`].
    pub fn smoothed(&self, start: Vec<DVector<f64>>) -> Result<Smoothed> {
        smooth(self, start, TURNS, SETTLED)
    }

    /// The trajectory alone.
    ///
    /// # Errors
    /// As [`Self::smoothed`].
    pub fn settled(&self, start: Vec<DVector<f64>>) -> Result<Settled> {
        settle(self, start, TURNS, SETTLED)
    }

    /// What a state says of the arm.
    pub fn estimate(&self, step: usize, state: &Gaussian) -> Estimate {
        let frame = self.frame(step);
        let posed = Posed::new(Layout::new(self.noise), self.arm, self.noise, frame.moment());
        let component = Component { gaussian: state.clone(), log_weight: 0.0 };
        self.filter.of_components(vec![component], &posed, frame.time_s)
    }

    fn frame(&self, step: usize) -> Frame<'_> {
        let Step { time_s, world_sensor, stale_s, is_rest, pixels, landmarks, upper_arm, .. } = self.steps[step];
        let landmarks = landmarks.iter().map(|landmark| landmark.seen_by(self.views)).collect();
        let sightings = sightings(self.views, pixels);
        Frame { stale_s, is_rest, sightings, landmarks, upper_arm, ..Frame::empty(time_s, world_sensor) }
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

    fn predict(&self, step: usize, state: &mut Gaussian) -> DMatrix<f64> {
        let (motion, dim) = (&self.steps[step].worn, state.mean.len());
        let others = Layout::new(self.noise).others(self.noise);
        motion.predict(&mut state.mean, &mut state.covariance, &others);
        let mut transition = DMatrix::identity(dim, dim);
        transition.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&motion.transition);
        for (column, width, process) in others {
            for d in column..column + width {
                transition[(d, d)] = process.step(motion.elapsed_s).0;
            }
        }
        transition
    }

    fn surprise(&self, step: usize, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
        let motion = &self.steps[step].worn;
        let core = to.fixed_rows::<CORE>(0) - (motion.transition * from.fixed_rows::<CORE>(0) + motion.input);
        let noise = DMatrix::from_column_slice(CORE, CORE, motion.noise.as_slice());
        let others = Layout::new(self.noise).others(self.noise);
        let each = others.iter().flat_map(|(column, width, process)| {
            let (kept, gained) = process.step(motion.elapsed_s);
            let off = move |d: usize| if gained > 0.0 { (to[d] - kept * from[d]).powi(2) / gained } else { 0.0 };
            (*column..column + width).map(off)
        });
        surprise(&DVector::from_column_slice(core.as_slice()), &noise) + each.sum::<f64>()
    }

    fn measure(&self, step: usize, at: &DVector<f64>) -> Result<Vec<Linear>> {
        let frame = self.frame(step);
        let layout = Layout::new(self.noise);
        let posed = Posed::new(layout, self.arm, self.noise, frame.moment());
        let cues = self.filter.cues().iter().flat_map(|name| frame.cues(*name, layout, self.noise));
        // A trajectory is one place at a time: nothing bends over its spread.
        let mut measured = Vec::with_capacity(3);
        for cue in cues {
            measured.extend(robust(&*cue, &posed, at, None)?);
        }
        Ok(measured)
    }
}
