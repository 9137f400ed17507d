//! Which IMU sample holds when, and what has piled up since the last frame.
//!
//! A sample holds from its own time on; a frame splits the interval. Beyond `hold_s` after the last sample (one
//! and a half sampling intervals, for a slow IMU) nothing says how the arm accelerates: it is taken not to, with
//! the larger noise `gap_density`; nor how it turns: the orientation stays, and is said to be stale.

use super::motion::Motion;
use super::state::{Noise, require_finite};
use super::stillness::Stillness;
use super::worn::{Step, WornMotion};
use crate::error::require_time;
use crate::observation::Sample;
use crate::quaternion::Quaternion;
use crate::{Error, Result};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.806_65;

/// How far from 1 the norm of an orientation may be before it is refused.
const NORM_TOLERANCE: f64 = 0.02;

/// The IMU's side of the tracker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    now_s: f64,
    held: Option<Held>,
    /// The shortest interval between samples so far, s.
    shortest_s: f64,
    pending: Motion,
    /// The same for a worn sensor, where it is asked for.
    worn: Option<WornMotion>,
    /// For how long of it nothing was measured, s.
    pending_gap_s: f64,
    stillness: Stillness,
}

/// The sample that holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Held {
    time_s: f64,
    acceleration: Vector3<f64>,
    world_sensor: Quaternion,
    turn_rate: Option<Vector3<f64>>,
}

impl Timeline {
    /// Before the first sample; `is_worn`: the motion of a worn sensor is composed besides.
    pub fn new(is_worn: bool) -> Self {
        Self {
            now_s: f64::NEG_INFINITY,
            held: None,
            shortest_s: f64::INFINITY,
            pending: Motion::none(),
            worn: is_worn.then(WornMotion::none),
            pending_gap_s: 0.0,
            stillness: Stillness::new(),
        }
    }

    /// The time reached, s.
    pub fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Let `sample` hold from its time on.
    ///
    /// # Errors
    /// [`Error::Late`], [`Error::NotFinite`], [`Error::QuaternionNorm`]; the timeline is then as before.
    pub fn take(&mut self, sample: &Sample, noise: &Noise) -> Result<()> {
        let time_s = sample.time_s;
        require_time("IMU time", time_s)?;
        require_finite("acceleration", time_s, sample.acceleration.as_slice())?;
        require_finite("orientation", time_s, &sample.world_sensor.wxyz())?;
        if let Some(rate) = sample.turn_rate {
            require_finite("turn rate", time_s, rate.as_slice())?;
        }
        let norm = sample.world_sensor.norm();
        if (norm - 1.0).abs() > NORM_TOLERANCE {
            return Err(Error::QuaternionNorm { time_s, norm, tolerance: NORM_TOLERANCE });
        }
        if self.held.is_some_and(|held| time_s <= held.time_s) || time_s < self.now_s {
            let latest_s = self.held.map_or(self.now_s, |held| held.time_s.max(self.now_s));
            return Err(Error::Late { what: "IMU sample", time_s, latest_s });
        }
        self.advance(time_s, noise);
        if let Some(held) = self.held {
            self.shortest_s = self.shortest_s.min(time_s - held.time_s);
        }
        self.stillness.take(sample);
        let world_sensor = sample.world_sensor.normalized();
        // Eq. (4).
        let acceleration = world_sensor.rotate(sample.acceleration) - Vector3::new(0.0, 0.0, GRAVITY);
        self.held = Some(Held { time_s, acceleration, world_sensor, turn_rate: sample.turn_rate });
        Ok(())
    }

    /// Reach a frame; its motion is what [`Timeline::pending`] then holds.
    ///
    /// # Errors
    /// [`Error::NoInertialSample`] before the first sample, [`Error::Late`] for a frame that is not later than
    /// what was reached.
    pub fn reach_frame(&mut self, time_s: f64, noise: &Noise) -> Result<()> {
        require_time("frame time", time_s)?;
        let held_s = self.held.map_or(f64::INFINITY, |held| held.time_s);
        if time_s < held_s && self.shortest_s.is_infinite() {
            return Err(Error::NoInertialSample { time_s });
        }
        let latest_s = held_s.max(self.now_s);
        if time_s < latest_s {
            return Err(Error::Late { what: "frame", time_s, latest_s });
        }
        self.advance(time_s, noise);
        Ok(())
    }

    /// Motion since the last frame.
    pub fn pending(&self) -> &Motion {
        &self.pending
    }

    /// Start a new interval: the pending motion has been used, or there is nothing yet that it could move.
    pub fn clear_pending(&mut self) {
        self.pending = Motion::none();
        if let Some(worn) = &mut self.worn {
            *worn = WornMotion::none();
        }
        self.pending_gap_s = 0.0;
    }

    /// Motion of a worn sensor since the last frame, where it is composed.
    pub fn worn(&self) -> Option<&WornMotion> {
        self.worn.as_ref()
    }

    /// For how long of the pending motion the IMU said nothing, s.
    pub fn pending_gap_s(&self) -> f64 {
        self.pending_gap_s
    }

    /// How long a sample holds, s.
    fn hold_s(&self, noise: &Noise) -> f64 {
        if self.shortest_s.is_finite() { noise.hold_s.max(1.5 * self.shortest_s) } else { noise.hold_s }
    }

    /// For how long nothing has said how the sensor is oriented, s.
    pub fn stale_s(&self, noise: &Noise) -> f64 {
        self.held.map_or(0.0, |held| (self.now_s - held.time_s - self.hold_s(noise)).max(0.0))
    }

