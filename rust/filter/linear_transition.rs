//! How a smoothed recording's states lead from one to the next, linearly, and how that is carried back.

use nalgebra::{DMatrix, DVector};

/// How a step leads to the next: its first columns mix, each of the others is a share of what it was.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearTransition {
    /// `(M, M)`.
    pub mixed: DMatrix<f64>,
    /// `(D - M,)`.
    pub kept: DVector<f64>,
}

impl LinearTransition {
    /// All columns mix.
    pub fn of(mixed: DMatrix<f64>) -> Self {
        Self { mixed, kept: DVector::zeros(0) }
    }

    /// Its transpose times a vector `(D,)`.
    pub(super) fn back(&self, adjoint: &mut DVector<f64>) {
        let (mixed, count) = (self.mixed.ncols(), self.kept.len());
        let moved = self.mixed.tr_mul(&adjoint.rows(0, mixed));
        adjoint.rows_mut(0, mixed).copy_from(&moved);
        adjoint.rows_mut(mixed, count).component_mul_assign(&self.kept);
    }

    /// Its transpose times a symmetric matrix `(D, D)` times itself.
    pub(super) fn back_both(&self, adjoint: &mut DMatrix<f64>) {
        let (mixed, count) = (self.mixed.ncols(), self.kept.len());
        // The columns that mix, in all rows: what they share with the others is there once more, transposed.
        let mut columns = adjoint.columns(0, mixed) * &self.mixed;
        let square = self.mixed.tr_mul(&columns.rows(0, mixed));
        columns.rows_mut(0, mixed).copy_from(&square);
        for (d, kept) in self.kept.iter().enumerate() {
            columns.row_mut(mixed + d).scale_mut(*kept);
        }
        adjoint.columns_mut(0, mixed).copy_from(&columns);
        adjoint.view_mut((0, mixed), (mixed, count)).copy_from(&columns.rows(mixed, count).transpose());
        for c in 0..count {
            for r in 0..count {
                adjoint[(mixed + r, mixed + c)] *= self.kept[r] * self.kept[c];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What does not mix is carried back as if it were a column of one matrix.
    #[test]
    fn a_transition_in_parts_is_the_whole_matrix() {
        let mixed = DMatrix::from_fn(3, 3, |r, c| (1.0 + r as f64 - 0.7 * c as f64).sin());
        let parts = LinearTransition { mixed: mixed.clone(), kept: DVector::from_column_slice(&[0.9, 0.5]) };
        let mut whole = DMatrix::from_diagonal_element(5, 5, 0.0);
        whole.view_mut((0, 0), (3, 3)).copy_from(&mixed);
        (whole[(3, 3)], whole[(4, 4)]) = (0.9, 0.5);
        let root = DMatrix::from_fn(5, 5, |r, c| (2.0 * r as f64 + 3.0 * c as f64).cos());
        let (mut adjoint, mut squared) = (DVector::from_fn(5, |r, _| 1.0 + r as f64), &root * root.transpose());
        let (expected, expected_squared) = (whole.tr_mul(&adjoint), whole.tr_mul(&(&squared * &whole)));
        parts.back(&mut adjoint);
        parts.back_both(&mut squared);
        assert!((adjoint - expected).amax() < 1e-12 && (squared - expected_squared).amax() < 1e-12);
    }
}
