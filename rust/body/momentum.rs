//! How a body moves between frames as a mixture and when it is smoothed: every channel with a velocity that forgets itself.
//!
//! Not in the paper, whose dynamics have order zero. Where a limb lies in the picture's plane two ways on look alike, and what
//! tells them apart is how it was moving. A velocity is an Ornstein-Uhlenbeck process, a channel its integral.

use super::figure::Figure;
use super::joints::Group;
use crate::Result;
use crate::error::require;
use crate::filter::{Gaussian, LinearTransition};
use crate::skeleton::Channel;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use serde::{Deserialize, Serialize};

/// No parameter is larger, in any unit.
const MOST: f64 = 1e6;
/// No channel is known better, m or rad, and no velocity.
const LEAST: f64 = 1e-6;

/// An angle of which nothing is known any more, rad: joints do not turn farther.
const ANY_RAD: f64 = 1.0;

/// How uncertain motion with velocity is, and the first pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Momentum {
    /// Of the root's place, m/s/√s.
    pub base: f64,
    /// Of its turns, and of back and neck where they are free, rad/s/√s.
    pub turn: f64,
    /// Of shoulders and elbows, rad/s/√s.
    pub joint: f64,
    /// How long a velocity lasts, s.
    pub lasts_s: f64,
    /// Of the root's place at the first frame, m.
    pub first_m: f64,
    /// Of every angle at the first frame, rad.
    pub first_rad: f64,
}

/// One channel's: density, standard deviation at the first frame, and the most that it may have.
#[derive(Debug, Clone, Copy)]
struct Column {
    density: f64,
    first_sd: f64,
    most_sd: f64,
}

/// The motion of all channels; states `(2 D,)` are channels, then their velocities.
pub(super) struct Moving {
    columns: Vec<Column>,
    lasts_s: f64,
}

impl Momentum {
    /// Check every range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let Self { base, turn, joint, lasts_s, first_m, first_rad } = *self;
        let positive = |x: f64| x > 0.0 && x <= MOST;
        let each = [
            ("base_accel_density", base, "a positive number, m/s/√s"),
            ("turn_accel_density", turn, "a positive number, rad/s/√s"),
            ("joint_accel_density", joint, "a positive number, rad/s/√s"),
            ("velocity_lasts_s", lasts_s, "a positive time in seconds"),
            ("first_pose_sd_m", first_m, "a positive length in metres"),
            ("first_pose_sd_rad", first_rad, "a positive angle"),
        ];
        each.into_iter().try_for_each(|(name, value, expected)| require(positive(value), name, value, expected))
    }

    /// Of a figure's channels.
    pub(super) fn of(&self, figure: &Figure) -> Moving {
        let column = |((bone, channel), group): (&(usize, Channel), &Group)| match (bone, channel, group) {
            (_, Channel::Translation(_), _) => {
                Column { density: self.base, first_sd: self.first_m, most_sd: f64::INFINITY }
            }
            (0, Channel::Rotation(_), _) | (_, _, Group::Torso) => {
                Column { density: self.turn, first_sd: self.first_rad, most_sd: ANY_RAD }
            }
            _ => Column { density: self.joint, first_sd: self.first_rad, most_sd: ANY_RAD },
        };
        let columns = figure.channels.iter().zip(&figure.groups).map(column).collect();
        Moving { columns, lasts_s: self.lasts_s }
    }
}

impl Moving {
    /// How many columns the state has.
    pub fn dim(&self) -> usize {
        2 * self.columns.len()
    }

    /// About a pose `(D,)`, moving in any way; `wider` times as uncertain as the first pose.
    pub fn start(&self, pose: &[f64], wider: f64) -> Gaussian {
        let count = self.columns.len();
        let mut covariance = DMatrix::zeros(self.dim(), self.dim());
        for (d, column) in self.columns.iter().enumerate() {
            covariance[(d, d)] = (wider * column.first_sd).powi(2);
            covariance[(count + d, count + d)] = column.density.powi(2) * 0.5 * self.lasts_s;
        }
        let mean = DVector::from_fn(self.dim(), |d, _| pose.get(d).copied().unwrap_or(0.0));
        Gaussian { mean, covariance }
    }

    /// A pose `(D,)` of which a covariance `(D, D)` is known, and of velocities nothing.
    pub fn still(&self, pose: &[f64], covariance: &DMatrix<f64>) -> Gaussian {
        let mut still = self.start(pose, 0.0);
        still.covariance.view_mut((0, 0), covariance.shape()).copy_from(covariance);
        still
    }

    /// What a velocity does to its channel within `dt` s, and how much of it is left.
    fn kept(&self, dt: f64) -> (f64, f64) {
        let share = -(-dt / self.lasts_s).exp_m1();
        (self.lasts_s * share, 1.0 - share)
    }

    /// Covariance of a channel and its velocity that `dt` s add, of unit density.
    fn noise(&self, dt: f64) -> Matrix2<f64> {
        let (tau, short) = (self.lasts_s, dt / self.lasts_s < 1e-2);
        let share = -(-dt / tau).exp_m1();
        let both = share * (2.0 - share);
        // Of a short step the terms cancel: there the velocity has not begun to forget.
        let place = if short { dt.powi(3) / 3.0 } else { tau * tau * (dt - 2.0 * tau * share + 0.5 * tau * both) };
        let mixed = if short { 0.5 * dt * dt } else { 0.5 * (tau * share).powi(2) };
        let speed = if short { dt } else { 0.5 * tau * both };
        Matrix2::new(place, mixed, mixed, speed)
    }

