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

/// A linear measurement met by a Gaussian, before it is applied; of many rows with noise of their own in as few as say the same.
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
    pub fn new(time_s: f64, state: &Gaussian, measured: Linear) -> Result<Self> {
        let ((residual, slope, noise), beside) = condensed(measured);
        // The covariance is symmetric; long columns first.
        let by_state = &state.covariance * slope.transpose();
        let factor = (&slope * &by_state + noise).cholesky().ok_or(Error::Singular { time_s })?;
        let log_determinant: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let weight = factor.inverse();
        let distance = residual.dot(&(&weight * &residual));
        let log_evidence = beside - 0.5 * (distance + log_determinant + residual.len() as f64 * TAU.ln());
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

/// Independent rows turned into as few as there are columns that they say something of, and the log evidence of what is left
/// beside them, which no state changes (Bierman, "Factorization Methods for Discrete Sequential Estimation", 1977, ch. IV);
/// others as they are.
fn condensed(measured: Linear) -> (Linear, f64) {
    let (residual, slope, noise) = &measured;
    let columns: Vec<usize> = (0..slope.ncols()).filter(|d| slope.column(*d).iter().any(|x| *x != 0.0)).collect();
    let (rows, count, variance) = (residual.len(), columns.len(), noise.diagonal());
    let is_diagonal = || (0..rows).all(|c| (0..rows).all(|r| r == c || noise[(r, c)] == 0.0));
    if rows <= count + 1 || !variance.iter().all(|x| *x > 0.0) || !is_diagonal() {
        return (measured, 0.0);
    }
    let whole = DMatrix::from_fn(rows, count + 1, |row, column| {
        let of = columns.get(column).map_or(residual[row], |d| slope[(row, *d)]);
        of / variance[row].sqrt()
    });
    let triangle = whole.qr().r();
    let mut few = DMatrix::zeros(count, slope.ncols());
    for (column, d) in columns.iter().enumerate() {
        few.column_mut(*d).copy_from(&triangle.view((0, column), (count, 1)));
    }
    let left = triangle[(count, count)].powi(2) + variance.iter().map(|x| x.ln()).sum::<f64>();
    let residual = triangle.view((0, count), (count, 1)).column(0).into_owned();
    let beside = -0.5 * (left + (rows - count) as f64 * TAU.ln());
    ((residual, few, DMatrix::identity(count, count)), beside)
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

    /// As by its rows one after another; one column says nothing, and what is correlated stays as it is.
    #[test]
    fn many_rows_say_the_same_in_few() {
        let of = |rows: usize, columns: usize| DMatrix::from_fn(rows, columns, |r, c| ((7 * r + 3 * c) as f64).sin());
        let spread = of(4, 4);
        let state = Gaussian {
            mean: DVector::from_column_slice(&[0.3, -0.2, 1.0, 0.1]),
            covariance: &spread * spread.transpose() + DMatrix::identity(4, 4),
        };
        let mut slope = of(9, 4);
        slope.column_mut(2).fill(0.0);
        let residual = DVector::from_fn(9, |r, _| 0.1 * r as f64 - 0.4);
        let noise = DMatrix::from_diagonal(&DVector::from_fn(9, |r, _| 0.2 + 0.1 * r as f64));
        let all = (residual.clone(), slope.clone(), noise.clone());
        assert_eq!(condensed(all.clone()).0.0.len(), 3);
        let mut correlated = all.clone();
        (correlated.2[(0, 1)], correlated.2[(1, 0)]) = (0.05, 0.05);
        assert_eq!(condensed(correlated.clone()), (correlated, 0.0));
        let (mut at_once, mut by_one) = (state.clone(), state);
        let evidence = at_once.correct(0.0, 1, |_, _| Ok(Some(all.clone()))).unwrap().unwrap();
        let prior = by_one.mean.clone();
        let each = (0..9).map(|r| {
            let row = slope.rows(r, 1).into_owned();
            let residual = DVector::from_element(1, residual[r]) - &row * (&by_one.mean - &prior);
            let seen = (residual, row, DMatrix::from_element(1, 1, noise[(r, r)]));
            by_one.correct(0.0, 1, |_, _| Ok(Some(seen.clone()))).unwrap().unwrap()
        });
        let sum: f64 = each.sum();
        assert!((evidence - sum).abs() < 1e-10);
        assert!((at_once.mean - by_one.mean).amax() < 1e-12);
        assert!((at_once.covariance - by_one.covariance).amax() < 1e-12);
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
