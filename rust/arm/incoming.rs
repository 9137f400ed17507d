//! What is amiss with what comes in, while it comes: a patch or an IMU that is silent, a force that shows no gravity, a
//! gyroscope that turns otherwise than the orientation.
//!
//! A recording is looked at as a whole before it is tracked; of a stream this is all that tells. A filter goes on from what
//! the IMU says, as sure of itself as of what it sees, and seconds later it is somewhere else.

use super::timeline::GRAVITY;
use crate::observation::Sample;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The patch is not seen.
pub const UNSEEN: &str = "no camera sees the patch";
/// No sample has come.
pub const SILENT: &str = "no IMU sample for some time";
/// The specific force is in another unit, or free of gravity.
pub const WEIGHTLESS: &str = "the acceleration shows no gravity: is it in m/s², with gravity in it?";
/// Too many of its samples could not be used.
pub const REFUSED: &str = "many IMU samples were refused: see the errors";
/// The IMU is stuck.
pub const STUCK: &str = "the IMU says the same again and again";
/// The gyroscope and the orientation contradict each other.
pub const TURNS_OTHERWISE: &str =
    "the gyroscope turns otherwise than the orientation: is it in rad/s, and in the same axes?";

/// For so long either may be missed, s.
const BRIDGED_S: f64 = 0.3;
/// Memory of the force's size, s: an arm's own acceleration comes and goes.
const MEMORY_S: f64 = 2.0;
/// A sample stands for no longer than this, s.
const LONGEST_S: f64 = 0.1;
/// Its mean size at a moving wrist, m/s²: no stroke goes on for so long that it is beyond these.
const USUAL: [f64; 2] = [4.0, 25.0];
/// More than this share of the last samples refused is more than a fault now and then.
const MANY: f64 = 0.2;
/// The last so many count.
const LAST: f64 = 100.0;
/// Turns are compared over so long: beside the noise of single samples, s.
const TURN_S: f64 = 0.1;
/// Less turning than this says nothing, rad²: 0.5 rad/s for a second.
const LEAST_TURNING: f64 = 0.025;
/// By how much of what the gyroscope says the orientation turns.
const ALIKE: [f64; 2] = [0.5, 2.0];

/// What came in so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Incoming {
    unseen_s: f64,
    silent_s: f64,
    same_s: f64,
    force: f64,
    /// Share of the last samples.
    refused: f64,
    last: Option<Sample>,
    turns: Turns,
}

/// What gyroscope and orientation say of the same turns.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Turns {
    began: Option<Sample>,
    /// By the gyroscope since then, rad.
    turned: Vector3<f64>,
    /// Squares of the gyroscope's turns, and their products with the orientation's, as far as they are remembered, rad².
    squares: f64,
    products: f64,
}

impl Turns {
    /// Take a sample, and the one before.
    fn take(&mut self, last: &Sample, sample: &Sample) {
        let elapsed_s = sample.time_s - last.time_s;
        let (Some(before), Some(now)) = (last.turn_rate, sample.turn_rate) else { return };
        if !(0.0..LONGEST_S).contains(&elapsed_s) {
            (self.began, self.turned) = (None, Vector3::zeros());
            return;
        }
        let began = self.began.get_or_insert(*last);
        self.turned += 0.5 * (before + now) * elapsed_s;
        let lasted_s = sample.time_s - began.time_s;
        if lasted_s >= TURN_S {
            let turn = began.world_sensor.conjugate() * sample.world_sensor;
            let by_orientation = 2.0 * turn.w.signum() * turn.v; // small enough
            let keep = (-lasted_s / MEMORY_S).exp();
            self.squares = keep * self.squares + self.turned.norm_squared();
            self.products = keep * self.products + self.turned.dot(&by_orientation);
            self.began = Some(*sample);
            self.turned = Vector3::zeros();
        }
    }

    /// Whether one is no turn of the other.
    fn contradict(&self) -> bool {
        self.squares > LEAST_TURNING && !(ALIKE[0]..ALIKE[1]).contains(&(self.products / self.squares))
    }
}

impl Incoming {
    /// Nothing yet.
    pub fn new() -> Self {
        let (force, turns) = (GRAVITY, Turns::default());
        Self { unseen_s: 0.0, silent_s: 0.0, same_s: 0.0, force, refused: 0.0, last: None, turns }
    }

    /// Take an IMU sample.
    pub fn take(&mut self, sample: &Sample) {
        if let Some(last) = self.last {
            let elapsed_s = (sample.time_s - last.time_s).clamp(0.0, LONGEST_S);
            let keep = (-elapsed_s / MEMORY_S).exp();
            self.force = keep * self.force + (1.0 - keep) * sample.acceleration.norm();
            let is_same = sample.acceleration == last.acceleration && sample.world_sensor == last.world_sensor;
            self.same_s = if is_same { self.same_s + elapsed_s } else { 0.0 };
            self.turns.take(&last, sample);
        }
        self.refused -= self.refused / LAST;
        self.last = Some(*sample);
    }

