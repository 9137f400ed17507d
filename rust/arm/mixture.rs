//! The arm as a mixture of Gaussians over the state of a worn sensor: both depths at which a viewing ray meets the elbow's
//! sphere are components, and what is wrong with orientation, shoulder and patch is part of the state.
//!
//! Not in the paper. The columns are position, velocity, bias (sensor frame), orientation error (world), then, where
//! they are estimated, patch offset (sensor frame) and shoulder displacement (world).

use super::colour::Sighting;
use super::particle::Frame;
use super::pause::Stretch;
use super::state::{Arm, Estimate, Layout, Noise, POSITION, Point, VELOCITY};
use super::worn::WornMotion;
use crate::filter::{Component, Gaussian, Linear, Mixture, Reduction};
use crate::quaternion::Quaternion;
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// A component splits where the second order of the arm's length exceeds this share of the length's standard deviation.
const BENT: f64 = 0.2;
/// There may be so many times the components that are kept, while they are split; then they are merged.
const SPLIT_TO: usize = 2;
const MERGE_WITHIN: f64 = 0.5;
const LEAST_WEIGHT: f64 = 1e-4;
/// How often a measurement is linearised again.
const TIMES: usize = 3;
/// A sighting farther off than this (squared, in standard deviations) is trusted less, as a Student's t would.
const ROBUST: f64 = 9.0;
/// A stretch of a ray as so many components.
const ON_STRETCH: usize = 9;

/// A mixture filter of the arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmMixture {
    layout: Layout,
    /// Whether the arm's length and rest are among what corrects it.
    is_held: bool,
    is_rested: bool,
    /// Components that are kept.
    most: usize,
    state: Mixture,
}

/// What a measurement reads of a frame, the same for all components.
struct Seen<'a> {
    layout: Layout,
    arm: &'a Arm,
    noise: &'a Noise,
    frame: &'a Frame<'a>,
    world_sensor: Matrix3<f64>,
    /// Wrist to elbow in the world, as measured.
    forearm: Vector3<f64>,
}

impl ArmMixture {
    /// About the arm's start; at most `most` components: with one it is an iterated extended Kalman filter; `is_held` by
    /// the arm's length, `is_rested`: still while the IMU is.
    pub fn new(arm: &Arm, noise: &Noise, is_held: bool, is_rested: bool, most: usize) -> Self {
        let layout = Layout::new(noise);
        let (mean, sd) = layout.start(arm, noise);
        let covariance = DMatrix::from_diagonal(&sd.component_mul(&sd));
        Self { layout, is_held, is_rested, most, state: Mixture::new(Gaussian { mean, covariance }) }
    }

    /// Whether the arm's length holds it.
    pub fn is_held_by_arm(&self) -> bool {
        self.is_held
    }

    /// How many components there are.
    pub fn components(&self) -> usize {
        self.state.components().len()
    }

    /// Start again somewhere on a stretch; what is known of bias, orientation and patch is kept.
    pub fn start_again(&mut self, arm: &Arm, noise: &Noise, stretch: &Stretch) {
        let (mut mean, mut covariance) = self.state.moments();
        let sd = stretch.sd(self.layout, arm, noise);
        for d in 0..VELOCITY + 3 {
            covariance.row_mut(d).fill(0.0);
            covariance.column_mut(d).fill(0.0);
            covariance[(d, d)] = sd[d] * sd[d];
        }
        mean.fixed_rows_mut::<3>(VELOCITY).fill(0.0);
        // Each as wide as they are apart.
        let share = stretch.half / ON_STRETCH as f64;
        let mut position = covariance.fixed_view_mut::<3, 3>(POSITION, POSITION);
        position += share * share.transpose();
        let component = |k: usize| {
            let along = (2.0 * k as f64 + 1.0) / ON_STRETCH as f64 - 1.0;
            let mut mean = mean.clone();
            mean.fixed_rows_mut::<3>(POSITION).copy_from(&(stretch.middle + along * stretch.half));
            Component { gaussian: Gaussian { mean, covariance: covariance.clone() }, log_weight: 0.0 }
        };
        self.state = Mixture::of((0..ON_STRETCH).map(component).collect());
    }

