//! An arm as a state puts it at a frame: wrist, elbow, shoulder and the pixels of places, each with its slope by all columns.
//!
//! Not in the paper. The state is that of [`super::mixture`]; one with fewer columns has what it has.

use super::setup::{MOUNT, OF_ARM, PER_CAMERA, SHOULDER, SeenBy, seen_by};
use super::state::{Arm, Layout, Noise, POSITION, VELOCITY, View};
use crate::quaternion::Quaternion;
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, Matrix2x3, Matrix3, Vector2, Vector3};

/// One place that one camera saw.
#[derive(Debug, Clone, Copy)]
pub struct Sighting<'a> {
    /// Where it was seen from.
    pub view: &'a View,
    /// Which of the cameras that is.
    pub camera: usize,
    /// Where, px.
    pub pixel: Vector2<f64>,
}

/// Where each camera saw the patch, of those that did.
pub(super) fn sightings<'a>(views: &'a [View], pixels: &[Option<Vector2<f64>>]) -> Vec<Sighting<'a>> {
    let each = views.iter().zip(pixels).enumerate();
    each.filter_map(|(camera, (view, pixel))| Some(Sighting { view, camera, pixel: (*pixel)? })).collect()
}

/// What the IMU says at the time of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Recording time, s.
    pub time_s: f64,
    /// Orientation.
    pub world_sensor: Quaternion,
    /// Acceleration, world, m/s², as measured.
    pub acceleration: Vector3<f64>,
    /// For how long nothing has said how the sensor is oriented, s.
    pub stale_s: f64,
}

/// What all states of a frame have in common.
pub struct Posed<'a> {
    /// Which columns they have.
    pub layout: Layout,
    /// The arm.
    pub arm: &'a Arm,
    /// What noise is assumed.
    pub noise: &'a Noise,
    /// What the IMU says.
    pub moment: Moment,
    pub(super) world_sensor: Matrix3<f64>,
    /// Wrist to elbow in the world, as measured.
    pub(super) forearm: Vector3<f64>,
}

/// A column of the state, and what moves by it.
type ByColumn = (usize, Vector3<f64>);

impl<'a> Posed<'a> {
    /// At the time of a frame.
    pub fn new(layout: Layout, arm: &'a Arm, noise: &'a Noise, moment: Moment) -> Self {
        let forearm = moment.world_sensor.rotate(arm.elbow_in_sensor());
        Self { layout, arm, noise, moment, world_sensor: moment.world_sensor.to_matrix(), forearm }
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
            let later = self.moment.acceleration * state[column];
            wrist += (velocity + 0.5 * later) * state[column];
            slope.fixed_view_mut::<3, 3>(0, VELOCITY).copy_from(&(Matrix3::identity() * state[column]));
            slope.fixed_view_mut::<3, 1>(0, column).copy_from(&(velocity + later));
        }
        (wrist, slope)
    }

    /// The small turn by which the orientation is off.
    pub(super) fn turn(&self, state: &DVector<f64>) -> Matrix3<f64> {
        let theta = self.layout.tilt.map_or_else(Vector3::zeros, |column| state.fixed_rows::<3>(column).into());
        Matrix3::identity() + theta.cross_matrix()
    }

    /// A vector of the sensor's frame, `arm` in the world as measured: turned by the orientation's error; and its slope.
    pub(super) fn turned(
        &self,
        state: &DVector<f64>,
        arm: Vector3<f64>,
    ) -> (Vector3<f64>, Option<(usize, Matrix3<f64>)>) {
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
        (Matrix3::identity() - along * along.transpose()) * (self.noise.forearm_sd_rad * self.arm.forearm_m).powi(2)
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
            Some(first) => seen_by(&sighting.view.camera, &state.rows(first, PER_CAMERA).into_owned(), place),
            None => SeenBy::rightly(&sighting.view.camera, place),
        };
        let SeenBy { pixel, by_point, by_camera } = seen.ok_or(Error::RanAway { time_s: self.moment.time_s })?;
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
    /// As [`Posed::pixel`].
    pub(super) fn pixel_beside_shoulder(
        &self,
        sighting: &Sighting<'_>,
        state: &DVector<f64>,
        place: Vector3<f64>,
        by_state: &DMatrix<f64>,
    ) -> Result<(Vector2<f64>, DMatrix<f64>)> {
        let rightly = DVector::zeros(PER_CAMERA);
        let shoulder = self.arm.shoulder;
        let seen =
            seen_by(&sighting.view.camera, &rightly, shoulder).ok_or(Error::RanAway { time_s: self.moment.time_s })?;
        let mut pixel = seen.pixel + seen.by_point * (place - shoulder);
        let of_place = seen.by_point * by_state;
        let mut slope = DMatrix::from_fn(2, self.layout.dim, |r, c| of_place[(r, c)]);
        if let Some(first) = self.layout.setup.map(|column| column + OF_ARM + PER_CAMERA * sighting.camera) {
            pixel += &seen.by_camera * state.rows(first, PER_CAMERA);
            slope.columns_mut(first, PER_CAMERA).copy_from(&seen.by_camera);
        }
        Ok((pixel, slope))
    }
}
