//! The smoother's Kalman passes over a chain of states: forward, and back for means and covariances.

use super::chain::Chain;
use super::kalman::symmetrise;
use super::{Gaussian, Innovation, Linear};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// One pass forward, kept for the way back.
pub(super) struct Forward {
    /// What the steps so far say of each.
    pub filtered: Vec<Gaussian>,
    /// Whether the chain starts there.
    starts: Vec<bool>,
    corrections: Vec<Vec<Innovation>>,
}

impl Forward {
    /// Of what was measured at every step, given the steps before.
    pub fn log_evidence(&self) -> Vec<f64> {
        let of_step = |step: &Vec<Innovation>| step.iter().map(|correction| correction.log_evidence).sum();
        self.corrections.iter().map(of_step).collect()
    }
}

/// The pass forward, by what was measured about the trajectory `at`.
///
/// # Errors
/// [`Error::Singular`], what the chain gives.
pub(super) fn filter(chain: &impl Chain, at: &[DVector<f64>], measured: Vec<Vec<Linear>>) -> Result<Forward> {
    let count = chain.len();
    let mut forward = Forward {
        filtered: Vec::with_capacity(count),
        starts: Vec::with_capacity(count),
        corrections: Vec::with_capacity(count),
    };
    for (step, (at, measured)) in at.iter().zip(measured).enumerate() {
        let start = chain.start(step);
        forward.starts.push(start.is_some());
        let mut state = match (start, forward.filtered.last()) {
            (Some(start), _) => start,
            (None, Some(before)) => {
                let mut state = before.clone();
                chain.predict(step, &mut state);
                state
            }
            (None, None) => {
                return Err(Error::Size { name: "start of a chain", got: 0, unit: "Gaussians", expected: 1 });
            }
        };
        let mut corrections = Vec::new();
        for (residual, slope, noise) in measured {
            // What the residual would be at the state as it stands.
            let residual = residual - &slope * (&state.mean - at);
            let correction = Innovation::new(chain.time_s(step), &state, (residual, slope, noise))?;
            state.mean += correction.step();
            correction.narrow(&mut state.covariance);
            corrections.push(correction);
        }
        forward.corrections.push(corrections);
        forward.filtered.push(state);
    }
    Ok(forward)
}

/// Means given the whole recording: back by the adjoint of the filter, which inverts no covariance (Bierman, "Fixed interval
/// smoothing with discrete measurements", Int. J. Control 18(1), 1973: modified Bryson-Frazier).
///
/// # Errors
/// [`Error::RanAway`].
pub(super) fn means(chain: &impl Chain, forward: &Forward) -> Result<Vec<DVector<f64>>> {
    let mut means: Vec<DVector<f64>> = forward.filtered.iter().map(|state| state.mean.clone()).collect();
    let mut adjoint = DVector::zeros(forward.filtered[0].mean.len());
    for step in (0..means.len()).rev() {
        means[step] += &forward.filtered[step].covariance * &adjoint;
        for Innovation { residual, slope, by_state, weight, .. } in forward.corrections[step].iter().rev() {
            adjoint += slope.tr_mul(&(weight * (residual - by_state.tr_mul(&adjoint))));
        }
        if forward.starts[step] {
            adjoint.fill(0.0);
        } else {
            chain.transition(step).back(&mut adjoint);
        }
    }
    match means.iter().position(|mean| mean.iter().any(|x| !x.is_finite())) {
        Some(step) => Err(Error::RanAway { time_s: chain.time_s(step) }),
        None => Ok(means),
    }
}

/// Covariances given the whole recording, in place of the filter's: the same way back.
pub(super) fn covariances(chain: &impl Chain, forward: &mut Forward) {
    let dim = forward.filtered[0].mean.len();
    let mut adjoint = DMatrix::zeros(dim, dim);
    for step in (0..forward.filtered.len()).rev() {
        let covariance = &mut forward.filtered[step].covariance;
        let narrower = &*covariance * (&adjoint * &*covariance);
        *covariance -= narrower;
        symmetrise(covariance);
        for Innovation { slope, by_state, weight, .. } in forward.corrections[step].iter().rev() {
            let gain = by_state * weight;
            let seen = &adjoint * &gain;
            let inner = gain.tr_mul(&seen) + weight;
            let across = slope.tr_mul(&seen.transpose());
            adjoint += slope.tr_mul(&(inner * slope));
            adjoint -= &across;
            adjoint -= across.transpose();
        }
        if forward.starts[step] {
            adjoint.fill(0.0);
        } else {
            chain.transition(step).back_both(&mut adjoint);
        }
        symmetrise(&mut adjoint);
    }
}