    /// Predict to the frame, then the patch, the arm's length and rest.
    ///
    /// # Errors
    /// [`Error::Singular`], [`Error::RanAway`].
    pub fn update(&mut self, arm: &Arm, noise: &Noise, frame: &Frame<'_>) -> Result<Estimate> {
        self.predict(frame.worn.as_ref(), noise);
        let seen = Seen::new(self.layout, arm, noise, frame);
        let mut evidence = None;
        for sighting in &frame.sightings {
            let found =
                self.state.correct(frame.time_s, 1, |state, covariance| seen.patch(sighting, state, covariance))?;
            // Of what was seen: a length that is known beforehand is no observation.
            *evidence.get_or_insert(0.0) += found.unwrap_or(0.0);
        }
        if self.is_held {
            self.state.split(SPLIT_TO * self.most + 1, |gaussian| seen.bent(gaussian));
            self.state.correct(frame.time_s, TIMES, |state, covariance| Ok(seen.length(state, covariance)))?;
        }
        if self.is_rested && frame.is_rest {
            self.state.correct(frame.time_s, 1, |state, _| Ok(Some(seen.rest(state))))?;
        }
        self.state.reduce(&Reduction { most: self.most, merge_within: MERGE_WITHIN, least_weight: LEAST_WEIGHT });
        Ok(self.summary(&seen, frame.time_s, evidence))
    }

    /// The estimate after a motion, changing nothing.
    pub fn estimate(
        &self,
        arm: &Arm,
        noise: &Noise,
        time_s: f64,
        worn: Option<&WornMotion>,
        q: Quaternion,
    ) -> Estimate {
        let mut ahead = self.clone();
        ahead.predict(worn, noise);
        let frame = Frame::empty(time_s, q);
        ahead.summary(&Seen::new(self.layout, arm, noise, &frame), time_s, None)
    }

    fn predict(&mut self, worn: Option<&WornMotion>, noise: &Noise) {
        let Some(motion) = worn else { return };
        let others = [
            (self.layout.offset, 3, noise.offset),
            (self.layout.shoulder, 3, noise.shoulder),
            (self.layout.clock, 1, noise.clock),
        ];
        let others: Vec<_> = others.into_iter().filter_map(|(column, width, of)| Some((column?, width, of?))).collect();
        self.state.for_each(|gaussian| motion.predict(&mut gaussian.mean, &mut gaussian.covariance, &others));
    }

    fn summary(&self, seen: &Seen<'_>, time_s: f64, log_evidence: Option<f64>) -> Estimate {
        let (mean, covariance) = self.state.moments();
        let wrist = self.point(|state| seen.wrist(state), 0.0);
        let elbow = self.point(|state| seen.elbow_seen(state), seen.noise.forearm_sd * seen.arm.forearm_m);
        Estimate { time_s, mean, covariance, wrist, elbow, ess: None, log_evidence, doubt: None }
    }

    /// A place and its slope `(3, D)`, as a point with bands; `besides` is a standard deviation that is not in the state.
    fn point(&self, place: impl Fn(&DVector<f64>) -> (Vector3<f64>, DMatrix<f64>), besides: f64) -> Point {
        let parts: Vec<(f64, Vector3<f64>, Vector3<f64>)> = self
            .state
            .components()
            .iter()
            .map(|Component { gaussian, log_weight }| {
                let (mean, slope) = place(&gaussian.mean);
                let spread = &slope * &gaussian.covariance * slope.transpose();
                let sd = Vector3::from_fn(|d, _| spread[(d, d)].max(0.0).sqrt().hypot(besides).max(1e-9));
                (log_weight.exp(), mean, sd)
            })
            .collect();
        let mean: Vector3<f64> = parts.iter().map(|(weight, mean, _)| *weight * mean).sum();
        let axis = |d: usize| parts.iter().map(move |(w, m, sd)| (*w, m[d], sd[d])).collect::<Vec<_>>();
        let variance = |d: usize| axis(d).iter().map(|(w, m, sd)| w * (sd * sd + (m - mean[d]).powi(2))).sum::<f64>();
        let density = |(weight, _, sd): &(f64, Vector3<f64>, Vector3<f64>)| weight / (sd.x * sd.y * sd.z);
        let mode = parts.iter().max_by(|a, b| density(a).total_cmp(&density(b))).map_or(mean, |part| part.1);
        Point {
            mean,
            mode,
            sd: Vector3::from_fn(|d, _| variance(d).sqrt()),
            lo: Vector3::from_fn(|d, _| Mixture::quantile(&axis(d), 0.025)),
            hi: Vector3::from_fn(|d, _| Mixture::quantile(&axis(d), 0.975)),
        }
    }
}

