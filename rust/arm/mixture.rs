//! The arm as a mixture of Gaussians over the state of a worn sensor: both depths at which a viewing ray meets the elbow's
//! sphere are components, and what is wrong with orientation, shoulder and patch is part of the state.
//!
//! Not in the paper. The columns are position, velocity, bias (sensor frame), orientation error (world), then, where
//! they are estimated, patch offset (sensor frame) and shoulder displacement (world).

use super::cues::{CueName, robust, told_once};
use super::frame::{Frame, News};
use super::pause::Stretch;
use super::posed::Posed;
use super::state::{Arm, Layout, Noise, POSITION, VELOCITY};
use super::worn::{Moved, WornMotion};
use crate::Result;
use crate::estimate::{Estimate, Point};
use crate::filter::{Component, Gaussian, Mixture, Reduction};
use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

/// There may be so many times the components that are kept, while they are split; then they are merged.
const SPLIT_TO: usize = 2;
/// With less, what is kept crowds about one depth, and the other is not in the band; with more, circles on a table lose (4.0 cm with 0.5,
/// 4.3, 4.7 with 1.5).
const MERGE_WITHIN: f64 = 0.8;
const LEAST_WEIGHT: f64 = 1e-4;
/// How soon is forgotten what told components apart, s: a worn sensor's errors last, so that they tell less than they seem to.
const MEMORY_S: f64 = 1.3;
/// So much of what is known beforehand is told once, not in every frame. Captured arms, and slow ones, ask for all of it (6.8 cm for 9.0 of
/// none, 7.4 of half), circles on a table for none (3.4 for 7.3, 4.8).
const TOLD_ONCE: f64 = 0.5;
/// In bands what told components apart counts for so much of its logarithm: which of two depths it is hangs on little where an arm goes
/// slowly, and a band that takes it at its word is beside the truth for seconds.
const TOLD_IN_BANDS: f64 = 0.3;
/// A stretch of a ray as so many components.
const ON_STRETCH: usize = 9;

/// A mixture filter of the arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmMixture {
    layout: Layout,
    /// What corrects it, in this order.
    cues: Vec<CueName>,
    /// Components that are kept.
    most: usize,
    state: Mixture,
    news: News,
}

impl ArmMixture {
    /// About the arm's start; at most `most` components: with one it is an iterated extended Kalman filter; corrected by
    /// the patch, and after it by `cues`.
    pub fn new(arm: &Arm, noise: &Noise, cues: &[CueName], most: usize) -> Self {
        let layout = Layout::new(noise);
        let (mean, sd) = layout.start(arm, noise);
        let covariance = DMatrix::from_diagonal(&sd.component_mul(&sd));
        let others = cues.iter().copied().filter(|cue| *cue != CueName::Colour);
        let cues = std::iter::once(CueName::Colour).chain(others).collect();
        Self { layout, cues, most, state: Mixture::new(Gaussian { mean, covariance }), news: News::default() }
    }

    /// Whether the arm's length holds it.
    pub fn is_held_by_arm(&self) -> bool {
        self.cues.contains(&CueName::ArmLength)
    }

    /// What corrects it, in this order.
    pub fn cues(&self) -> &[CueName] {
        &self.cues
    }

    /// Mean and covariance of all components as one Gaussian.
    pub fn as_gaussian(&self) -> Gaussian {
        let (mean, covariance) = self.state.moments();
        Gaussian { mean, covariance }
    }

    /// Mean of all components, and of the heaviest.
    pub fn means(&self) -> [DVector<f64>; 2] {
        let heaviest = self.state.components().iter().max_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
        let (mean, _) = self.state.moments();
        [mean.clone(), heaviest.map_or(mean, |component| component.gaussian.mean.clone())]
    }

    /// An estimate from components over the same state.
    pub(super) fn of_components(&self, components: Vec<Component>, posed: &Posed<'_>, time_s: f64) -> Estimate {
        let layout = Layout::new(posed.noise);
        let of =
            Self { layout, cues: Vec::new(), most: self.most, state: Mixture::of(components), news: News::default() };
        of.summary(posed, time_s, None)
    }

    /// How many columns the state has but for the clock's.
    pub(super) fn dim_without_clock(&self) -> usize {
        self.layout.clock.unwrap_or(self.layout.dim)
    }

    /// How many components there are.
    pub fn components(&self) -> usize {
        self.state.components().len()
    }