    /// How the wrist accelerates now, world, m/s², as measured; not at all where nothing is.
    pub fn acceleration(&self, noise: &Noise) -> Vector3<f64> {
        self.held.filter(|_| self.stale_s(noise) == 0.0).map_or_else(Vector3::zeros, |held| held.acceleration)
    }

    /// Whether the sensor lies still, as far as is known.
    pub fn is_rest(&self, noise: &Noise) -> bool {
        self.stale_s(noise) == 0.0 && self.stillness.is_rest(noise)
    }

    /// Orientation now: the held sample's, advanced by its turn rate, where there is one, for as long as it holds.
    pub fn world_sensor(&self, noise: &Noise) -> Quaternion {
        let Some(held) = self.held else { return Quaternion::identity() };
        match held.turn_rate {
            None => held.world_sensor,
            Some(rate) => {
                held.world_sensor * {
                    Quaternion::from_rotation_vector(rate * (self.now_s - held.time_s).min(self.hold_s(noise)))
                }
            }
        }
    }

    fn advance(&mut self, to_s: f64, noise: &Noise) {
        if let Some(held) = self.held {
            let holds_until = (held.time_s + self.hold_s(noise)).clamp(self.now_s, to_s.max(self.now_s));
            if let Some(worn) = &mut self.worn {
                let force = held.acceleration + Vector3::new(0.0, 0.0, GRAVITY);
                let density = noise.accel_density * (1.0 + noise.accel_growth * held.acceleration.norm());
                let world_sensor = held.world_sensor.to_matrix();
                let step = Step {
                    dt: holds_until - self.now_s,
                    acceleration: held.acceleration,
                    force,
                    world_sensor,
                    density,
                };
                if step.dt > 0.0 {
                    worn.append(&step, noise);
                }
                if to_s > holds_until {
                    let (zero, density) = (Vector3::zeros(), noise.gap_density);
                    let dt = to_s - holds_until;
                    worn.append(&Step { dt, acceleration: zero, force: zero, world_sensor, density }, noise);
                }
            }
            if holds_until > self.now_s {
                self.pending.append(holds_until - self.now_s, held.acceleration, noise.accel_density, noise.bias);
            }
            if to_s > holds_until {
                self.pending.append(to_s - holds_until, Vector3::zeros(), noise.gap_density, noise.bias);
                self.pending_gap_s += to_s - holds_until;
            }
        }
        self.now_s = to_s;
    }
}

impl Default for Timeline {
    fn default() -> Self {
        Self::new(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise() -> Noise {
        Noise { gap_density: 1.0, hold_s: 0.1, ..Noise::default() }
    }

    fn sample(time_s: f64, x: f64) -> Sample {
        let acceleration = Vector3::new(x, 0.0, GRAVITY);
        Sample { time_s, acceleration, world_sensor: Quaternion::identity(), turn_rate: None }
    }

    #[test]
    fn rest_reads_plus_g() {
        let mut timeline = Timeline::new(false);
        timeline.take(&sample(0.0, 0.0), &noise()).unwrap();
        timeline.reach_frame(0.1, &noise()).unwrap();
        assert_eq!(timeline.pending().input, nalgebra::Matrix3::zeros());
    }

    /// A frame that comes late is told so: it was said to be before the first sample of all.
    #[test]
    fn a_frame_before_a_later_sample_is_late() {
        let mut timeline = Timeline::new(false);
        let refused = |timeline: &mut Timeline, time_s| timeline.reach_frame(time_s, &noise()).unwrap_err();
        assert_eq!(refused(&mut timeline, 0.5), Error::NoInertialSample { time_s: 0.5 });
        timeline.take(&sample(1.0, 1.0), &noise()).unwrap();
        assert_eq!(refused(&mut timeline, 0.5), Error::NoInertialSample { time_s: 0.5 });
        timeline.take(&sample(1.01, 1.0), &noise()).unwrap();
        assert_eq!(refused(&mut timeline, 1.005), Error::Late { what: "frame", time_s: 1.005, latest_s: 1.01 });
        timeline.reach_frame(1.01, &noise()).unwrap();
    }

    /// A sample holds from its own time on, and a frame splits the interval.
    #[test]
    fn a_frame_splits_the_interval() {
        let mut timeline = Timeline::new(false);
        timeline.take(&sample(0.0, 1.0), &noise()).unwrap();
        timeline.reach_frame(0.03, &noise()).unwrap();
        assert!((timeline.pending().input[(1, 0)] - 0.03).abs() < 1e-15);
        timeline.clear_pending();
        timeline.take(&sample(0.04, 5.0), &noise()).unwrap();
        timeline.reach_frame(0.07, &noise()).unwrap();
        assert!((timeline.pending().input[(1, 0)] - (0.01 + 0.15)).abs() < 1e-15);
    }

    /// Beyond `hold_s` an old sample says nothing, and the noise is larger.
    #[test]
    fn a_gap_is_not_filled_with_an_old_sample() {
        let mut timeline = Timeline::new(false);
        timeline.take(&sample(0.0, 1.0), &noise()).unwrap();
        timeline.reach_frame(0.6, &noise()).unwrap();
        let pending = timeline.pending();
        assert!((pending.input[(1, 0)] - 0.1).abs() < 1e-15);
        assert!((pending.noise[(1, 1)] - (0.01 * 0.1 + 1.0 * 0.5)).abs() < 1e-12);
        assert!((pending.elapsed_s - 0.6).abs() < 1e-15);
    }
}
