//! What a smoother asks of a recording: states in a chain, how one leads to the next, and what is measured of each.

use super::linear_transition::LinearTransition;
use super::{Gaussian, Linear};
use crate::Result;
use nalgebra::DVector;

/// A recording as the smoother sees it: states at its steps, how one leads to the next, and what is measured of each.
pub trait Chain {
    /// How many steps, at least one.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The time of a step, s, for messages.
    fn time_s(&self, step: usize) -> f64;

    /// What is known of a step beforehand, where the chain starts there: at the first, and wherever it starts anew.
    fn start(&self, step: usize) -> Option<Gaussian>;

    /// Move a Gaussian from the step before to this one.
    fn predict(&self, step: usize, state: &mut Gaussian);

    /// How the step before leads to this one.
    fn transition(&self, step: usize) -> LinearTransition;

    /// How surprising it is to come from one state to another at this step: minus twice the log-density, but for a constant.
    fn surprise(&self, step: usize, from: &DVector<f64>, to: &DVector<f64>) -> f64;

    /// What is measured at a step, linearised about a state.
    ///
    /// # Errors
    /// Whatever cannot be linearised there.
    fn measure(&self, step: usize, at: &DVector<f64>) -> Result<Vec<Linear>>;
}
