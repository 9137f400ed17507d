//! What is amiss with what comes in, while it comes: a patch or an IMU that is silent, a force that shows no gravity.
//!
//! A recording is looked at as a whole before it is tracked; of a stream this is all that tells. A filter goes on from what
//! the IMU says, as sure of itself as of what it sees, and seconds later it is somewhere else.

use super::timeline::GRAVITY;
use crate::observation::Sample;
use serde::{Deserialize, Serialize};

/// The patch is not seen.
pub const UNSEEN: &str = "no camera sees the patch";
/// No sample has come.
pub const SILENT: &str = "no IMU sample for some time";
/// The specific force is in another unit, or free of gravity.
pub const WEIGHTLESS: &str = "the acceleration shows no gravity: is it in m/s², with gravity in it?";

/// For so long either may be missed, s.
const BRIDGED_S: f64 = 0.3;
/// Memory of the force's size, s: an arm's own acceleration comes and goes.
const MEMORY_S: f64 = 2.0;
/// A sample stands for no longer than this, s.
const LONGEST_S: f64 = 0.1;
/// Its mean size at a moving wrist, m/s²: no stroke goes on for so long that it is beyond these.
const USUAL: [f64; 2] = [4.0, 25.0];

/// What came in so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Incoming {
    unseen_s: f64,
    silent_s: f64,
    force: f64,
    last_s: Option<f64>,
}

impl Incoming {
    /// Nothing yet.
    pub fn new() -> Self {
        Self { unseen_s: 0.0, silent_s: 0.0, force: GRAVITY, last_s: None }
    }

    /// Take an IMU sample.
    pub fn take(&mut self, sample: &Sample) {
        let elapsed_s = self.last_s.map_or(0.0, |last| (sample.time_s - last).clamp(0.0, LONGEST_S));
        let keep = (-elapsed_s / MEMORY_S).exp();
        self.force = keep * self.force + (1.0 - keep) * sample.acceleration.norm();
        self.last_s = Some(sample.time_s);
    }

    /// Take a frame, so long after the last.
    pub fn look(&mut self, time_s: f64, elapsed_s: f64, is_seen: bool) {
        self.silent_s = self.last_s.map_or(0.0, |last| time_s - last);
        self.unseen_s = if is_seen { 0.0 } else { self.unseen_s + elapsed_s };
    }

    /// What speaks against an estimate of a method that sees the patch or does not, if anything does.
    pub fn doubt(&self, sees_patch: bool) -> Option<&'static str> {
        if !(USUAL[0]..USUAL[1]).contains(&self.force) {
            Some(WEIGHTLESS)
        } else if self.silent_s > BRIDGED_S {
            Some(SILENT)
        } else if sees_patch && self.unseen_s > BRIDGED_S {
            Some(UNSEEN)
        } else {
            None
        }
    }
}

impl Default for Incoming {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quaternion::Quaternion;
    use nalgebra::Vector3;

    fn after(seconds: f64, force: f64) -> Incoming {
        let mut incoming = Incoming::new();
        for k in 0..(100.0 * seconds) as usize {
            let world_sensor = Quaternion::identity();
            let acceleration = Vector3::new(0.0, 0.0, force);
            incoming.take(&Sample { time_s: 0.01 * k as f64, acceleration, world_sensor, turn_rate: None });
        }
        incoming
    }

    #[test]
    fn gravity_in_another_unit_or_none_is_doubted_within_seconds() {
        for force in [0.0, 1.0, 9810.0] {
            assert_eq!(after(3.0, force).doubt(true), Some(WEIGHTLESS), "{force}");
        }
        assert_eq!(after(3.0, GRAVITY).doubt(true), None);
        // A stroke is no other unit.
        assert_eq!(after(0.5, 40.0).doubt(true), None);
    }

    #[test]
    fn a_patch_may_be_missed_for_a_moment() {
        let mut incoming = Incoming::new();
        for _ in 0..7 {
            incoming.look(0.0, 0.04, false);
            assert_eq!(incoming.doubt(true), None);
        }
        incoming.look(0.0, 0.04, false);
        assert_eq!(incoming.doubt(true), Some(UNSEEN));
        assert_eq!(incoming.doubt(false), None);
        incoming.look(0.0, 0.04, true);
        assert_eq!(incoming.doubt(true), None);
    }

    #[test]
    fn an_imu_may_be_silent_for_a_moment() {
        let mut incoming = after(1.0, GRAVITY);
        incoming.look(1.2, 0.04, true);
        assert_eq!(incoming.doubt(true), None);
        incoming.look(1.4, 0.04, true);
        assert_eq!(incoming.doubt(true), Some(SILENT));
    }
}
