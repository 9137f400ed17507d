//! What a frame measures of a worn arm's state, each with its slope: the patch's pixel, the upper arm's length, rest.
//!
//! Not in the paper. The state is that of [`super::mixture`]; a slope is a derivative by all its columns.

use super::colour::Sighting;
use super::frame::Frame;
use super::setup::{MOUNT, OF_ARM, PER_CAMERA, SHOULDER, SeenBy, seen_by};
use super::state::{Arm, Layout, Noise, POSITION, VELOCITY};
use crate::filter::{Gaussian, Linear};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, Matrix2x3, Matrix3, Vector2, Vector3};

/// What a measurement reads of a frame, the same for all components.
pub struct Seen<'a> {
    /// Which columns its state has.
    pub(super) layout: Layout,
    /// The arm.
    pub arm: &'a Arm,
    /// What noise is assumed.
    pub noise: &'a Noise,
    frame: &'a Frame<'a>,
    world_sensor: Matrix3<f64>,
    /// Wrist to elbow in the world, as measured.
    forearm: Vector3<f64>,
}

/// A component splits where the second order of the arm's length exceeds this share of the length's standard deviation.
const BENT: f64 = 0.2;
/// A sighting farther off than this (squared, in standard deviations) is trusted less, as a Student's t would.
const ROBUST: f64 = 9.0;

/// A column of the state, and what moves by it.
type ByColumn = (usize, Vector3<f64>);

impl<'a> Seen<'a> {
    /// Of a frame.
    pub fn new(layout: Layout, arm: &'a Arm, noise: &'a Noise, frame: &'a Frame<'a>) -> Self {
        let forearm = frame.world_sensor.rotate(arm.elbow_in_sensor());
        Self { layout, arm, noise, frame, world_sensor: frame.world_sensor.to_matrix(), forearm }
    }

    fn by_position(&self) -> DMatrix<f64> {
        let mut slope = DMatrix::zeros(3, self.layout.dim);
        slope.fixed_view_mut::<3, 3>(0, POSITION).copy_from(&Matrix3::identity());
        slope
    }

    /// The wrist when the camera sees it, which is a little later than the IMU's clock says; and its slope `(3, D)`. To second
    /// order: along its tangent alone a circling wrist would circle wider the later it is seen.
    pub fn wrist(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let (mut wrist, mut slope): (Vector3<f64>, _) = (state.fixed_rows::<3>(POSITION).into(), self.by_position());
        if let Some(column) = self.layout.clock {
            let velocity: Vector3<f64> = state.fixed_rows::<3>(VELOCITY).into();
            let later = self.frame.acceleration * state[column];
            wrist += (velocity + 0.5 * later) * state[column];
            slope.fixed_view_mut::<3, 3>(0, VELOCITY).copy_from(&(Matrix3::identity() * state[column]));
            slope.fixed_view_mut::<3, 1>(0, column).copy_from(&(velocity + later));
        }
        (wrist, slope)
    }

    /// The small turn by which the orientation is off.
    fn turn(&self, state: &DVector<f64>) -> Matrix3<f64> {
        let theta = self.layout.tilt.map_or_else(Vector3::zeros, |column| state.fixed_rows::<3>(column).into());
        Matrix3::identity() + theta.cross_matrix()
    }

    /// A vector of the sensor's frame, `arm` in the world as measured: turned by the orientation's error; and its slope.
    fn turned(&self, state: &DVector<f64>, arm: Vector3<f64>) -> (Vector3<f64>, Option<(usize, Matrix3<f64>)>) {
        (self.turn(state) * arm, self.layout.tilt.map(|column| (column, -arm.cross_matrix())))
    }

    /// Wrist to elbow in the world by the orientation as measured: as long as it is, and beside the sensor's axis as it lies;
    /// and its slope by columns.
    fn forearm(&self, state: &DVector<f64>) -> (Vector3<f64>, Option<[ByColumn; 3]>) {
        let Some(first) = self.layout.setup else { return (self.forearm, None) };
        let length = self.arm.forearm_m + state[first + 1];
        let [x, y, z]: [Vector3<f64>; 3] = std::array::from_fn(|d| self.world_sensor.column(d).into());
        let along = y + z * state[first + MOUNT] - x * state[first + MOUNT + 1];
        let slope = [(first + 1, along), (first + MOUNT, z * length), (first + MOUNT + 1, -x * length)];
        (along * length, Some(slope))
    }

