//! What was measured once of an arm and its cameras, and not quite rightly: constants of a recording that a smoother estimates.
//!
//! Not in the paper. Two lengths, the shoulder's place, how the sensor lies on the forearm, and for every camera a small turn about its centre, its distance and its focal length. What
//! the data do not say of them stays as wide as it was known, and makes the bands of everything else as wide as they should be.

use super::process::GaussMarkov;
use crate::camera::Camera;
use crate::{Result, error::require};
use nalgebra::{DMatrix, DVector, Matrix2x3, Matrix3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// Columns of the arm: upper arm, forearm, shoulder (world), m; turn of the forearm about the sensor's x and z, rad.
pub const OF_ARM: usize = 7;
/// The first of the shoulder.
pub const SHOULDER: usize = 2;
/// The first of the forearm's turn.
pub const MOUNT: usize = 5;
/// Columns of a camera: turn about its x, y, z, rad; distance, m; share of the focal length.
pub const PER_CAMERA: usize = 5;
/// Columns of a camera for which there is room.
pub const MOST_CAMERAS: usize = 8;

/// How well they are known beforehand, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Upper arm, m.
    pub upper_arm_sd_m: f64,
    /// Forearm, m.
    pub forearm_sd_m: f64,
    /// Place about which the shoulder moves, m per axis.
    pub shoulder_place_sd_m: f64,
    /// Turn of the forearm beside the sensor, rad per axis.
    pub mount_sd_rad: f64,
    /// Turn of a camera, rad per axis.
    pub camera_turn_sd_rad: f64,
    /// Its distance, m.
    pub camera_distance_sd_m: f64,
    /// Its focal length, as a share of it.
    pub focal_sd: f64,
    /// How many cameras.
    pub cameras: usize,
}

impl Setup {
    /// Check every range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        for (name, sd) in [
            ("upper_arm_sd_m", self.upper_arm_sd_m),
            ("forearm_sd_m", self.forearm_sd_m),
            ("shoulder_place_sd_m", self.shoulder_place_sd_m),
            ("mount_sd_rad", self.mount_sd_rad),
            ("camera_turn_sd_rad", self.camera_turn_sd_rad),
            ("camera_distance_sd_m", self.camera_distance_sd_m),
            ("focal_sd", self.focal_sd),
        ] {
            require((0.0..=1.0).contains(&sd), name, sd, "0 to 1")?;
        }
        require(self.cameras <= MOST_CAMERAS, "cameras", self.cameras as f64, "at most 8")
    }

    /// How many columns it has.
    pub fn width(&self) -> usize {
        OF_ARM + PER_CAMERA * self.cameras
    }

    /// Its columns as processes that do not walk: offset of the first, how many, process.
    pub fn processes(&self) -> Vec<(usize, usize, GaussMarkov)> {
        let constant = |start_sd| GaussMarkov { start_sd, density: 0.0 };
        let (upper, fore) = (constant(self.upper_arm_sd_m), constant(self.forearm_sd_m));
        let arm = [
            (0, 1, upper),
            (1, 1, fore),
            (SHOULDER, 3, constant(self.shoulder_place_sd_m)),
            (MOUNT, 2, constant(self.mount_sd_rad)),
        ];
        let cameras = (0..self.cameras).flat_map(|camera| {
            let first = OF_ARM + PER_CAMERA * camera;
            let (turn, distance, focal) = (self.camera_turn_sd_rad, self.camera_distance_sd_m, self.focal_sd);
            [(first, 3, constant(turn)), (first + 3, 1, constant(distance)), (first + 4, 1, constant(focal))]
        });
        arm.into_iter().chain(cameras).collect()
    }
}

/// A pixel as a camera that is off sees it, with its slope by the world point and by the camera's columns.
pub struct SeenBy {
    /// Pixel.
    pub pixel: Vector2<f64>,
    /// By the world point, `(2, 3)` px/m.
    pub by_point: Matrix2x3<f64>,
    /// By the camera's columns, `(2, 5)`.
    pub by_camera: DMatrix<f64>,
}

impl SeenBy {
    /// By a camera that is as it is said to be; none behind it.
    pub fn rightly(camera: &Camera, world: Vector3<f64>) -> Option<Self> {
        let (pixel, by_point) = camera.project_with_jacobian(world)?;
        Some(Self { pixel, by_point, by_camera: DMatrix::zeros(2, 0) })
    }
}

/// What a camera sees of a world point when it is off by `columns` `(5,)`: turned, farther and of another focal length; none
/// behind it.
pub fn seen_by(camera: &Camera, columns: &DVector<f64>, world: Vector3<f64>) -> Option<SeenBy> {
    let (rotation, matrix) = (camera.rotation(), camera.matrix());
    let turn = Vector3::new(columns[0], columns[1], columns[2]);
    let inside = rotation * (world - camera.centre());
    // As a world point that this camera sees where the other sees the true one.
    let moved = world + rotation.transpose() * (turn.cross(&inside) + Vector3::z() * columns[3]);
    let (pixel, slope) = camera.project_with_jacobian(moved)?;
    let longer = 1.0 + columns[4];
    let middle = Vector2::new(matrix[(0, 2)], matrix[(1, 2)]);
    let by_inside = slope * rotation.transpose() * longer;
    let mut by_camera = DMatrix::zeros(2, PER_CAMERA);
    by_camera.fixed_view_mut::<2, 3>(0, 0).copy_from(&(by_inside * -inside.cross_matrix()));
    by_camera.fixed_view_mut::<2, 1>(0, 3).copy_from(&by_inside.column(2));
    by_camera.fixed_view_mut::<2, 1>(0, 4).copy_from(&(pixel - middle));
    let turned = (Matrix3::identity() + turn.cross_matrix()) * rotation;
    Some(SeenBy { pixel: middle + (pixel - middle) * longer, by_point: by_inside * turned, by_camera })
}
