//! Rest, told from the IMU alone, and what it says: the wrist does not move.
//!
//! Not in the paper. Nothing else holds the depth while the arm lies still: one camera does not see it, and the
//! accelerometer's bias, integrated twice, runs off with it. Zero-velocity updates are the usual cure with IMUs worn on a foot
//! (Skog et al., "Zero-velocity detection", IEEE Trans. Biomed. Eng. 57(11), 2010).

use super::state::{Noise, VELOCITY};
use crate::filter::Likelihood;
use crate::observation::Sample;
use crate::particles::ParticleSet;
use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Time constant of the running moments, s.
const MEMORY_S: f64 = 0.2;

/// Running moments of what the IMU reads, each sample weighing `exp(-age / MEMORY_S)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stillness {
    since: Option<(f64, f64)>,
    acceleration: Vector3<f64>,
    variance: f64,
    turn_rate_squared: f64,
}

impl Stillness {
    /// Before the first sample.
    pub fn new() -> Self {
        Self { since: None, acceleration: Vector3::zeros(), variance: 0.0, turn_rate_squared: 0.0 }
    }

    /// Take a sample, later than those before.
    pub fn take(&mut self, sample: &Sample) {
        let turn_rate_squared = sample.turn_rate.map_or(0.0, |rate| rate.norm_squared());
        if let Some((_, last_s)) = self.since {
            let keep = (-(sample.time_s - last_s) / MEMORY_S).exp();
            let change = sample.acceleration - self.acceleration;
            self.acceleration += (1.0 - keep) * change;
            self.variance = keep * (self.variance + (1.0 - keep) * change.norm_squared());
            self.turn_rate_squared = keep * self.turn_rate_squared + (1.0 - keep) * turn_rate_squared;
        } else {
            (self.acceleration, self.turn_rate_squared) = (sample.acceleration, turn_rate_squared);
        }
        self.since = Some((self.since.map_or(sample.time_s, |(first_s, _)| first_s), sample.time_s));
    }

    /// Whether the sensor lies still: for two time constants at least something is known, and neither the specific force
    /// changes by more than `rest_accel` nor does the sensor turn by more than `rest_turn_rate` (both RMS, all axes).
    pub fn is_rest(&self, noise: &Noise) -> bool {
        self.since.is_some_and(|(first_s, last_s)| last_s - first_s >= 2.0 * MEMORY_S)
            && self.variance < noise.rest_accel * noise.rest_accel
            && self.turn_rate_squared < noise.rest_turn_rate * noise.rest_turn_rate
    }
}

impl Default for Stillness {
    fn default() -> Self {
        Self::new()
    }
}

/// The velocity is zero, to within `rest_speed` per axis.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    sd: f64,
}

impl Rest {
    /// As `noise` has it.
    pub fn new(noise: &Noise) -> Self {
        Self { sd: noise.rest_speed }
    }

    /// Residual `(3,)`, slope `(3, D)` and noise covariance about one state, for a linear filter.
    pub fn linearise(&self, state: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>, DMatrix<f64>) {
        let residual = -state.rows(VELOCITY, 3);
        let slope = DMatrix::from_fn(3, state.len(), |r, c| f64::from(u8::from(c == VELOCITY + r)));
        (residual, slope, DMatrix::from_diagonal_element(3, 3, self.sd * self.sd))
    }
}

impl Likelihood for Rest {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        let variance = self.sd * self.sd;
        let peak = -1.5 * (TAU * variance).ln();
        particles.map_blocks(out, |block, out| {
            let [x, y, z] = block.columns(VELOCITY);
            for i in 0..out.len() {
                out[i] = peak - 0.5 / variance * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quaternion::Quaternion;

    fn after(seconds: f64, acceleration: impl Fn(f64) -> f64, turn_rate: f64) -> bool {
        let mut stillness = Stillness::new();
        for k in 0..(seconds * 100.0) as usize {
            let time_s = k as f64 / 100.0;
            stillness.take(&Sample {
                time_s,
                acceleration: Vector3::new(acceleration(time_s), 0.0, 9.81),
                world_sensor: Quaternion::identity(),
                turn_rate: Some(Vector3::new(0.0, turn_rate, 0.0)),
            });
        }
        stillness.is_rest(&Noise::default())
    }

    #[test]
    fn rest_is_neither_shaking_nor_turning_and_takes_a_while_to_know() {
        assert!(after(1.0, |_| 0.3, 0.01));
        assert!(!after(0.3, |_| 0.0, 0.0));
        assert!(!after(1.0, |t| (20.0 * t).sin(), 0.0));
        assert!(!after(1.0, |_| 0.0, 0.5));
        // A push ends it within a sample or two; quiet brings it back.
        assert!(!after(1.0, |t| f64::from(u8::from(t > 0.975)), 0.0));
        assert!(after(3.0, |t| f64::from(u8::from(t < 1.0)), 0.0));
    }
}