impl<'a> Seen<'a> {
    fn new(layout: Layout, arm: &'a Arm, noise: &'a Noise, frame: &'a Frame<'a>) -> Self {
        let forearm = frame.world_sensor.rotate(arm.elbow_in_sensor());
        Self { layout, arm, noise, frame, world_sensor: frame.world_sensor.to_matrix(), forearm }
    }

    fn by_position(&self) -> DMatrix<f64> {
        let mut slope = DMatrix::zeros(3, self.layout.dim);
        slope.fixed_view_mut::<3, 3>(0, POSITION).copy_from(&Matrix3::identity());
        slope
    }

    /// The wrist when the camera sees it, which is a little later than the IMU's clock says; and its slope `(3, D)`.
    fn wrist(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let (mut wrist, mut slope): (Vector3<f64>, _) = (state.fixed_rows::<3>(POSITION).into(), self.by_position());
        if let Some(column) = self.layout.clock {
            let velocity: Vector3<f64> = state.fixed_rows::<3>(VELOCITY).into();
            wrist += velocity * state[column];
            slope.fixed_view_mut::<3, 3>(0, VELOCITY).copy_from(&(Matrix3::identity() * state[column]));
            slope.fixed_view_mut::<3, 1>(0, column).copy_from(&velocity);
        }
        (wrist, slope)
    }

    /// A vector of the sensor's frame, `arm` in the world as measured: turned by the orientation's error; and its slope.
    fn turned(&self, state: &DVector<f64>, arm: Vector3<f64>) -> (Vector3<f64>, Option<(usize, Matrix3<f64>)>) {
        match self.layout.tilt {
            None => (arm, None),
            Some(column) => {
                let theta: Vector3<f64> = state.fixed_rows::<3>(column).into();
                (arm + theta.cross(&arm), Some((column, -arm.cross_matrix())))
            }
        }
    }

    /// The elbow when the camera sees the wrist, and its slope `(3, D)`.
    fn elbow_seen(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let ((elbow, mut slope), (wrist, by_wrist)) = (self.elbow(state), self.wrist(state));
        slope += by_wrist - self.by_position();
        (elbow + wrist - state.fixed_rows::<3>(POSITION), slope)
    }

    /// The elbow by the IMU's clock, world, m, and its slope `(3, D)`.
    fn elbow(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let (forearm, by_tilt) = self.turned(state, self.forearm);
        let mut slope = self.by_position();
        if let Some((column, by_tilt)) = by_tilt {
            slope.fixed_view_mut::<3, 3>(0, column).copy_from(&by_tilt);
        }
        (state.fixed_rows::<3>(POSITION) + forearm, slope)
    }

    /// The upper arm, shoulder to elbow, and its slope.
    fn upper_arm(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let (elbow, mut slope) = self.elbow(state);
        let mut shoulder = self.arm.shoulder;
        if let Some(column) = self.layout.shoulder {
            shoulder += state.fixed_rows::<3>(column);
            slope.fixed_view_mut::<3, 3>(0, column).copy_from(&-Matrix3::identity());
        }
        (elbow - shoulder, slope)
    }

