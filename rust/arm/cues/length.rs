//! The upper arm's length as a measurement: eqs (15), (16).
//!
//! The paper compares squared lengths but states its noise as 1 cm; here the residual is the length itself,
//! `|elbow - shoulder| - L1`, which is what a deviation in centimetres belongs to.

use super::Cue;
use crate::Result;
use crate::arm::posed::Posed;
use crate::arm::state::{Arm, Noise, POSITION};
use crate::filter::{Gaussian, Likelihood, Linear};
use crate::particles::ParticleSet;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::f64::consts::TAU;

/// How fast a forearm turns that nothing is known of, rad/s.
pub const TURN_RATE: f64 = 1.0;

/// A Gaussian bends where the second order of the length exceeds this share of the length's standard deviation.
const BENT: f64 = 0.2;
/// How often it is linearised.
pub(super) const TIMES: usize = 3;

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
        let sd = noise.arm_length_sd_m.hypot(arm.forearm_m * TURN_RATE * stale_s);
        Self { reach: forearm - arm.shoulder, upper_arm_m: arm.upper_arm_m, sd }
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

/// Linear about a state, to second order: a place that is known to within a ball is farther from the shoulder, on average, than
/// the ball's centre is. It says nothing where the upper arm has no direction.
#[derive(Debug, Clone, Copy)]
pub struct UpperArmLength;

impl Cue for UpperArmLength {
    fn linearise(
        &self,
        posed: &Posed<'_>,
        state: &DVector<f64>,
        covariance: Option<&DMatrix<f64>>,
    ) -> Result<Option<Linear>> {
        let (upper_arm, by_state) = posed.upper_arm(state);
        let length = upper_arm.norm();
        if length <= 0.0 {
            return Ok(None);
        }
        let along = upper_arm / length;
        let mut slope = along.transpose() * &by_state;
        let (more, more_variance) = covariance.map_or((0.0, 0.0), |covariance| {
            let spread = &by_state * covariance * by_state.transpose();
            let bend = (Matrix3::identity() - along * along.transpose()) / length;
            let bent: Matrix3<f64> = bend * Matrix3::from_fn(|r, c| spread[(r, c)]);
            (0.5 * bent.trace(), 0.5 * (bent * bent).trace())
        });
        let sd = length_sd(posed, along);
        let mut residual = DVector::from_element(1, posed.arm.upper_arm_m - length - more);
        if let Some(column) = posed.layout.setup {
            residual[0] += state[column];
            slope[column] -= 1.0;
        }
        let noise = DMatrix::from_element(1, 1, sd * sd + more_variance);
        Ok(Some((residual, DMatrix::from_row_slice(1, posed.layout.dim, slope.as_slice()), noise)))
    }

    fn is_seen(&self) -> bool {
        false
    }

    fn times(&self) -> usize {
        TIMES
    }

    fn bent(&self, posed: &Posed<'_>, gaussian: &Gaussian) -> Option<DVector<f64>> {
        let spread: Matrix3<f64> = gaussian.covariance.fixed_view::<3, 3>(POSITION, POSITION).into_owned();
        let eigen = spread.symmetric_eigen();
        let widest = eigen.eigenvalues.imax();
        let (variance, direction) = (eigen.eigenvalues[widest], eigen.eigenvectors.column(widest).into_owned());
        let (upper_arm, _) = posed.upper_arm(&gaussian.mean);
        let length = upper_arm.norm().max(0.05);
        let across = 1.0 - (upper_arm.dot(&direction) / length).powi(2);
        let sd = length_sd(posed, upper_arm / length);
        (0.5 * across * variance / length > BENT * sd).then(|| {
            let mut whole = DVector::zeros(posed.layout.dim);
            whole.fixed_rows_mut::<3>(POSITION).copy_from(&direction);
            whole
        })
    }
}

/// Of the length, along the upper arm: itself, and a forearm that lies beside the sensor's axis or has turned unseen.
fn length_sd(posed: &Posed<'_>, along: Vector3<f64>) -> f64 {
    let turn = posed.noise.forearm_sd_rad.hypot(TURN_RATE * posed.moment.stale_s);
    posed.noise.arm_length_sd_m.hypot(turn * along.cross(&posed.forearm).norm())
}
