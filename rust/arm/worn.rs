//! The motion of a wrist whose IMU is worn: what is wrong with its orientation moves the wrist too.
//!
//! Not in the paper. An error of the orientation by 1° leaks 0.17 m/s² of gravity into the motion and turns the forearm; an
//! acceleration bias in the world frame knows neither. The state has the bias in the *sensor's* frame and the orientation's
//! error `theta`, a small turn in the world: with `R` measured and `f = R f_s` the specific force, the truth is
//! `(1 + [theta]x) R`, so that `a = f - g + theta x f - R b`. Over the samples since the last frame this is one transition
//! matrix, one input and one noise covariance.

use super::process::GaussMarkov;
use super::state::{Layout, Noise};
use crate::filter::{Gaussian, LinearTransition, Spread};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};
use serde::{Deserialize, Serialize};

/// Columns that the motion mixes: position, velocity, bias, orientation error.
pub const CORE: usize = 12;
const P: usize = 0;
const V: usize = 3;
const B: usize = 6;
const T: usize = 9;

/// The composed motion since the last frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WornMotion {
    /// Transition of the core columns.
    pub transition: SMatrix<f64, CORE, CORE>,
    /// Input.
    pub input: SVector<f64, CORE>,
    /// Noise covariance.
    pub noise: SMatrix<f64, CORE, CORE>,
    /// Time covered, s.
    pub elapsed_s: f64,
}

/// What holds during a step: specific force and orientation of the sensor, in the world.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Duration, s.
    pub dt: f64,
    /// Acceleration of the wrist as measured, m/s².
    pub acceleration: Vector3<f64>,
    /// Specific force, m/s²; zero where nothing is measured.
    pub force: Vector3<f64>,
    /// Sensor to world.
    pub world_sensor: Matrix3<f64>,
    /// Process noise, m/s/√s.
    pub density: f64,
}

impl WornMotion {
    /// No time, no motion.
    pub fn none() -> Self {
        Self { transition: SMatrix::identity(), input: SVector::zeros(), noise: SMatrix::zeros(), elapsed_s: 0.0 }
    }

    /// Append a step.
    pub fn append(&mut self, step: &Step, noise: &Noise) {
        let Step { dt, acceleration, force, world_sensor, density } = *step;
        let walk = |of: Option<GaussMarkov>| of.map_or((1.0, 0.0), |of| of.step(dt));
        let ((bias_kept, bias_gained), (tilt_kept, tilt_gained)) = (walk(noise.bias), walk(noise.tilt));
        let (by_bias, by_tilt) = (-world_sensor, -force.cross_matrix());
        let mut step = SMatrix::<f64, CORE, CORE>::identity();
        let mut set = |row: usize, column: usize, block: Matrix3<f64>| {
            step.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        set(P, V, Matrix3::identity() * dt);
        set(P, B, by_bias * (0.5 * dt * dt));
        set(P, T, by_tilt * (0.5 * dt * dt));
        set(V, B, by_bias * dt);
        set(V, T, by_tilt * dt);
        set(B, B, Matrix3::identity() * bias_kept);
        set(T, T, Matrix3::identity() * tilt_kept);
        self.transition = step * self.transition;
        self.input = step * self.input;
        let mut input = self.input.fixed_rows_mut::<6>(P);
        for d in 0..3 {
            input[P + d] += 0.5 * dt * dt * acceleration[d];
            input[V + d] += dt * acceleration[d];
        }
        self.noise = step * self.noise * step.transpose();
        // White acceleration, integrated.
        let variance = density * density;
        for d in 0..3 {
            self.noise[(P + d, P + d)] += variance * dt * dt * dt / 3.0;
            self.noise[(P + d, V + d)] += variance * dt * dt / 2.0;
            self.noise[(V + d, P + d)] += variance * dt * dt / 2.0;
            self.noise[(V + d, V + d)] += variance * dt;
            self.noise[(B + d, B + d)] += bias_gained;
            self.noise[(T + d, T + d)] += tilt_gained;
        }
        self.elapsed_s += dt;
    }
}

/// A motion of all columns of a state: those of a worn sensor mix, each of the others is drawn back by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    worn: WornMotion,
    /// What is kept of the others `(D - CORE,)`, and the variance that they gain.
    kept: DVector<f64>,
    gained: DVector<f64>,
}

