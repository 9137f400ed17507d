//! How the wrist moves: the inertial motion of eqs (5), (6), composed over all samples since the last frame,
//! and the random walk of eq. (17).
//!
//! Between frames the model is linear and Gaussian, so the motion of any number of samples is one transition
//! matrix, one input and one noise covariance, exactly; it is drawn once. The three axes share everything but
//! the input. From two samples on the noise has full rank, for a single sample rank one per axis.
//!
//! Eq. (6) prints the noise as `(T³/6, T²) f`, where integration would give `(T³/6, T²/2)`; kept as printed.

use super::process::GaussMarkov;
use super::state::{Layout, Noise, POSITION, VELOCITY};
use crate::filter::Transition;
use crate::particles::BlockMut;
use crate::rng::{BLOCK, Stream};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The composed motion of one axis's (position, velocity, bias), for three axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Transition of (position, velocity, bias), the same for every axis.
    pub transition: Matrix3<f64>,
    /// Input: row (position, velocity, bias), column axis.
    pub input: Matrix3<f64>,
    /// Noise covariance of (position, velocity, bias), the same for every axis.
    pub noise: Matrix3<f64>,
    /// Time covered, s.
    pub elapsed_s: f64,
}

/// The powers of less time than this are no numbers, s: it is none.
const LEAST_S: f64 = 1e-100;

impl Motion {
    /// No time, no motion.
    pub fn none() -> Self {
        Self { transition: Matrix3::identity(), input: Matrix3::zeros(), noise: Matrix3::zeros(), elapsed_s: 0.0 }
    }

    /// Append `dt` seconds under the world acceleration of one sample (eq. 6), m/s².
    ///
    /// `density` is the process noise (see [`Noise::accel_density`]), `bias` how the acceleration bias walks.
    pub fn append(&mut self, dt: f64, acceleration: Vector3<f64>, density: f64, bias: Option<GaussMarkov>) {
        if dt < LEAST_S {
            return;
        }
        let (kept, gained) = bias.map_or((1.0, 0.0), |bias| bias.step(dt));
        let step = Matrix3::new(1.0, dt, -0.5 * dt * dt, 0.0, 1.0, -dt, 0.0, 0.0, kept);
        let gain = Vector3::new(0.5 * dt * dt, dt, 0.0);
        // sigma_f = density / T^1.5 in front of (T³/6, T²).
        let reach = Vector3::new(dt * dt * dt / 6.0, dt * dt, 0.0) * (density / dt.powf(1.5));
        self.transition = step * self.transition;
        self.input = step * self.input + gain * acceleration.transpose();
        self.noise = step * self.noise * step.transpose() + reach * reach.transpose();
        self.noise[(2, 2)] += gained;
        self.elapsed_s += dt;
    }

    /// The lower factor of the noise, clamped where it has less than full rank.
    fn factor(&self) -> Matrix3<f64> {
        let mut l = Matrix3::zeros();
        for c in 0..3 {
            let rest = self.noise[(c, c)] - (0..c).map(|k| l[(c, k)] * l[(c, k)]).sum::<f64>();
            // Below this share of the variance the rest is rounding, not noise.
            if rest <= 1e-13 * self.noise[(c, c)] {
                continue;
            }
            let pivot = rest.sqrt();
            l[(c, c)] = pivot;
            for r in c + 1..3 {
                l[(r, c)] = (self.noise[(r, c)] - (0..c).map(|k| l[(r, k)] * l[(c, k)]).sum::<f64>()) / pivot;
            }
        }
        l
    }
}

/// [`Motion`] on the columns of a state, with what the patch offset does.
#[derive(Debug, Clone)]
pub struct InertialMotion {
    motion: Motion,
    factor: Matrix3<f64>,
    layout: Layout,
    offset_kept: f64,
    offset_sd: f64,
}

impl InertialMotion {
    /// Of the motion since the last frame.
    pub fn new(motion: Motion, layout: Layout, noise: &Noise) -> Self {
        let (offset_kept, gained) = noise.patch_offset.map_or((1.0, 0.0), |offset| offset.step(motion.elapsed_s));
        Self { factor: motion.factor(), motion, layout, offset_kept, offset_sd: gained.sqrt() }
    }

