//! The upper arm's length as a measurement: eqs (15), (16).
//!
//! The paper compares squared lengths but states its noise as 1 cm; here the residual is the length itself,
//! `|elbow - shoulder| - L1`, which is what a deviation in centimetres belongs to.

use super::state::{Arm, Noise, POSITION};
use crate::filter::Likelihood;
use crate::particles::ParticleSet;
use nalgebra::{DMatrix, DVector, Vector3};
use std::f64::consts::TAU;

/// How fast a forearm turns that nothing is known of, rad/s.
pub const TURN_RATE: f64 = 1.0;

/// The constraint at one orientation of the forearm.
#[derive(Debug, Clone)]
pub struct ArmLength {
    /// Wrist to elbow, less the shoulder: elbow - shoulder is wrist + this.
    reach: Vector3<f64>,
    upper_arm_m: f64,
    sd: f64,
}

impl ArmLength {
    /// `forearm` is wrist to elbow in the world, m (eq. 2), known `stale_s` ago: since then the forearm may have
    /// turned at [`TURN_RATE`], and the elbow with it.
    pub fn new(arm: &Arm, forearm: Vector3<f64>, noise: &Noise, stale_s: f64) -> Self {
        let sd = noise.arm_length_sd.hypot(arm.forearm_m * TURN_RATE * stale_s);
        Self { reach: forearm - arm.shoulder, upper_arm_m: arm.upper_arm_m, sd }
    }

    /// Residual `(1,)`, slope `(1, D)` and noise variance about one state, for a linear filter; `None` where
    /// the elbow sits on the shoulder and has no direction.
    pub fn linearise(&self, state: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>, DMatrix<f64>)> {
        let upper_arm: Vector3<f64> = state.fixed_rows::<3>(POSITION) + self.reach;
        let length = upper_arm.norm();
        if length <= 0.0 {
            return None;
        }
        let mut slope = DMatrix::zeros(1, state.len());
        for d in 0..3 {
            slope[(0, POSITION + d)] = upper_arm[d] / length;
        }
        let residual = DVector::from_element(1, self.upper_arm_m - length);
        Some((residual, slope, DMatrix::from_element(1, 1, self.sd * self.sd)))
    }

    /// The nearest position at which the upper arm has its length.
    pub fn project(&self, wrist: Vector3<f64>) -> Vector3<f64> {
        let upper_arm = wrist + self.reach;
        let length = upper_arm.norm();
        if length <= 0.0 { wrist } else { upper_arm * (self.upper_arm_m / length) - self.reach }
    }
}

impl Likelihood for ArmLength {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        let peak = -0.5 * (TAU * self.sd * self.sd).ln();
        let scale = -0.5 / (self.sd * self.sd);
        particles.map_blocks(out, |block, out| {
            let [x, y, z] = block.columns(POSITION);
            for i in 0..out.len() {
                let (dx, dy, dz) = (x[i] + self.reach.x, y[i] + self.reach.y, z[i] + self.reach.z);
                let residual = (dx * dx + dy * dy + dz * dz).sqrt() - self.upper_arm_m;
                out[i] = peak + scale * residual * residual;
            }
        });
    }
}