    /// A sample was refused; nothing is lost by one that comes twice.
    pub fn miss(&mut self, time_s: f64) {
        if self.last.is_none_or(|last| time_s != last.time_s) {
            self.refused += (1.0 - self.refused) / LAST;
        }
    }

    /// Take a frame, so long after the last.
    pub fn look(&mut self, time_s: f64, elapsed_s: f64, is_seen: bool) {
        self.silent_s = self.last.map_or(0.0, |last| time_s - last.time_s);
        self.unseen_s = if is_seen { 0.0 } else { self.unseen_s + elapsed_s };
    }

    /// What speaks against an estimate of a method that sees the patch or does not, if anything does.
    pub fn doubt(&self, sees_patch: bool) -> Option<&'static str> {
        if !(USUAL[0]..USUAL[1]).contains(&self.force) {
            Some(WEIGHTLESS)
        } else if self.turns.contradict() {
            Some(TURNS_OTHERWISE)
        } else if self.silent_s > BRIDGED_S {
            Some(SILENT)
        } else if self.refused > MANY {
            Some(REFUSED)
        } else if self.same_s > BRIDGED_S {
            Some(STUCK)
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

    /// At rest, but for what trembles.
    fn after(seconds: f64, force: f64) -> Incoming {
        let mut incoming = Incoming::new();
        for k in 0..(100.0 * seconds) as usize {
            let world_sensor = Quaternion::identity();
            let acceleration = Vector3::new(1e-3 * (k % 3) as f64, 0.0, force);
            incoming.take(&Sample { time_s: 0.01 * k as f64, acceleration, world_sensor, turn_rate: None });
        }
        incoming
    }

    /// A sensor that turns to and fro about two axes, its gyroscope as changed.
    fn turning(change: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Incoming {
        let (mut incoming, mut world_sensor) = (Incoming::new(), Quaternion::identity());
        for k in 0..400 {
            let time_s = 0.01 * f64::from(k);
            let rate = Vector3::new(2.0 * (3.0 * time_s).cos(), 1.5 * (2.0 * time_s).sin(), 0.3);
            world_sensor = world_sensor * Quaternion::from_rotation_vector(0.01 * rate);
            let acceleration = Vector3::new(1e-3 * f64::from(k % 3), 0.0, GRAVITY);
            incoming.take(&Sample { time_s, acceleration, world_sensor, turn_rate: Some(change(rate)) });
        }
        incoming
    }

    #[test]
    fn a_gyroscope_that_turns_otherwise_is_doubted() {
        assert_eq!(turning(|rate| rate).doubt(true), None);
        assert_eq!(turning(|rate| rate + Vector3::new(0.1, -0.1, 0.05)).doubt(true), None);
        assert_eq!(turning(|rate| rate * 57.3).doubt(true), Some(TURNS_OTHERWISE));
        assert_eq!(turning(|rate| -rate).doubt(true), Some(TURNS_OTHERWISE));
        assert_eq!(turning(|rate| rate.yzx()).doubt(true), Some(TURNS_OTHERWISE));
    }

    #[test]
    fn a_turn_that_a_gap_cuts_short_is_forgotten() {
        let mut incoming = turning(|rate| rate);
        let last = incoming.last.unwrap();
        let turn_rate = Some(Vector3::new(30.0, 0.0, 0.0));
        incoming.take(&Sample { time_s: last.time_s + 0.05, turn_rate, ..last });
        incoming.take(&Sample { time_s: last.time_s + 1.0, turn_rate, ..last });
        assert_eq!(incoming.turns.began, None);
        assert_eq!(incoming.turns.turned, Vector3::zeros());
    }

    #[test]
    fn an_imu_that_is_stuck_is_doubted() {
        let mut incoming = after(1.0, GRAVITY);
        let stuck = incoming.last.unwrap();
        for k in 0..40 {
            incoming.take(&Sample { time_s: 1.0 + 0.01 * f64::from(k), ..stuck });
        }
        assert_eq!(incoming.doubt(true), Some(STUCK));
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
    fn many_refused_samples_are_doubted_and_few_or_repeated_ones_are_not() {
        let mut incoming = after(1.0, GRAVITY);
        let last = incoming.last.unwrap();
        for k in 0..60 {
            incoming.miss(last.time_s); // comes again
            if k < 20 {
                incoming.miss(0.5);
            }
        }
        assert_eq!(incoming.doubt(true), None);
        for k in 0..10 {
            incoming.miss(2.0 + f64::from(k));
        }
        assert_eq!(incoming.doubt(true), Some(REFUSED));
        let mut time_s = last.time_s;
        for k in 0..100 {
            time_s += 0.01;
            incoming.take(&Sample {
                time_s,
                acceleration: last.acceleration * (1.0 + 1e-3 * f64::from(k % 3)),
                ..last
            });
        }
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
