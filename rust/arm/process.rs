//! A quantity that is constant or wanders slowly.

use serde::{Deserialize, Serialize};

/// A quantity of the state that is unknown at first and then walks slowly, drawn back towards zero so that it never
/// becomes less certain than it was at first: a Gauss-Markov process of first order.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GaussMarkov {
    /// Standard deviation per axis at the start.
    pub start_sd: f64,
    /// Standard deviation per axis gained per √s.
    pub density: f64,
}

impl GaussMarkov {
    /// Over `dt` seconds: the factor that is kept, and the variance gained.
    pub fn step(&self, dt: f64) -> (f64, f64) {
        let (variance, gained) = (self.start_sd * self.start_sd, self.density * self.density * dt);
        // As much is forgotten as keeps the variance at what it was at the start.
        let forgotten = if gained > 0.0 { (-gained / variance).exp_m1() } else { 0.0 };
        ((0.5 * (forgotten).ln_1p()).exp(), -variance * forgotten)
    }
}