    /// The elbow when the camera sees the wrist, and its slope `(3, D)`.
    pub fn elbow_seen(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let ((elbow, mut slope), (wrist, by_wrist)) = (self.elbow(state), self.wrist(state));
        slope += by_wrist - self.by_position();
        (elbow + wrist - state.fixed_rows::<3>(POSITION), slope)
    }

    /// The elbow by the IMU's clock, world, m, and its slope `(3, D)`.
    fn elbow(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let (lies, by_setup) = self.forearm(state);
        let (forearm, by_tilt) = self.turned(state, lies);
        let mut slope = self.by_position();
        if let Some((column, by_tilt)) = by_tilt {
            slope.fixed_view_mut::<3, 3>(0, column).copy_from(&by_tilt);
        }
        for (column, by_column) in by_setup.into_iter().flatten() {
            slope.fixed_view_mut::<3, 1>(0, column).copy_from(&(self.turn(state) * by_column));
        }
        (state.fixed_rows::<3>(POSITION) + forearm, slope)
    }

    /// The shoulder, world, m, and its slope `(3, D)`.
    pub(super) fn shoulder(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let (mut shoulder, mut slope) = (self.arm.shoulder, DMatrix::zeros(3, self.layout.dim));
        let place = self.layout.setup.map(|column| column + SHOULDER);
        for column in self.layout.shoulder.into_iter().chain(place) {
            shoulder += state.fixed_rows::<3>(column);
            slope.fixed_view_mut::<3, 3>(0, column).copy_from(&Matrix3::identity());
        }
        (shoulder, slope)
    }

    /// The upper arm, shoulder to elbow, and its slope.
    pub(super) fn upper_arm(&self, state: &DVector<f64>) -> (Vector3<f64>, DMatrix<f64>) {
        let ((elbow, by_elbow), (shoulder, by_shoulder)) = (self.elbow(state), self.shoulder(state));
        (elbow - shoulder, by_elbow - by_shoulder)
    }

    /// Covariance of an elbow whose forearm lies beside the sensor's axis, `(3, 3)` m².
    pub(super) fn beside_forearm(&self) -> Matrix3<f64> {
        let along = self.forearm.normalize();
        (Matrix3::identity() - along * along.transpose()) * (self.noise.forearm_sd * self.arm.forearm_m).powi(2)
    }

    /// Where a camera sees a place, with its slopes by the place `(2, 3)` and by the state `(2, D)`.
    ///
    /// # Errors
    /// [`Error::RanAway`]: it is behind the camera.
    pub(super) fn pixel(
        &self,
        sighting: &Sighting<'_>,
        state: &DVector<f64>,
        place: Vector3<f64>,
        by_state: &DMatrix<f64>,
    ) -> Result<(Vector2<f64>, Matrix2x3<f64>, DMatrix<f64>)> {
        let first = self.layout.setup.map(|column| column + OF_ARM + PER_CAMERA * sighting.camera);
        let seen = match first {
            Some(first) => seen_by(sighting.view, &state.rows(first, PER_CAMERA).into_owned(), place),
            None => SeenBy::rightly(sighting.view, place),
        };
        let SeenBy { pixel, by_point, by_camera } = seen.ok_or(Error::RanAway { time_s: self.frame.time_s })?;
        let of_place = by_point * by_state;
        let mut slope = DMatrix::from_fn(2, self.layout.dim, |r, c| of_place[(r, c)]);
        if let Some(first) = first {
            slope.columns_mut(first, PER_CAMERA).copy_from(&by_camera);
        }
        Ok((pixel, by_point, slope))
    }