    /// The patch's pixel; one that is far off is trusted less.
    fn patch(
        &self,
        sighting: &Sighting<'_>,
        state: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> Result<Option<Linear>> {
        let mut offset = sighting.view.patch_offset;
        if let Some(column) = self.layout.offset {
            offset += state.fixed_rows::<3>(column);
        }
        let (glued, by_tilt) = self.turned(state, self.world_sensor * offset);
        let (wrist, by_state) = self.wrist(state);
        let time_s = self.frame.time_s;
        let seen = sighting.view.camera.project_with_jacobian(wrist + glued);
        let (pixel, by_patch) = seen.ok_or(Error::RanAway { time_s })?;
        let by_state = by_patch * by_state;
        let mut slope = DMatrix::from_fn(2, self.layout.dim, |r, c| by_state[(r, c)]);
        if let Some((column, by_tilt)) = by_tilt {
            slope.fixed_view_mut::<2, 3>(0, column).copy_from(&(by_patch * by_tilt));
        }
        if let Some(column) = self.layout.offset {
            slope.fixed_view_mut::<2, 3>(0, column).copy_from(&(by_patch * self.world_sensor));
        }
        let residual = sighting.pixel - pixel;
        let variance = self.noise.pixel_sd * self.noise.pixel_sd;
        let spread = &slope * covariance * slope.transpose();
        let far = (0..2).map(|d| residual[d] * residual[d] / (variance + spread[(d, d)])).sum::<f64>();
        let noise = DMatrix::from_diagonal_element(2, 2, variance * (far / ROBUST).max(1.0));
        Ok(Some((DVector::from_column_slice(residual.as_slice()), slope, noise)))
    }

    /// The upper arm's length, to second order: a place that is known to within a ball is farther from the shoulder, on
    /// average, than the ball's centre is. None where it has no direction.
    fn length(&self, state: &DVector<f64>, covariance: &DMatrix<f64>) -> Option<Linear> {
        let (upper_arm, by_state) = self.upper_arm(state);
        let length = upper_arm.norm();
        if length <= 0.0 {
            return None;
        }
        let along = upper_arm / length;
        let slope = along.transpose() * &by_state;
        let spread = &by_state * covariance * by_state.transpose();
        let bend = (Matrix3::identity() - along * along.transpose()) / length;
        let bent: Matrix3<f64> = bend * Matrix3::from_fn(|r, c| spread[(r, c)]);
        let (more, more_variance) = (0.5 * bent.trace(), 0.5 * (bent * bent).trace());
        let sd = self.length_sd(along);
        let residual = DVector::from_element(1, self.arm.upper_arm_m - length - more);
        let noise = DMatrix::from_element(1, 1, sd * sd + more_variance);
        Some((residual, DMatrix::from_row_slice(1, self.layout.dim, slope.as_slice()), noise))
    }

    /// Of the length, along the upper arm: itself, and a forearm that lies beside the sensor's axis or has turned unseen.
    fn length_sd(&self, along: Vector3<f64>) -> f64 {
        let turn = self.noise.forearm_sd.hypot(super::length::TURN_RATE * self.frame.stale_s);
        self.noise.arm_length_sd.hypot(turn * along.cross(&self.forearm).norm())
    }

    /// No velocity.
    fn rest(&self, state: &DVector<f64>) -> Linear {
        let slope = DMatrix::from_fn(3, self.layout.dim, |r, c| f64::from(u8::from(c == VELOCITY + r)));
        let noise = DMatrix::from_diagonal_element(3, 3, self.noise.rest_speed * self.noise.rest_speed);
        (-state.rows(VELOCITY, 3), slope, noise)
    }

    /// The direction in which a component is so wide that the arm's length bends over it.
    fn bent(&self, gaussian: &Gaussian) -> Option<DVector<f64>> {
        let spread: Matrix3<f64> = gaussian.covariance.fixed_view::<3, 3>(POSITION, POSITION).into_owned();
        let eigen = spread.symmetric_eigen();
        let widest = eigen.eigenvalues.imax();
        let (variance, direction) = (eigen.eigenvalues[widest], eigen.eigenvectors.column(widest).into_owned());
        let (upper_arm, _) = self.upper_arm(&gaussian.mean);
        let length = upper_arm.norm().max(0.05);
        let across = 1.0 - (upper_arm.dot(&direction) / length).powi(2);
        let sd = self.length_sd(upper_arm / length);
        (0.5 * across * variance / length > BENT * sd).then(|| {
            let mut whole = DVector::zeros(self.layout.dim);
            whole.fixed_rows_mut::<3>(POSITION).copy_from(&direction);
            whole
        })
    }
}
