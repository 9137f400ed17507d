//! The motion of a wrist whose IMU is worn: what is wrong with its orientation moves the wrist too.
//!
//! Not in the paper. An error of the orientation by 1° leaks 0.17 m/s² of gravity into the motion and turns the forearm; an
//! acceleration bias in the world frame knows neither. The state has the bias in the *sensor's* frame and the orientation's
//! error `theta`, a small turn in the world: with `R` measured and `f = R f_s` the specific force, the truth is
//! `(1 + [theta]x) R`, so that `a = f - g + theta x f - R b`. Over the samples since the last frame this is one transition
//! matrix, one input and one noise covariance.

use super::process::GaussMarkov;
use super::state::Noise;
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

    /// Move a Gaussian whose first columns are the core; the others, drawn back by `others` (first column, how many,
    /// process), do not mix.
    pub fn predict(
        &self,
        mean: &mut DVector<f64>,
        covariance: &mut DMatrix<f64>,
        others: &[(usize, usize, GaussMarkov)],
    ) {
        let dim = mean.len();
        let core = self.transition * mean.fixed_rows::<CORE>(0) + self.input;
        mean.fixed_rows_mut::<CORE>(0).copy_from(&core);
        let (mut kept, mut gains) = (DVector::from_element(dim, 1.0), DVector::zeros(dim));
        for (column, width, process) in others {
            let (keep, gained) = process.step(self.elapsed_s);
            for d in *column..column + width {
                (kept[d], gains[d]) = (keep, gained);
                mean[d] *= keep;
            }
        }
        let square =
            self.transition * covariance.fixed_view::<CORE, CORE>(0, 0) * self.transition.transpose() + self.noise;
        let cross = self.transition * covariance.view((0, CORE), (CORE, dim - CORE));
        covariance.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&square);
        for column in CORE..dim {
            for row in 0..CORE {
                let value = cross[(row, column - CORE)] * kept[column];
                covariance[(row, column)] = value;
                covariance[(column, row)] = value;
            }
            for row in CORE..dim {
                covariance[(row, column)] *= kept[row] * kept[column];
            }
            covariance[(column, column)] += gains[column];
        }
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

    /// Moved as one matrix over the whole state, it is the same.
    #[test]
    fn blocks_are_the_whole_matrix() {
        let mut motion = WornMotion::none();
        motion.append(&STEP, &noise());
        motion.append(&Step { dt: 0.013, density: 0.3, ..STEP }, &noise());
        let dim = 15;
        let root = DMatrix::from_fn(dim, dim, |r, c| ((r * 7 + c * 3) % 11) as f64 / 11.0 - 0.4);
        let (mut mean, mut covariance) = (DVector::from_fn(dim, |r, _| r as f64 * 0.1), &root * root.transpose());
        let other = GaussMarkov { start_sd: 0.05, density: 0.06 };
        let (kept, gained) = other.step(motion.elapsed_s);
        let (mut whole, mut added) = (DMatrix::identity(dim, dim), DMatrix::zeros(dim, dim));
        whole.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&motion.transition);
        added.fixed_view_mut::<CORE, CORE>(0, 0).copy_from(&motion.noise);
        for d in CORE..dim {
            (whole[(d, d)], added[(d, d)]) = (kept, gained);
        }
        let expected = &whole * &covariance * whole.transpose() + added;
        let mut expected_mean = &whole * &mean;
        for d in 0..CORE {
            expected_mean[d] += motion.input[d];
        }
        motion.predict(&mut mean, &mut covariance, &[(CORE, 3, other)]);
        assert!((covariance - expected).amax() < 1e-12);
        assert!((mean - expected_mean).amax() < 1e-12);
    }

    /// After a gap in which all of it is forgotten, what is drawn back has the spread of its start, and is a number.
    #[test]
    fn a_long_gap_forgets() {
        let mut motion = WornMotion::none();
        motion.elapsed_s = 1000.0;
        let dim = 15;
        let (mut mean, mut covariance) = (DVector::from_element(dim, 0.02), DMatrix::identity(dim, dim));
        motion.predict(&mut mean, &mut covariance, &[(CORE, 3, GaussMarkov { start_sd: 0.017, density: 0.025 })]);
        assert!(covariance.iter().all(|value| value.is_finite()));
        for d in CORE..dim {
            assert!(mean[d].abs() < 1e-12 && (covariance[(d, d)] - 0.017 * 0.017).abs() < 1e-12);
        }
    }
}