    /// The same of a place beside the shoulder, along the slopes at the shoulder as it was measured. Were its depth and the camera
    /// to scale how it moves, which nothing else measures, a smoother would bring both nearer: less movement is likelier.
    ///
    /// # Errors
    /// As [`Seen::pixel`].
    pub(super) fn pixel_beside_shoulder(
        &self,
        sighting: &Sighting<'_>,
        state: &DVector<f64>,
        place: Vector3<f64>,
        by_state: &DMatrix<f64>,
    ) -> Result<(Vector2<f64>, DMatrix<f64>)> {
        let rightly = DVector::zeros(PER_CAMERA);
        let shoulder = self.arm.shoulder;
        let seen = seen_by(sighting.view, &rightly, shoulder).ok_or(Error::RanAway { time_s: self.frame.time_s })?;
        let mut pixel = seen.pixel + seen.by_point * (place - shoulder);
        let of_place = seen.by_point * by_state;
        let mut slope = DMatrix::from_fn(2, self.layout.dim, |r, c| of_place[(r, c)]);
        if let Some(first) = self.layout.setup.map(|column| column + OF_ARM + PER_CAMERA * sighting.camera) {
            pixel += &seen.by_camera * state.rows(first, PER_CAMERA);
            slope.columns_mut(first, PER_CAMERA).copy_from(&seen.by_camera);
        }
        Ok((pixel, slope))
    }

    /// The patch's pixel; one that is far off is trusted less. `covariance`: of the state, where it is no single place.
    ///
    /// # Errors
    /// [`Error::RanAway`]: it is behind the camera.
    pub fn patch(
        &self,
        sighting: &Sighting<'_>,
        state: &DVector<f64>,
        covariance: Option<&DMatrix<f64>>,
    ) -> Result<Option<Linear>> {
        let mut offset = sighting.view.patch_offset;
        if let Some(column) = self.layout.offset {
            offset += state.fixed_rows::<3>(column);
        }
        let (glued, by_tilt) = self.turned(state, self.world_sensor * offset);
        let (wrist, by_state) = self.wrist(state);
        let (pixel, by_patch, mut slope) = self.pixel(sighting, state, wrist + glued, &by_state)?;
        if let Some((column, by_tilt)) = by_tilt {
            slope.fixed_view_mut::<2, 3>(0, column).copy_from(&(by_patch * by_tilt));
        }
        if let Some(column) = self.layout.offset {
            slope.fixed_view_mut::<2, 3>(0, column).copy_from(&(by_patch * self.turn(state) * self.world_sensor));
        }
        let residual = DVector::from_column_slice((sighting.pixel - pixel).as_slice());
        let noise = DMatrix::from_diagonal_element(2, 2, self.noise.pixel_sd * self.noise.pixel_sd);
        Ok(Some(trusted_less(residual, slope, noise, covariance)))
    }

    /// The upper arm's length, to second order: a place that is known to within a ball is farther from the shoulder, on
    /// average, than the ball's centre is. None where it has no direction.
    pub fn length(&self, state: &DVector<f64>, covariance: Option<&DMatrix<f64>>) -> Option<Linear> {
        let (upper_arm, by_state) = self.upper_arm(state);
        let length = upper_arm.norm();
        if length <= 0.0 {
            return None;
        }
        let along = upper_arm / length;
        let mut slope = along.transpose() * &by_state;
        let (more, more_variance) = covariance.map_or((0.0, 0.0), |covariance| {
            let spread = &by_state * covariance * by_state.transpose();
            let bend = (Matrix3::identity() - along * along.transpose()) / length;
            let bent: Matrix3<f64> = bend * Matrix3::from_fn(|r, c| spread[(r, c)]);
            (0.5 * bent.trace(), 0.5 * (bent * bent).trace())
        });
        let sd = self.length_sd(along);
        let mut residual = DVector::from_element(1, self.arm.upper_arm_m - length - more);
        if let Some(column) = self.layout.setup {
            residual[0] += state[column];
            slope[column] -= 1.0;
        }
        let noise = DMatrix::from_element(1, 1, sd * sd + more_variance);
        Some((residual, DMatrix::from_row_slice(1, self.layout.dim, slope.as_slice()), noise))
    }

