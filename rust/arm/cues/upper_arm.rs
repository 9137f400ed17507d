//! A sensor on the upper arm: with it the elbow is known from the shoulder as a direction, at one depth only.
//!
//! Not in the paper. Its error, skin and heading, wanders slowly and is part of the state: a small turn in the world.

use super::Cue;
use super::length::TIMES;
use crate::Result;
use crate::arm::posed::Posed;
use crate::filter::Linear;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// For how long a sample says where the upper arm points, s.
const HOLDS_S: f64 = 0.1;

/// Where the upper arm points, by its sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Direction {
    /// Recording time, s.
    pub time_s: f64,
    /// From elbow to shoulder, of unit length, world.
    pub to_shoulder: Vector3<f64>,
    /// Standard deviation from sample to sample, rad.
    pub sd: f64,
}

/// Where it points at a time, by the last two samples up to then; none where they are too old.
pub(in crate::arm) fn direction_at(samples: &[Direction], time_s: f64) -> Option<Direction> {
    let until = samples.partition_point(|sample| sample.time_s <= time_s);
    let last = samples[..until].last().filter(|last| time_s - last.time_s <= HOLDS_S)?;
    let ahead = samples[..until - 1].last().filter(|before| last.time_s - before.time_s <= HOLDS_S).map(|before| {
        // Not beyond what was seen of the turn: where samples come in bursts, two of them say little of its speed.
        let share = ((time_s - last.time_s) / (last.time_s - before.time_s)).min(1.0);
        (last.to_shoulder + (last.to_shoulder - before.to_shoulder) * share).normalize()
    });
    Some(Direction { to_shoulder: ahead.unwrap_or(last.to_shoulder), ..*last })
}

/// The upper arm, shoulder to elbow, as long as it is and as its sensor points: three rows, m.
impl Cue for Direction {
    fn linearise(&self, posed: &Posed<'_>, state: &DVector<f64>, _: Option<&DMatrix<f64>>) -> Result<Option<Linear>> {
        let (upper_arm, mut slope) = posed.upper_arm(state);
        let mut length = posed.arm.upper_arm_m;
        let measured = -self.to_shoulder;
        let theta = posed.layout.upper_arm.map_or_else(Vector3::zeros, |column| state.fixed_rows::<3>(column).into());
        let along = measured + theta.cross(&measured);
        if let Some(column) = posed.layout.setup {
            length += state[column];
            let mut by_length = slope.fixed_view_mut::<3, 1>(0, column);
            by_length -= along;
        }
        if let Some(column) = posed.layout.upper_arm {
            let mut by_turn = slope.fixed_view_mut::<3, 3>(0, column);
            by_turn += measured.cross_matrix() * length;
        }
        let by_length = measured * measured.transpose();
        let across = (Matrix3::identity() - by_length) * (length * self.sd).powi(2);
        let noise = by_length * posed.noise.arm_length_sd_m.powi(2) + across + posed.beside_forearm();
        let residual = DVector::from_column_slice((along * length - upper_arm).as_slice());
        Ok(Some((residual, slope, DMatrix::from_column_slice(3, 3, noise.as_slice()))))
    }

    fn times(&self) -> usize {
        TIMES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pointing(time_s: f64, angle: f64) -> Direction {
        Direction { time_s, to_shoulder: Vector3::new(angle.sin(), 0.0, angle.cos()), sd: 0.05 }
    }

    #[test]
    fn between_samples_it_goes_on_turning() {
        let samples = [pointing(1.00, 0.10), pointing(1.02, 0.14)];
        let angle = |time_s| direction_at(&samples, time_s).map(|found| found.to_shoulder.x.atan2(found.to_shoulder.z));
        assert!((angle(1.01).unwrap() - 0.10).abs() < 1e-9, "by the first alone");
        assert!((angle(1.03).unwrap() - 0.16).abs() < 1e-4);
        assert!((angle(1.09).unwrap() - 0.18).abs() < 1e-3, "as far again, and no farther");
        assert_eq!(angle(0.99), None);
        assert_eq!(angle(1.13), None, "too old");
    }
}