impl Moved {
    /// Of the columns that `noise` asks for.
    pub fn new(worn: WornMotion, noise: &Noise) -> Self {
        let layout = Layout::new(noise);
        let width = layout.dim - CORE;
        let (mut kept, mut gained) = (DVector::from_element(width, 1.0), DVector::zeros(width));
        for (column, width, process) in layout.others(noise) {
            let (keep, gain) = process.step(worn.elapsed_s);
            kept.rows_mut(column - CORE, width).fill(keep);
            gained.rows_mut(column - CORE, width).fill(gain);
        }
        Self { worn, kept, gained }
    }

    /// Move a Gaussian.
    pub fn predict(&self, Gaussian { mean, covariance }: &mut Gaussian) {
        let WornMotion { transition, input, noise, .. } = &self.worn;
        let core = transition * mean.fixed_rows::<CORE>(0) + input;
        mean.fixed_rows_mut::<CORE>(0).copy_from(&core);
        mean.rows_mut(CORE, self.kept.len()).component_mul_assign(&self.kept);
        let square = transition * covariance.fixed_view::<CORE, CORE>(0, 0) * transition.transpose() + noise;
        covariance.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&square);
        for (c, (kept, gained)) in self.kept.iter().zip(&self.gained).enumerate() {
            let column = CORE + c;
            let cross = transition * covariance.fixed_view::<CORE, 1>(0, column) * *kept;
            covariance.fixed_view_mut::<CORE, 1>(0, column).copy_from(&cross);
            covariance.fixed_view_mut::<1, CORE>(column, 0).copy_from(&cross.transpose());
            for (r, other) in self.kept.iter().enumerate() {
                covariance[(CORE + r, column)] *= other * kept;
            }
            covariance[(column, column)] += gained;
        }
    }

    /// How it leads from one state to the next.
    pub fn transition(&self) -> LinearTransition {
        let mixed = DMatrix::from_column_slice(CORE, CORE, self.worn.transition.as_slice());
        LinearTransition { mixed, kept: self.kept.clone() }
    }

    /// The spread of the columns that mix.
    pub fn spread(&self) -> Spread {
        Spread::new(&DMatrix::from_column_slice(CORE, CORE, self.worn.noise.as_slice()))
    }

    /// How surprising it is to come from one state to another: squared, in standard deviations; `spread` is [`Self::spread`].
    pub fn surprise(&self, spread: &Spread, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
        let moved = self.worn.transition * from.fixed_rows::<CORE>(0) + self.worn.input;
        let core = to.fixed_rows::<CORE>(0) - moved;
        let others = self.kept.iter().zip(&self.gained).enumerate().filter(|(_, (_, gained))| **gained > 0.0);
        let off = others.map(|(d, (kept, gained))| (to[CORE + d] - kept * from[CORE + d]).powi(2) / gained);
        spread.surprise(&DVector::from_column_slice(core.as_slice())) + off.sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Step = Step {
        dt: 0.01,
        acceleration: Vector3::new(0.3, -0.2, 0.1),
        force: Vector3::new(0.3, -0.2, 9.9),
        world_sensor: Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        density: 0.1,
    };

    fn noise() -> Noise {
        let walk = |start_sd, density| Some(GaussMarkov { start_sd, density });
        Noise { bias: walk(0.1, 0.01), tilt: walk(0.03, 0.01), ..Noise::default() }
    }

    /// A turn of `theta` takes gravity into the motion, a bias in the sensor's x is one in the world's y.
    #[test]
    fn gravity_leaks_by_the_turn_and_a_bias_by_the_sensor() {
        let mut motion = WornMotion::none();
        for _ in 0..100 {
            motion.append(&STEP, &noise());
        }
        let mut state = SVector::<f64, CORE>::zeros();
        state[T] = 0.01;
        let moved = motion.transition * state;
        // theta x f of a turn about x: -y f_z 0.01.
        assert!((moved[V + 1] + 0.01 * 9.9).abs() < 0.01 * 9.9 * 0.06, "{}", moved[V + 1]);
        let mut state = SVector::<f64, CORE>::zeros();
        state[B] = 0.1;
        let moved = motion.transition * state;
        assert!((moved[V + 1] + 0.1).abs() < 0.002 && moved[V].abs() < 1e-12);
        assert!((moved[P + 1] + 0.05).abs() < 0.002);
    }

    /// The core and a shoulder's displacement.
    fn moved(motion: WornMotion, shoulder: GaussMarkov) -> Moved {
        Moved::new(motion, &Noise { shoulder: Some(shoulder), ..noise() })
    }

    /// Moved as one matrix over the whole state, it is the same; forward, back, and by its density.
    #[test]
    fn blocks_are_the_whole_matrix() {
        let mut motion = WornMotion::none();
        motion.append(&STEP, &noise());
        motion.append(&Step { dt: 0.013, density: 0.3, ..STEP }, &noise());
        let dim = 15;
        let root = DMatrix::from_fn(dim, dim, |r, c| ((r * 7 + c * 3) % 11) as f64 / 11.0 - 0.4);
        let (mean, covariance) = (DVector::from_fn(dim, |r, _| r as f64 * 0.1), &root * root.transpose());
        let other = GaussMarkov { start_sd: 0.05, density: 0.06 };
        let (kept, gained) = other.step(motion.elapsed_s);
        let (mut whole, mut added) = (DMatrix::identity(dim, dim), DMatrix::zeros(dim, dim));
        whole.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&motion.transition);
        added.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&motion.noise);
        for d in CORE..dim {
            (whole[(d, d)], added[(d, d)]) = (kept, gained);
        }
        let expected = &whole * &covariance * whole.transpose() + &added;
        let mut expected_mean = &whole * &mean;
        for d in 0..CORE {
            expected_mean[d] += motion.input[d];
        }
        let moved = moved(motion, other);
        let (from, to) = (mean.clone(), DVector::from_fn(dim, |r, _| expected_mean[r] + 1e-3 * (r as f64).sin()));
        let mut state = Gaussian { mean, covariance };
        moved.predict(&mut state);
        assert!((state.covariance - expected).amax() < 1e-12);
        assert!((state.mean - &expected_mean).amax() < 1e-12);
        let found = moved.surprise(&moved.spread(), &from, &to);
        assert!((found / Spread::new(&added).surprise(&(to - expected_mean)) - 1.0).abs() < 1e-6);
        let LinearTransition { mixed, kept: each } = moved.transition();
        assert!(mixed == whole.view((0, 0), (CORE, CORE)) && each == DVector::from_element(3, kept));
    }

    /// After a gap in which all of it is forgotten, what is drawn back has the spread of its start, and is a number.
    #[test]
    fn a_long_gap_forgets() {
        let mut motion = WornMotion::none();
        motion.elapsed_s = 1000.0;
        let dim = 15;
        let mut state = Gaussian { mean: DVector::from_element(dim, 0.02), covariance: DMatrix::identity(dim, dim) };
        moved(motion, GaussMarkov { start_sd: 0.017, density: 0.025 }).predict(&mut state);
        assert!(state.covariance.iter().all(|value| value.is_finite()));
        for d in CORE..dim {
            assert!(state.mean[d].abs() < 1e-12 && (state.covariance[(d, d)] - 0.017 * 0.017).abs() < 1e-12);
        }
    }
}