    /// Of the length, along the upper arm: itself, and a forearm that lies beside the sensor's axis or has turned unseen.
    fn length_sd(&self, along: Vector3<f64>) -> f64 {
        let turn = self.noise.forearm_sd.hypot(super::length::TURN_RATE * self.frame.stale_s);
        self.noise.arm_length_sd.hypot(turn * along.cross(&self.forearm).norm())
    }

    /// No velocity.
    pub fn rest(&self, state: &DVector<f64>) -> Linear {
        let slope = DMatrix::from_fn(3, self.layout.dim, |r, c| f64::from(u8::from(c == VELOCITY + r)));
        let noise = DMatrix::from_diagonal_element(3, 3, self.noise.rest_speed * self.noise.rest_speed);
        (-state.rows(VELOCITY, 3), slope, noise)
    }

    /// The direction in which a component is so wide that the arm's length bends over it.
    pub fn bent(&self, gaussian: &Gaussian) -> Option<DVector<f64>> {
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

/// A measurement with more noise the farther it is off, as a Student's t would have it. `covariance`: of the state.
pub(super) fn trusted_less(
    residual: DVector<f64>,
    slope: DMatrix<f64>,
    noise: DMatrix<f64>,
    covariance: Option<&DMatrix<f64>>,
) -> Linear {
    let spread = |d: usize| covariance.map_or(0.0, |of| (slope.row(d) * of).dot(&slope.row(d)));
    let far = (0..residual.len()).map(|d| residual[d] * residual[d] / (noise[(d, d)] + spread(d))).sum::<f64>();
    let wider = (far / ROBUST).max(1.0);
    (residual, slope, noise * wider)
}

#[cfg(test)]
mod tests {
    use super::super::landmark::{Joint, Landmark};
    use super::super::setup::Setup;
    use super::super::state::{GaussMarkov, View};
    use super::super::upper_arm::Direction;
    use super::*;
    use crate::camera::Camera;
    use crate::quaternion::Quaternion;

    const STEP: f64 = 1e-6;

    fn noise() -> Noise {
        let some = |start_sd| Some(GaussMarkov { start_sd, density: 0.01 });
        let (bias, tilt, offset) = (some(0.1), some(0.02), some(0.01));
        let setup = Setup {
            upper_arm_sd: 0.01,
            forearm_sd: 0.02,
            shoulder_sd: 0.02,
            mount_sd: 0.05,
            turn_sd: 0.01,
            distance_sd: 0.05,
            focal_sd: 0.02,
            cameras: 2,
        };
        let (shoulder, clock, setup) = (some(0.02), some(0.05), Some(setup));
        let (landmarks, upper_arm) = ([some(0.03), some(0.03)], some(0.05));
        Noise { bias, offset, tilt, shoulder, landmarks, upper_arm, clock, setup, forearm_sd: 0.08, ..Noise::default() }
    }

    fn arm() -> Arm {
        let shoulder = Vector3::new(0.1, -0.05, 0.2);
        Arm { shoulder, upper_arm_m: 0.3, forearm_m: 0.25, wrist_start: Vector3::new(0.2, 0.1, -0.1) }
    }

    fn view() -> View {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 650.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        View { camera, patch_offset: Vector3::new(0.02, -0.01, 0.03) }
    }

    /// Some state in which nothing is zero.
    fn state(layout: Layout) -> DVector<f64> {
        DVector::from_fn(layout.dim, |d, _| 0.03 * (1.7 * d as f64 + 0.4).sin() + if d < 6 { 0.15 } else { 0.0 })
    }

    fn with_seen(check: impl Fn(&Seen<'_>, &Sighting<'_>)) {
        let (arm, noise, view) = (arm(), noise(), view());
        let empty = Frame::empty(1.0, Quaternion::from_wxyz([0.5, 0.1, -0.7, 0.5]));
        let frame = Frame { acceleration: Vector3::new(1.0, -2.0, 3.0), ..empty };
        let seen = Seen::new(Layout::new(&noise), &arm, &noise, &frame);
        check(&seen, &Sighting { view: &view, camera: 1, pixel: Vector2::new(300.0, 250.0) });
    }

    /// What falls in the residual as a column grows is the slope.
    fn is_slope_of(residual: impl Fn(&DVector<f64>) -> DVector<f64>, slope: &DMatrix<f64>, at: &DVector<f64>) {
        for d in 0..at.len() {
            let (mut more, mut less) = (at.clone(), at.clone());
            more[d] += STEP;
            less[d] -= STEP;
            let falls = (residual(&less) - residual(&more)) / (2.0 * STEP);
            assert!((falls - slope.column(d)).amax() < 1e-5 * (1.0 + slope.amax()), "column {d}");
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        with_seen(|seen, sighting| {
            let at = state(seen.layout);
            let views = [view(), view()];
            let patch = |x: &DVector<f64>| seen.patch(sighting, x, None).unwrap().unwrap();
            is_slope_of(|x| patch(x).0, &patch(&at).1, &at);
            let length = |x: &DVector<f64>| seen.length(x, None).unwrap();
            is_slope_of(|x| length(x).0, &length(&at).1, &at);
            is_slope_of(|x| seen.rest(x).0, &seen.rest(&at).1, &at);
            for joint in [Joint::Shoulder, Joint::Elbow] {
                let landmark = Landmark { joint, camera: 1, pixel: sighting.pixel, sd: 3.0 };
                let landmark = landmark.seen_by(&views);
                let seen = |x: &DVector<f64>| seen.landmark(&landmark, x, None).unwrap().unwrap();
                is_slope_of(|x| seen(x).0, &seen(&at).1, &at);
            }
            let to_shoulder = Vector3::new(0.3, -0.2, 0.9).normalize();
            let direction =
                |x: &DVector<f64>| seen.direction(&Direction { time_s: 1.0, to_shoulder, sd: 0.05 }, x, None);
            is_slope_of(|x| direction(x).0, &direction(&at).1, &at);
            let place = |(place, _): (Vector3<f64>, DMatrix<f64>)| DVector::from_column_slice((-place).as_slice());
            is_slope_of(|x| place(seen.elbow_seen(x)), &seen.elbow_seen(&at).1, &at);
        });
    }

    /// A place known to within a ball is farther off, and by a length less known, than its middle: by quadrature.
    #[test]
    fn the_length_is_of_second_order() {
        with_seen(|seen, _| {
            let (at, sd) = (state(seen.layout), 0.03);
            let mut covariance = DMatrix::zeros(seen.layout.dim, seen.layout.dim);
            covariance.fixed_view_mut::<3, 3>(POSITION, POSITION).fill_diagonal(sd * sd);
            let (known, unknown) = (seen.length(&at, None).unwrap(), seen.length(&at, Some(&covariance)).unwrap());
            // Sigma points at the square root of 3: exact for a Gaussian up to the fifth order.
            let residual = |x: &DVector<f64>| seen.arm.upper_arm_m - seen.upper_arm(x).0.norm();
            let moved = |d: usize, by: f64| {
                let mut x = at.clone();
                x[POSITION + d] += by * 3f64.sqrt() * sd;
                residual(&x)
            };
            let mean: f64 = (0..3).map(|d| (moved(d, 1.0) + moved(d, -1.0) - 2.0 * residual(&at)) / 6.0).sum();
            assert!(mean < -0.001 && (unknown.0[0] - known.0[0] - mean).abs() < 0.05 * mean.abs(), "{mean}");
            assert!(unknown.2[(0, 0)] > known.2[(0, 0)]);
        });
    }

    #[test]
    fn a_sighting_far_off_is_trusted_less() {
        with_seen(|seen, sighting| {
            let at = state(seen.layout);
            let noise = |pixel| seen.patch(&Sighting { pixel, ..*sighting }, &at, None).unwrap().unwrap().2[(0, 0)];
            let (residual, _, _) = seen.patch(sighting, &at, None).unwrap().unwrap();
            let expected = sighting.pixel - Vector2::new(residual[0], residual[1]);
            let variance = seen.noise.pixel_sd * seen.noise.pixel_sd;
            assert!((noise(expected) - variance).abs() < 1e-12);
            assert!(noise(expected + Vector2::new(100.0 * seen.noise.pixel_sd, 0.0)) > 100.0 * variance);
        });
    }
}
