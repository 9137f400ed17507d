//! One posed state and how its points move with it: what cues are linearised about.

use super::figure::Figure;
use super::jacobian::PosedModel;
use crate::filter::Linear;
use crate::projection::{Projected, Projection};
use nalgebra::{DMatrix, DVector, Matrix2xX, Matrix3xX, Vector2, Vector3};
use std::f64::consts::TAU;

/// A posed state, its points and their slopes.
pub struct Sloped<'a> {
    /// What is posed.
    pub figure: &'a Figure,
    /// The camera.
    pub projection: &'a Projection,
    /// The state `(D,)`.
    pub state: &'a [f64],
    /// How uncertain it is `(D, D)`, where cues are to know that.
    pub covariance: Option<DMatrix<f64>>,
    posed: PosedModel<'a>,
}

impl<'a> Sloped<'a> {
    /// Pose `state` `(D,)`.
    ///
    /// # Panics
    /// When the state has fewer columns than are free.
    pub fn new(figure: &'a Figure, projection: &'a Projection, state: &'a [f64]) -> Self {
        Self { figure, projection, state, covariance: None, posed: figure.model.posed(state) }
    }

    /// The same, of a state that is so uncertain, its covariance's first columns `(D, D)`.
    #[must_use]
    pub fn within(self, covariance: &DMatrix<f64>) -> Self {
        let dim = self.dim();
        Self { covariance: Some(covariance.view((0, 0), (dim, dim)).into_owned()), ..self }
    }

    /// Mean variance of what moves with the state by `slope` `(2, D)`; 0 where it is not known how uncertain that is.
    pub fn variance(&self, slope: &Matrix2xX<f64>) -> f64 {
        self.covariance.as_ref().map_or(0.0, |covariance| 0.5 * (slope * covariance).component_mul(slope).sum())
    }

    /// How many columns the state has.
    pub fn dim(&self) -> usize {
        self.state.len()
    }

    /// Where a point of the figure is: world, m.
    pub fn at(&self, point: usize) -> Vector3<f64> {
        self.posed.at(point)
    }

    /// How it moves with the state, `(3, D)`.
    pub fn slope(&self, point: usize) -> Matrix3xX<f64> {
        self.posed.slope(point)
    }

    /// Where the camera sees it, and how that moves with the state, `(2, D)`; none behind the camera.
    pub fn seen(&self, point: usize) -> Option<(Projected, Matrix2xX<f64>)> {
        let at = self.at(point);
        let (_, slope) = self.projection.see_with_slope(at)?;
        Some((self.projection.see(at.into()), slope * self.slope(point)))
    }
}

/// Rows of what was measured, put together: residual, slope `(D,)` and variance of each.
#[derive(Default)]
pub struct Rows {
    rows: Vec<(f64, DVector<f64>, f64)>,
    /// Which of them are there only beyond a bound.
    bounds: Vec<usize>,
}

impl Rows {
    /// One more number.
    pub fn push(&mut self, residual: f64, slope: DVector<f64>, variance: f64) {
        self.rows.push((residual, slope, variance));
    }

    /// By how much a bound is passed, in standard deviations of that.
    pub fn push_bound(&mut self, residual: f64, slope: DVector<f64>) {
        self.bounds.push(self.rows.len());
        self.push(residual, slope, 1.0);
    }

    /// With bounds in units in which it adds nothing to a log density that one is passed: they tell states apart by how far.
    #[must_use]
    pub fn uncounted(mut self) -> Self {
        for row in &self.bounds {
            let (residual, slope, variance) = &mut self.rows[*row];
            (*residual, *variance) = (*residual / TAU.sqrt(), *variance / TAU);
            *slope /= TAU.sqrt();
        }
        self
    }

    /// Two more, of a pixel.
    pub fn push_pixel(&mut self, residual: Vector2<f64>, slope: &Matrix2xX<f64>, variance: f64) {
        for d in 0..2 {
            self.push(residual[d], slope.row(d).transpose(), variance);
        }
    }

    /// Three more, of a place or a direction.
    pub fn push_vector(&mut self, residual: Vector3<f64>, slope: &Matrix3xX<f64>, variance: f64) {
        for d in 0..3 {
            self.push(residual[d], slope.row(d).transpose(), variance);
        }
    }

    /// As one measurement of states that have `dim` columns, these the first of them; none of no rows.
    pub fn linear(self, dim: usize) -> Option<Linear> {
        let Self { rows, .. } = self;
        if rows.is_empty() {
            return None;
        }
        let residual = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.0));
        let noise = DMatrix::from_diagonal(&DVector::from_iterator(rows.len(), rows.iter().map(|row| row.2)));
        let mut slope = DMatrix::zeros(rows.len(), dim);
        for (mut to, (_, row, _)) in slope.row_iter_mut().zip(&rows) {
            to.columns_mut(0, row.len()).copy_from(&row.transpose());
        }
        Some((residual, slope, noise))
    }
}
