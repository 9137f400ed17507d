//! A covariance as deviations are measured by it: factored once.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Noise of less than full rank is made whole by this share of each variance.
const LEAST: f64 = 1e-9;

/// A covariance, factored; what has no spread at all does not count.
#[derive(Debug, Clone)]
pub struct Spread {
    known: Vec<usize>,
    scale: DVector<f64>,
    /// None where it is no covariance.
    factor: Option<Cholesky<f64, Dyn>>,
}

impl Spread {
    /// Of a covariance `(D, D)`.
    pub fn new(covariance: &DMatrix<f64>) -> Self {
        let known: Vec<usize> = (0..covariance.nrows()).filter(|d| covariance[(*d, *d)] > 0.0).collect();
        let scale = DVector::from_iterator(known.len(), known.iter().map(|d| covariance[(*d, *d)].sqrt()));
        let scaled = DMatrix::from_fn(known.len(), known.len(), |r, c| {
            covariance[(known[r], known[c])] / (scale[r] * scale[c]) + if r == c { LEAST } else { 0.0 }
        });
        Self { known, scale, factor: scaled.cholesky() }
    }

    /// Squared length of a deviation `(D,)` in standard deviations; without end where there is no covariance.
    pub fn surprise(&self, off: &DVector<f64>) -> f64 {
        let mut off = DVector::from_fn(self.known.len(), |r, _| off[self.known[r]] / self.scale[r]);
        let is_solved = |factor: &Cholesky<f64, Dyn>| factor.l_dirty().solve_lower_triangular_mut(&mut off);
        if self.factor.as_ref().is_some_and(is_solved) { off.norm_squared() } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_are_in_standard_deviations() {
        let covariance = DMatrix::from_row_slice(3, 3, &[4.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0]);
        let off = DVector::from_column_slice(&[1.0, 7.0, -0.5]);
        // The second has no spread: the other two, by the inverse of [[4, 1], [1, 1]].
        let expected = (1.0 - 2.0 * 1.0 * -0.5 + 4.0 * 0.25) / 3.0;
        assert!((Spread::new(&covariance).surprise(&off) - expected).abs() < 1e-6);
        assert!(Spread::new(&-DMatrix::identity(2, 2)).surprise(&DVector::zeros(2)) < 1e-12);
        let none = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert_eq!(Spread::new(&none).surprise(&DVector::from_element(2, 1.0)), f64::INFINITY);
    }
}
