//! The Kalman baseline: a Gaussian state, predicted and corrected linearly.

use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What a measurement says about one state: residual `(M,)`, slope `(M, D)`, noise covariance `(M, M)`.
pub type Linear = (DVector<f64>, DMatrix<f64>, DMatrix<f64>);

/// A Gaussian over the state: mean `(D,)` and covariance `(D, D)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gaussian {
    /// Mean.
    pub mean: DVector<f64>,
    /// Covariance.
    pub covariance: DMatrix<f64>,
}

/// A linear measurement met by a Gaussian, before it is applied.
#[derive(Debug, Clone, PartialEq)]
pub struct Innovation {
    /// At the Gaussian's mean, `(M,)`.
    pub residual: DVector<f64>,
    /// `(M, D)`.
    pub slope: DMatrix<f64>,
    /// The covariance times the slope, `(D, M)`.
    pub by_state: DMatrix<f64>,
    /// Inverse of the innovation's covariance, `(M, M)`.
    pub weight: DMatrix<f64>,
    /// Log evidence.
    pub log_evidence: f64,
}

impl Innovation {
    /// Of what is measured with `residual` at the mean.
    ///
    /// # Errors
    /// [`Error::Singular`], at the time given, when the innovation has no spread.
    pub fn new(time_s: f64, state: &Gaussian, (residual, slope, noise): Linear) -> Result<Self> {
        // The covariance is symmetric; long columns first.
        let by_state = &state.covariance * slope.transpose();
        let factor = (&slope * &by_state + noise).cholesky().ok_or(Error::Singular { time_s })?;
        let log_determinant: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let weight = factor.inverse();
        let distance = residual.dot(&(&weight * &residual));
        let log_evidence = -0.5 * (distance + log_determinant + residual.len() as f64 * TAU.ln());
        Ok(Self { residual, slope, by_state, weight, log_evidence })
    }

    /// Where it moves the mean by, `(D,)`.
    pub fn step(&self) -> DVector<f64> {
        &self.by_state * (&self.weight * &self.residual)
    }

    /// Narrow the covariance by what was measured.
    pub fn narrow(&self, covariance: &mut DMatrix<f64>) {
        covariance.gemm(-1.0, &self.by_state, &(&self.weight * self.by_state.transpose()), 1.0);
        symmetrise(covariance);
    }
}

/// What rounding leaves over the diagonal would grow.
pub(super) fn symmetrise(covariance: &mut DMatrix<f64>) {
    for column in 1..covariance.ncols() {
        for row in 0..column {
            let mean = 0.5 * (covariance[(row, column)] + covariance[(column, row)]);
            covariance[(row, column)] = mean;
            covariance[(column, row)] = mean;
        }
    }
}

impl Gaussian {
    /// `x = transition x + input + noise`.
    pub fn predict(&mut self, transition: &DMatrix<f64>, input: &DVector<f64>, noise: &DMatrix<f64>) {
        self.mean = transition * &self.mean + input;
        self.covariance = transition * &self.covariance * transition.transpose() + noise;
    }

    /// Correct by a measurement that is linearised about where the correction leads, `times` times in all (Bell & Cathey, "The
    /// iterated Kalman filter update as a Gauss-Newton method", IEEE Trans. Automatic Control 38(2), 1993). The log evidence is
    /// that of the last slope. `linearise` sees the prior's covariance too, for what bends over it. None where there is nothing to correct by.
    ///
    /// # Errors
    /// [`Error::Singular`]; what `linearise` gives.
    pub fn correct(
        &mut self,
        time_s: f64,
        times: usize,
        linearise: impl Fn(&DVector<f64>, &DMatrix<f64>) -> Result<Option<Linear>>,
    ) -> Result<Option<f64>> {
        let mut at = self.mean.clone();
        let mut evidence = None;
        for turn in 0..times.max(1) {
            let Some((mut residual, jacobian, noise)) = linearise(&at, &self.covariance)? else { return Ok(None) };
            // The residual that the prior mean has under this slope.
            residual -= &jacobian * (&self.mean - &at);
            let correction = Innovation::new(time_s, self, (residual, jacobian, noise))?;
            evidence = Some(correction.log_evidence);
            at = &self.mean + correction.step();
            if turn + 1 == times.max(1) {
                correction.narrow(&mut self.covariance);
            }
        }
        self.mean = at;
        Ok(evidence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two scalar observations of a standard normal: the textbook posterior and evidence.
    #[test]
    fn scalar_posterior_and_evidence() {
        let one = DMatrix::from_element(1, 1, 1.0);
        let mut state = Gaussian { mean: DVector::zeros(1), covariance: one.clone() };
        let seen = (DVector::from_element(1, 1.0), one.clone(), one.clone());
        let evidence = state.correct(0.0, 1, |_, _| Ok(Some(seen.clone()))).unwrap().unwrap();
        assert!((state.mean[0] - 0.5).abs() < 1e-15 && (state.covariance[0] - 0.5).abs() < 1e-15);
        assert!((evidence - (-0.25 - 0.5 * (2.0 * TAU).ln())).abs() < 1e-14);
        state.predict(&(&one * 2.0), &DVector::from_element(1, 3.0), &one);
        assert!((state.mean[0] - 4.0).abs() < 1e-15 && (state.covariance[0] - 3.0).abs() < 1e-15);
    }

    #[test]
    fn no_spread_is_an_error() {
        let zero = DMatrix::zeros(1, 1);
        let mut state = Gaussian { mean: DVector::zeros(1), covariance: zero.clone() };
        let seen = (DVector::zeros(1), DMatrix::identity(1, 1), zero);
        let result = state.correct(1.5, 1, |_, _| Ok(Some(seen.clone())));
        assert_eq!(result, Err(Error::Singular { time_s: 1.5 }));
    }
}
