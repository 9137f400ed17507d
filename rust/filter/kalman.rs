//! The Kalman baseline: a Gaussian state, predicted and corrected linearly.

use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A Gaussian over the state: mean `(D,)` and covariance `(D, D)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gaussian {
    /// Mean.
    pub mean: DVector<f64>,
    /// Covariance.
    pub covariance: DMatrix<f64>,
}

impl Gaussian {
    /// `x = transition x + input + noise`.
    pub fn predict(&mut self, transition: &DMatrix<f64>, input: &DVector<f64>, noise: &DMatrix<f64>) {
        self.mean = transition * &self.mean + input;
        self.covariance = transition * &self.covariance * transition.transpose() + noise;
    }

    /// Correct by `residual = z - h(mean)` with slope `jacobian` `(M, D)` and noise covariance `(M, M)`, in
    /// Joseph's form, which keeps the covariance symmetric and positive. Returns the log evidence.
    ///
    /// # Errors
    /// [`Error::Singular`], at the time given, when the innovation has no spread.
    pub fn correct(
        &mut self,
        time_s: f64,
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        noise: &DMatrix<f64>,
    ) -> Result<f64> {
        let spread = jacobian * &self.covariance * jacobian.transpose() + noise;
        let factor = spread.cholesky().ok_or(Error::Singular { time_s })?;
        let gain = factor.solve(&(jacobian * &self.covariance)).transpose();
        self.mean += &gain * residual;
        let keep = DMatrix::identity(self.mean.len(), self.mean.len()) - &gain * jacobian;
        self.covariance = &keep * &self.covariance * keep.transpose() + &gain * noise * gain.transpose();
        let log_determinant: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let distance = residual.dot(&factor.solve(residual));
        Ok(-0.5 * (distance + log_determinant + residual.len() as f64 * TAU.ln()))
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
        let evidence = state.correct(0.0, &DVector::from_element(1, 1.0), &one, &one).unwrap();
        assert!((state.mean[0] - 0.5).abs() < 1e-15 && (state.covariance[0] - 0.5).abs() < 1e-15);
        assert!((evidence - (-0.25 - 0.5 * (2.0 * TAU).ln())).abs() < 1e-14);
        state.predict(&(&one * 2.0), &DVector::from_element(1, 3.0), &one);
        assert!((state.mean[0] - 4.0).abs() < 1e-15 && (state.covariance[0] - 3.0).abs() < 1e-15);
    }

    #[test]
    fn no_spread_is_an_error() {
        let zero = DMatrix::zeros(1, 1);
        let mut state = Gaussian { mean: DVector::zeros(1), covariance: zero.clone() };
        let result = state.correct(1.5, &DVector::zeros(1), &DMatrix::identity(1, 1), &zero);
        assert_eq!(result, Err(Error::Singular { time_s: 1.5 }));
    }
}