    /// How a state leads to that `dt` s later.
    pub fn transition(&self, dt: f64) -> LinearTransition {
        let (count, (gained, kept)) = (self.columns.len(), self.kept(dt));
        let mut transition = DMatrix::identity(self.dim(), self.dim());
        for d in 0..count {
            (transition[(d, count + d)], transition[(count + d, count + d)]) = (gained, kept);
        }
        LinearTransition::of(transition)
    }

    /// Move a Gaussian by `dt` s: as `transition` does, which mixes a channel with its own velocity alone.
    pub fn predict(&self, dt: f64, state: &mut Gaussian) {
        let (count, (gained, kept), noise) = (self.columns.len(), self.kept(dt), self.noise(dt));
        let Gaussian { mean, covariance } = state;
        for d in 0..count {
            mean[d] += gained * mean[count + d];
            mean[count + d] *= kept;
        }
        // Its rows, then its columns.
        for mut column in covariance.column_iter_mut() {
            for d in 0..count {
                column[d] += gained * column[count + d];
                column[count + d] *= kept;
            }
        }
        let (mut channels, mut velocities) = covariance.columns_range_pair_mut(0..count, count..);
        channels.zip_apply(&velocities, |channel, velocity| *channel += gained * velocity);
        velocities *= kept;
        for (d, column) in self.columns.iter().enumerate() {
            let density = column.density.powi(2);
            covariance[(d, d)] += density * noise[(0, 0)] + LEAST * LEAST;
            covariance[(d, count + d)] += density * noise[(0, 1)];
            covariance[(count + d, d)] += density * noise[(0, 1)];
            covariance[(count + d, count + d)] += density * noise[(1, 1)] + LEAST * LEAST;
        }
    }

    /// Let no channel of a Gaussian be less known than one of which nothing is.
    pub fn bound(&self, state: &mut Gaussian) {
        for (d, column) in self.columns.iter().enumerate() {
            let share = column.most_sd / state.covariance[(d, d)].sqrt();
            if share < 1.0 {
                state.covariance.row_mut(d).scale_mut(share);
                state.covariance.column_mut(d).scale_mut(share);
            }
        }
    }

    /// Minus twice the log-density of coming from one state to another within `dt` s, but for a constant.
    pub fn surprise(&self, dt: f64, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
        let (count, (gained, kept), noise) = (self.columns.len(), self.kept(dt), self.noise(dt));
        let of = |(d, column): (usize, &Column)| {
            let off = Vector2::new(to[d] - from[d] - gained * from[count + d], to[count + d] - kept * from[count + d]);
            let spread = noise * column.density.powi(2) + Matrix2::identity() * (LEAST * LEAST);
            spread.cholesky().map_or(f64::INFINITY, |factor| off.dot(&factor.solve(&off)))
        };
        self.columns.iter().enumerate().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn moving() -> Moving {
        Moving { columns: vec![Column { density: 2.0, first_sd: 0.1, most_sd: 1.0 }], lasts_s: 0.4 }
    }

    /// Predicting in place is the matrix of the transition, as it is carried back.
    #[test]
    fn predicting_is_the_transition() {
        let column = |density| Column { density, first_sd: 0.1, most_sd: 1.0 };
        let moving = Moving { columns: vec![column(2.0), column(0.5)], lasts_s: 0.4 };
        let root = DMatrix::from_fn(4, 4, |r, c| (2.0 * r as f64 + 3.0 * c as f64).cos());
        let start = Gaussian { mean: DVector::from_fn(4, |r, _| r as f64 - 1.5), covariance: &root * root.transpose() };
        let (mut moved, mut none) = (start.clone(), start.clone());
        none.covariance.fill(0.0);
        moving.predict(0.2, &mut moved);
        moving.predict(0.2, &mut none);
        let LinearTransition { mixed, .. } = moving.transition(0.2);
        assert!((moved.mean - &mixed * start.mean).amax() < 1e-14);
        assert!((moved.covariance - &mixed * start.covariance * mixed.transpose() - none.covariance).amax() < 1e-14);
    }

    proptest! {
        /// Two steps are one of both lengths.
        #[test]
        fn steps_compose(first in 1e-3_f64..1.0, second in 1e-3_f64..1.0) {
            let start = Gaussian { mean: DVector::from_vec(vec![0.3, -1.0]), ..moving().start(&[0.0], 1.0) };
            let (mut twice, mut once) = (start.clone(), start);
            moving().predict(first, &mut twice);
            moving().predict(second, &mut twice);
            moving().predict(first + second, &mut once);
            prop_assert!((twice.mean - once.mean).amax() < 1e-9);
            prop_assert!((twice.covariance - &once.covariance).amax() < 0.02 * once.covariance.amax());
        }

        /// The density of a step is that of what predicting adds.
        #[test]
        fn surprise_is_that_of_the_prediction(dt in 1e-3_f64..0.5, x in -1.0_f64..1.0, v in -3.0_f64..3.0) {
            let from = DVector::from_vec(vec![0.2, 1.0]);
            let mut state = Gaussian { mean: from.clone(), covariance: DMatrix::zeros(2, 2) };
            moving().predict(dt, &mut state);
            let to = &state.mean + DVector::from_vec(vec![x, v]);
            let expected = crate::filter::Spread::new(&state.covariance).surprise(&(&to - &state.mean));
            let found = moving().surprise(dt, &from, &to);
            prop_assert!((found - expected).abs() < 1e-4 * (1.0 + expected), "{found} is not {expected}");
        }
    }
}
