//! Rest, told from the IMU alone.
//!
//! Not in the paper. Zero-velocity updates are the usual cure of what runs off with IMUs worn on a foot (Skog et al.,
//! "Zero-velocity detection", IEEE Trans. Biomed. Eng. 57(11), 2010).

use super::state::Noise;
use crate::observation::Sample;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

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
