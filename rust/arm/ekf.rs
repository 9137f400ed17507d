//! The baselines: a Gaussian over the same state, under the same motion.
//!
//! * no likelihoods: inertial only, the IMU integrated twice;
//! * colour: the extended Kalman filter of the paper's comparison;
//! * colour and arm length: the constraint as a pseudo-measurement;
//! * colour and arm projection: the authors' earlier method (III-E, last paragraph), in which the EKF's result
//!   is moved to the nearest point that the arm's length allows.

use super::cues::CueName;
use super::cues::length::ArmLength;
use super::frame::Frame;
use super::motion::{InertialMotion, Motion};
use super::pause::Stretch;
use super::posed::Posed;
use super::state::{Arm, Layout, Noise, POSITION, estimate_of_gaussian};
use crate::estimate::Estimate;
use crate::filter::{Gaussian, Mixture};
use crate::quaternion::Quaternion;
use crate::{Error, Result, error::require};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// What is done to the Gaussian at a frame, in the order listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Correction {
    /// Corrected by a cue, linearised (eqs 7, 15).
    Cue(CueName),
    /// The mean moved to the nearest point that the arm's length allows; the covariance stays.
    ArmProjection,
}

impl Correction {
    /// A [`CueName`] or `arm_projection`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        if name == "arm_projection" {
            return Ok(Self::ArmProjection);
        }
        CueName::from_name(name).map(Self::Cue).map_err(|_| Error::UnknownName {
            what: "correction",
            name: name.into(),
            known: "colour, arm_length, rest, arm_projection",
        })
    }
}

/// An extended Kalman filter of the arm: a mixture of one Gaussian, which nothing splits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmGaussian {
    corrections: Vec<Correction>,
    layout: Layout,
    state: Mixture,
}

impl ArmGaussian {
    /// About the arm's start.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an outlier share, which a Gaussian cannot have.
    pub fn new(arm: &Arm, noise: &Noise, corrections: Vec<Correction>) -> Result<Self> {
        let outliers = noise.outlier_fraction;
        require(outliers == 0.0, "outlier_fraction", outliers, "0 for a Gaussian method, which has no outliers")?;
        let layout = Layout::new(noise);
        let (mean, sd) = layout.start(arm, noise);
        let covariance = DMatrix::from_diagonal(&sd.component_mul(&sd));
        Ok(Self { corrections, layout, state: Mixture::new(Gaussian { mean, covariance }) })
    }

    /// Start again somewhere on a stretch, after what came before has been of no use.
    pub fn start_again(&mut self, arm: &Arm, noise: &Noise, stretch: &Stretch) {
        let (mean, covariance) = stretch.gaussian(self.layout, arm, noise);
        self.state = Mixture::new(Gaussian { mean, covariance });
    }

    /// Whether the patch is among what corrects it.
    pub fn sees_patch(&self) -> bool {
        self.corrections.contains(&Correction::Cue(CueName::Colour))
    }

    /// Whether the arm's length holds it.
    pub fn is_held_by_arm(&self) -> bool {
        self.corrections.iter().any(|c| matches!(c, Correction::Cue(CueName::ArmLength) | Correction::ArmProjection))
    }

    /// Predict to the frame and apply every correction.
    ///
    /// # Errors
    /// [`Error::Singular`], [`Error::RanAway`].
    pub fn update(&mut self, arm: &Arm, noise: &Noise, frame: &Frame<'_>) -> Result<Estimate> {
        let forearm = frame.world_sensor.rotate(arm.elbow_in_sensor());
        self.predict(&frame.motion, noise);
        let posed = Posed::new(self.layout, arm, noise, frame.moment());
        let mut evidence = None;
        for correction in &self.corrections {
            let Correction::Cue(name) = correction else {
                self.state.for_each(|Gaussian { mean, .. }| {
                    let wrist = mean.fixed_rows::<3>(POSITION).into();
                    let nearest = ArmLength::new(arm, forearm, noise, frame.stale_s).project(wrist);
                    mean.fixed_rows_mut::<3>(POSITION).copy_from(&nearest);
                });
                continue;
            };
            for cue in frame.cues(*name, self.layout, noise) {
                let found = self.state.correct(frame.time_s, 1, |state, _| cue.linearise(&posed, state, None))?;
                evidence = found.map_or(evidence, |found| Some(evidence.unwrap_or(0.0) + found));
            }
        }
        Ok(estimate_of_gaussian(frame.time_s, self.gaussian(), forearm, evidence))
    }

    fn gaussian(&self) -> &Gaussian {
        &self.state.components()[0].gaussian
    }

    /// The estimate after `motion`.
    pub fn estimate(
        &self,
        arm: &Arm,
        noise: &Noise,
        time_s: f64,
        motion: &Motion,
        world_sensor: Quaternion,
    ) -> Estimate {
        let mut ahead = self.clone();
        ahead.predict(motion, noise);
        estimate_of_gaussian(time_s, ahead.gaussian(), world_sensor.rotate(arm.elbow_in_sensor()), None)
    }

    fn predict(&mut self, motion: &Motion, noise: &Noise) {
        let (transition, input, spread) = InertialMotion::new(motion.clone(), self.layout, noise).matrices();
        self.state.for_each(|gaussian| gaussian.predict(&transition, &input, &spread));
    }
}