    /// As matrices over the whole state: transition `(D, D)`, input `(D,)`, noise `(D, D)`.
    pub fn matrices(&self) -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>) {
        let dim = self.layout.dim;
        let (mut transition, mut input, mut noise) =
            (DMatrix::identity(dim, dim), DVector::zeros(dim), DMatrix::zeros(dim, dim));
        for axis in 0..3 {
            let columns = self.columns(axis);
            for (r, &row) in columns.iter().enumerate() {
                input[row] = self.motion.input[(r, axis)];
                for (c, &column) in columns.iter().enumerate() {
                    transition[(row, column)] = self.motion.transition[(r, c)];
                    noise[(row, column)] = self.motion.noise[(r, c)];
                }
            }
            if let Some(offset) = self.layout.patch_offset {
                transition[(offset + axis, offset + axis)] = self.offset_kept;
                noise[(offset + axis, offset + axis)] = self.offset_sd * self.offset_sd;
            }
        }
        (transition, input, noise)
    }

    /// The columns of one axis that move together: position, velocity and, where there, bias.
    fn columns(&self, axis: usize) -> Vec<usize> {
        [Some(POSITION), Some(VELOCITY), self.layout.bias].into_iter().flatten().map(|c| c + axis).collect()
    }

    /// Move without noise: the mean of the transition.
    pub fn move_mean(&self, mut block: BlockMut<'_>) {
        let (a, u) = (&self.motion.transition, &self.motion.input);
        for axis in 0..3 {
            if let Some(bias) = self.layout.bias {
                let [p, v, b] = block.columns_mut([POSITION + axis, VELOCITY + axis, bias + axis]);
                for i in 0..p.len() {
                    p[i] += a[(0, 1)] * v[i] + a[(0, 2)] * b[i] + u[(0, axis)];
                    v[i] += a[(1, 2)] * b[i] + u[(1, axis)];
                    b[i] *= a[(2, 2)];
                }
            } else {
                let [p, v] = block.columns_mut([POSITION + axis, VELOCITY + axis]);
                for i in 0..p.len() {
                    p[i] += a[(0, 1)] * v[i] + u[(0, axis)];
                    v[i] += u[(1, axis)];
                }
            }
            if let Some(offset) = self.layout.patch_offset {
                block.column_mut(offset + axis).iter_mut().for_each(|x| *x *= self.offset_kept);
            }
        }
    }
}

impl Transition for InertialMotion {
    fn propagate(&self, mut block: BlockMut<'_>, rng: &mut Stream) {
        let len = block.len();
        self.move_mean(block.reborrow());
        let l = &self.factor;
        let mut z = [[0.0; BLOCK]; 3];
        for axis in 0..3 {
            let columns = self.columns(axis);
            for z in &mut z[..columns.len()] {
                standard_normal(&mut z[..len], rng);
            }
            for (r, column) in columns.iter().enumerate() {
                let x = block.column_mut(*column);
                for (c, z) in z[..=r].iter().enumerate() {
                    let scale = l[(r, c)];
                    for i in 0..len {
                        x[i] += scale * z[i];
                    }
                }
            }
        }
        if let Some(offset) = self.layout.patch_offset {
            for axis in 0..3 {
                add_normal(block.column_mut(offset + axis), self.offset_sd, rng);
            }
        }
    }

    /// Eq. (10).
    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        let (transition, input, noise) = self.matrices();
        let (density, to) = (InRange::new(noise), DVector::from_column_slice(to) - input);
        for (out, from) in out.iter_mut().zip(from.chunks(to.len())) {
            *out = density.log_density(&(&to - &transition * DVector::from_column_slice(from)));
        }
    }
}

/// Eq. (17): the position walks, nothing else moves.
#[derive(Debug, Clone, Copy)]
pub struct RandomWalk {
    /// Standard deviation per axis, m.
    pub sd: f64,
}

impl Transition for RandomWalk {
    fn propagate(&self, mut block: BlockMut<'_>, rng: &mut Stream) {
        for axis in 0..3 {
            add_normal(block.column_mut(POSITION + axis), self.sd, rng);
        }
    }

    /// Eq. (18), whose index `k+1` is a misprint for `k`.
    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        let variance = |d: usize| if d < POSITION + 3 { self.sd * self.sd } else { 0.0 };
        let density = InRange::new(DMatrix::from_fn(to.len(), to.len(), |r, c| if r == c { variance(r) } else { 0.0 }));
        for (out, from) in out.iter_mut().zip(from.chunks(to.len())) {
            *out = density.log_density(&DVector::from_iterator(to.len(), to.iter().zip(from).map(|(t, f)| t - f)));
        }
    }
}

/// A normal density about 0 within the range of its covariance.
struct InRange {
    variances: DVector<f64>,
    axes: DMatrix<f64>,
    /// A direction of less variance has none.
    least: f64,
}

/// So far beside the range of the noise is rounding, m and m/s.
const ROUNDING: f64 = 1e-9;

impl InRange {
    fn new(noise: DMatrix<f64>) -> Self {
        let eigen = noise.symmetric_eigen();
        let least = eigen.eigenvalues.max() * 1e-13;
        Self { variances: eigen.eigenvalues, axes: eigen.eigenvectors.transpose(), least }
    }

    /// Minus infinity beside the range.
    fn log_density(&self, rest: &DVector<f64>) -> f64 {
        let along = &self.axes * rest;
        let of_axis = |(variance, x): (&f64, &f64)| {
            if *variance > self.least {
                -0.5 * (x * x / variance + (TAU * variance).ln())
            } else if x.abs() <= ROUNDING {
                0.0
            } else {
                f64::NEG_INFINITY
            }
        };
        self.variances.iter().zip(along.iter()).map(of_axis).sum()
    }
}

fn standard_normal(out: &mut [f64], rng: &mut Stream) {
    // A generator of its own lets its state stay in registers.
    let mut own = rng.clone();
    for z in out {
        *z = own.sample(StandardNormal);
    }
    *rng = own;
}

fn add_normal(out: &mut [f64], sd: f64, rng: &mut Stream) {
    let mut own = rng.clone();
    for x in out {
        let z: f64 = own.sample(StandardNormal);
        *x += sd * z;
    }
    *rng = own;
}