    /// Start again somewhere on a stretch; what is known of bias, orientation and patch is kept.
    pub fn start_again(&mut self, arm: &Arm, noise: &Noise, stretch: &Stretch) {
        let (mut mean, mut covariance) = self.state.moments();
        let sd = stretch.sd(self.layout, arm, noise);
        for d in 0..VELOCITY + 3 {
            covariance.row_mut(d).fill(0.0);
            covariance.column_mut(d).fill(0.0);
            covariance[(d, d)] = sd[d] * sd[d];
        }
        mean.fixed_rows_mut::<3>(VELOCITY).fill(0.0);
        // Each as wide as they are apart.
        let share = stretch.half / ON_STRETCH as f64;
        let mut position = covariance.fixed_view_mut::<3, 3>(POSITION, POSITION);
        position += share * share.transpose();
        let component = |k: usize| {
            let along = (2.0 * k as f64 + 1.0) / ON_STRETCH as f64 - 1.0;
            let mut mean = mean.clone();
            mean.fixed_rows_mut::<3>(POSITION).copy_from(&(stretch.middle + along * stretch.half));
            Component { gaussian: Gaussian { mean, covariance: covariance.clone() }, log_weight: 0.0 }
        };
        self.state = Mixture::of((0..ON_STRETCH).map(component).collect());
    }

    /// Predict to the frame, then correct by every cue, where it says something new.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], [`crate::Error::RanAway`].
    pub fn update(&mut self, arm: &Arm, noise: &Noise, frame: &Frame<'_>) -> Result<Estimate> {
        self.predict(frame.worn.as_ref(), noise);
        let posed = Posed::new(self.layout, arm, noise, frame.moment());
        if !self.news.is_new(frame.time_s, frame.sightings.iter().map(|sighting| sighting.camera)) {
            return Ok(self.summary(&posed, frame.time_s, None));
        }
        let mut evidence = None;
        for cue in self.cues.iter().flat_map(|name| frame.cues(*name, self.layout, noise)) {
            self.state.split(SPLIT_TO * self.most + 1, |gaussian| cue.bent(&posed, gaussian));
            let linear = |state: &DVector<f64>, covariance: &DMatrix<f64>| {
                let linear = robust(&*cue, &posed, state, Some(covariance))?;
                Ok(linear.map(|linear| told_once(&*cue, linear, TOLD_ONCE)))
            };
            let found = self.state.correct(frame.time_s, cue.times(), linear)?;
            if cue.is_seen() {
                *evidence.get_or_insert(0.0) += found.unwrap_or(0.0);
            }
        }
        self.state.reduce(&Reduction { most: self.most, merge_within: MERGE_WITHIN, least_weight: LEAST_WEIGHT });
        Ok(self.summary(&posed, frame.time_s, evidence))
    }

    /// The estimate after a motion, at a frame that brings nothing else; changes nothing.
    pub fn estimate(&self, arm: &Arm, noise: &Noise, worn: Option<&WornMotion>, frame: &Frame<'_>) -> Estimate {
        let mut ahead = self.clone();
        ahead.predict(worn, noise);
        ahead.summary(&Posed::new(self.layout, arm, noise, frame.moment()), frame.time_s, None)
    }

    fn predict(&mut self, worn: Option<&WornMotion>, noise: &Noise) {
        let Some(motion) = worn else { return };
        self.state.forget((-motion.elapsed_s / MEMORY_S).exp());
        let moved = Moved::new(motion.clone(), noise);
        self.state.for_each(|gaussian| moved.predict(gaussian));
    }

    fn summary(&self, posed: &Posed<'_>, time_s: f64, log_evidence: Option<f64>) -> Estimate {
        let (mean, covariance) = self.state.moments_told(TOLD_IN_BANDS);
        let wrist = self.point(|state| posed.wrist(state), 0.0);
        let elbow = self.point(|state| posed.elbow_seen(state), posed.noise.forearm_sd_rad * posed.arm.forearm_m);
        let (state, places) = (wrist.with_state(mean, covariance), vec![wrist, elbow]);
        Estimate { time_s, state, places, ess: None, log_evidence, doubt: None, blobs: [None; 3] }
    }

    /// A place and its slope `(3, D)`, as a point with bands; `besides` is a standard deviation that is not in the state.
    fn point(&self, place: impl Fn(&DVector<f64>) -> (Vector3<f64>, DMatrix<f64>), besides: f64) -> Point {
        let of_component = |Component { gaussian, log_weight }: &Component| {
            let (mean, slope) = place(&gaussian.mean);
            let spread = &slope * &gaussian.covariance * slope.transpose();
            let sd = Vector3::from_fn(|d, _| spread[(d, d)].max(0.0).sqrt().hypot(besides).max(1e-9));
            (log_weight.exp(), mean, sd)
        };
        let told: Vec<_> = self.state.components().iter().map(of_component).collect();
        let shares = self.state.shares_told(TOLD_IN_BANDS);
        let less: Vec<_> = told.iter().zip(shares).map(|((_, mean, sd), share)| (share, *mean, *sd)).collect();
        Point::of_normals(&told).with_bands_of(&Point::of_normals(&less))
    }
}
