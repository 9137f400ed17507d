//! Weighted Gaussians over a body's channels and velocities as an estimate: components of a mixture, branches of a smoother.

use super::figure::Figure;
use super::joints::KEY_JOINTS;
use super::skin::Blobs;
use super::sloped::Sloped;
use super::unseen::{Known, Unseen};
use crate::estimate::{Estimate, Point};
use crate::filter::{Component, Gaussian, Mixture};
use crate::particles::{Interval, LOWER, Summary, UPPER};
use crate::projection::Projection;
use nalgebra::{DMatrix, DVector};

/// Nothing is known better, m or rad.
const LEAST_SD: f64 = 1e-9;

/// What is posed, and what is added that neither model nor camera knows.
#[derive(Clone, Copy)]
pub(super) struct Posing<'a> {
    pub figure: &'a Figure,
    pub projection: &'a Projection,
    pub unseen: &'a Unseen,
}

impl Posing<'_> {
    /// What Gaussians `(2 D,)`, each with its weight, the heaviest first, say of the body at a frame.
    pub fn estimate(&self, time_s: f64, known: Known, parts: &[(f64, &Gaussian)], blobs: Blobs) -> Estimate {
        let each: Vec<(f64, Gaussian, Gaussian)> = parts
            .iter()
            .map(|(weight, state)| {
                let (angles, joints) = self.posed(state);
                (*weight, angles, joints)
            })
            .collect();
        let mut joints = together(&each.iter().map(|(weight, _, joints)| (*weight, joints)).collect::<Vec<_>>());
        self.unseen.add(&mut joints, self.projection, known);
        let mut state = together(&each.iter().map(|(weight, angles, _)| (*weight, angles)).collect::<Vec<_>>());
        // Between two of them there is no pose: the heaviest is one.
        state.mean = state.mode.clone();
        Estimate {
            time_s,
            places: (0..KEY_JOINTS.len()).map(|joint| Point::of_columns(&joints, 3 * joint)).collect(),
            state,
            ess: None,
            log_evidence: None,
            doubt: None,
            blobs,
        }
    }

    /// Channels and key joints of a state, m.
    fn posed(&self, state: &Gaussian) -> (Gaussian, Gaussian) {
        let dim = self.figure.model.dim();
        let mean = state.mean.rows(0, dim).into_owned();
        let covariance = state.covariance.view((0, 0), (dim, dim)).into_owned();
        let sloped = Sloped::new(self.figure, self.projection, mean.as_slice());
        let mut slopes = DMatrix::zeros(3 * KEY_JOINTS.len(), dim);
        let mut places = DVector::zeros(3 * KEY_JOINTS.len());
        for joint in 0..KEY_JOINTS.len() {
            slopes.rows_mut(3 * joint, 3).copy_from(&sloped.slope(joint));
            places.rows_mut(3 * joint, 3).copy_from(&sloped.at(joint));
        }
        if let Some(balance) = &self.figure.balance {
            let (moved, by_joints) = balance.moved(&places);
            (places, slopes) = (moved, by_joints * slopes);
        }
        let spread = &slopes * &covariance * slopes.transpose();
        (Gaussian { mean, covariance }, Gaussian { mean: places, covariance: spread })
    }
}

/// Weighted normal distributions as one summary; the heaviest is the first.
fn together(parts: &[(f64, &Gaussian)]) -> Summary {
    let of = |part: &(f64, &Gaussian)| Component { gaussian: part.1.clone(), log_weight: part.0.ln() };
    let (mean, covariance) = Mixture::of(parts.iter().map(of).collect()).moments();
    let band = |d: usize| {
        let sd = |state: &Gaussian| state.covariance[(d, d)].max(0.0).sqrt().max(LEAST_SD);
        let parts: Vec<_> = parts.iter().map(|(weight, state)| (*weight, state.mean[d], sd(state))).collect();
        Interval { lo: Mixture::quantile(&parts, LOWER), hi: Mixture::quantile(&parts, UPPER) }
    };
    let bands = (0..mean.len()).map(band).collect();
    Summary { mean, covariance, bands, mode: parts[0].1.mean.clone() }
}
