//! What rest says ([`crate::arm::stillness`]): the wrist does not move, but for a tremor about its place.
//!
//! Not in the paper. Nothing else holds the depth while the arm lies still: one camera does not see it, and the
//! accelerometer's bias, integrated twice, runs off with it.

use super::Cue;
use crate::Result;
use crate::arm::posed::Posed;
use crate::arm::state::{Noise, VELOCITY};
use crate::filter::{Likelihood, Linear};
use crate::particles::ParticleSet;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// The velocity is zero, to within `rest_speed` and a tremor's per axis.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    sd: f64,
}

impl Rest {
    /// Of a wrist that trembles with such a standard deviation of its velocity, m/s per axis.
    pub fn new(tremor: f64, noise: &Noise) -> Self {
        Self { sd: noise.rest_speed.hypot(tremor) }
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

impl Cue for Rest {
    fn linearise(&self, _: &Posed<'_>, state: &DVector<f64>, _: Option<&DMatrix<f64>>) -> Result<Option<Linear>> {
        let slope = DMatrix::from_fn(3, state.len(), |r, c| f64::from(u8::from(c == VELOCITY + r)));
        let noise = DMatrix::from_diagonal_element(3, 3, self.sd * self.sd);
        Ok(Some((-state.rows(VELOCITY, 3), slope, noise)))
    }

    fn is_seen(&self) -> bool {
        false
    }
}
