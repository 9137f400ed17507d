//! Pinhole camera with lens distortion: world points in metres to pixels, Tao & Hu eq. (7).
//!
//! OpenCV's model and axes: `x right, y down, z forward`, distortion `k1 k2 p1 p2 k3`.

use crate::{Error, Result};
use multiversion::multiversion;
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// How far a rotation's rows may be from orthonormal.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// No picture, room or lens has larger numbers: px, m, and the distortion's own.
const MOST_PX: f64 = 1e6;
const MOST_M: f64 = 200.0;
const MOST_DISTORTION: f64 = 1e3;

/// A calibrated camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    matrix: Matrix3<f64>,
    distortion: [f64; 5],
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    /// Beyond this squared normalised radius the distortion folds back and means nothing.
    largest_r2: f64,
}

impl Camera {
    /// From intrinsics (px), distortion `k1 k2 p1 p2 k3`, and world -> camera rotation and translation (m).
    ///
    /// # Errors
    /// [`Error::Camera`] naming the part that is not what it should be.
    pub fn new(
        matrix: Matrix3<f64>,
        distortion: [f64; 5],
        rotation: Matrix3<f64>,
        translation: Vector3<f64>,
    ) -> Result<Self> {
        let fault = |part, reason: String| Err(Error::Camera { part, reason });
        let finite = |m: &[f64]| m.iter().all(|x| x.is_finite());
        if !finite(matrix.as_slice()) || matrix[(0, 0)] <= 0.0 || matrix[(1, 1)] <= 0.0 {
            return fault(
                "matrix",
                format!("focal lengths are {} and {} px, expected positive", matrix[(0, 0)], matrix[(1, 1)]),
            );
        }
        if matrix[(1, 0)] != 0.0 || matrix[(2, 0)] != 0.0 || matrix[(2, 1)] != 0.0 || matrix[(2, 2)] != 1.0 {
            return fault(
                "matrix",
                format!(
                    "lower rows are {:?}, expected [0, fy, cy] and [0, 0, 1]",
                    [matrix[(1, 0)], matrix[(2, 0)], matrix[(2, 1)], matrix[(2, 2)]]
                ),
            );
        }
        let skew = (rotation * rotation.transpose() - Matrix3::identity()).amax();
        if !finite(rotation.as_slice()) || skew > ROTATION_TOLERANCE || rotation.determinant() < 0.0 {
            return fault(
                "rotation",
                format!(
                    "R R' differs from the identity by {skew:.3e} and det R is {:.3}, expected a rotation (at most {ROTATION_TOLERANCE:e}, +1)",
                    rotation.determinant()
                ),
            );
        }
        let within = |m: &[f64], most: f64| m.iter().all(|x| x.abs() <= most);
        if !within(matrix.as_slice(), MOST_PX) {
            return fault("matrix", format!("{:?}, expected numbers within ±{MOST_PX:e} px", matrix.as_slice()));
        }
        if !within(&distortion, MOST_DISTORTION) {
            return fault("distortion", format!("{distortion:?}, expected numbers within ±{MOST_DISTORTION:e}"));
        }
        if !within(translation.as_slice(), MOST_M) {
            return fault(
                "translation_m",
                format!("{:?}, expected numbers within ±{MOST_M} m: are they millimetres?", translation.as_slice()),
            );
        }
        Ok(Self { matrix, distortion, rotation, translation, largest_r2: largest_r2(&distortion) })
    }

    /// Intrinsics, px.
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// World -> camera.
    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// Pixel of a world point; `None` behind the camera or where the distortion model no longer holds.
    #[inline]
    pub fn project(&self, world: Vector3<f64>) -> Option<Vector2<f64>> {
        let p = self.rotation * world + self.translation;
        if p.z <= 0.0 {
            return None;
        }
        let inverse = 1.0 / p.z;
        let (x, y) = self.distort(p.x * inverse, p.y * inverse)?;
        Some(self.pixel(x, y))
    }

    /// Squared distance, px², of the pixels of many world points from `pixel`; NaN where [`Camera::project`] has
    /// none. `points` are columns x, y, z (m); `offset` is added to each.
    ///
    /// # Panics
    /// When a column is shorter than `out`.
    pub fn squared_distances(&self, points: [&[f64]; 3], offset: Vector3<f64>, pixel: Vector2<f64>, out: &mut [f64]) {
        let [px, py, pz] = points.map(|column| &column[..out.len()]);
        if self.distortion.iter().any(|k| *k != 0.0) {
            for i in 0..out.len() {
                let seen = self.project(Vector3::new(px[i], py[i], pz[i]) + offset);
                out[i] = seen.map_or(f64::NAN, |p| (p - pixel).norm_squared());
            }
            return;
        }
        // Without distortion all of eq. (7) is one matrix: straight code that vector instructions can do.
        let (m, s) = (self.matrix * self.rotation, self.matrix * (self.rotation * offset + self.translation));
        squared_distances_linear(&m, &s, [px, py, pz], pixel, out);
    }

    /// Unit vector in the world from the camera through a pixel; the distortion is undone by OpenCV's fixed point.
    pub fn ray(&self, pixel: Vector2<f64>) -> Vector3<f64> {
        let k = &self.matrix;
        let y = (pixel.y - k[(1, 2)]) / k[(1, 1)];
        let x = (pixel.x - k[(0, 2)] - k[(0, 1)] * y) / k[(0, 0)];
        let [k1, k2, p1, p2, k3] = self.distortion;
        let (mut u, mut v) = (x, y);
        for _ in 0..20 {
            let r2 = u * u + v * v;
            let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
            let shift = (2.0 * p1 * u * v + p2 * (r2 + 2.0 * u * u), p1 * (r2 + 2.0 * v * v) + 2.0 * p2 * u * v);
            (u, v) = ((x - shift.0) / radial, (y - shift.1) / radial);
        }
        (self.rotation.transpose() * Vector3::new(u, v, 1.0)).normalize()
    }

    /// Where the camera is, world, m.
    pub fn centre(&self) -> Vector3<f64> {
        -(self.rotation.transpose() * self.translation)
    }

    /// Depth of a world point along the viewing direction, m.
    pub fn depth(&self, world: Vector3<f64>) -> f64 {
        self.rotation.row(2).transpose().dot(&world) + self.translation.z
    }

    /// Pixel and its derivative by the world point, `(2, 3)` px/m.
    pub fn project_with_jacobian(&self, world: Vector3<f64>) -> Option<(Vector2<f64>, Matrix2x3<f64>)> {
        let p = self.rotation * world + self.translation;
        if p.z <= 0.0 {
            return None;
        }
        let (x, y) = (p.x / p.z, p.y / p.z);
        let (xd, yd) = self.distort(x, y)?;
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        // Twice the derivative of the radial factor by r².
        let slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2));
        let dxx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let dxy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let dyy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        let (fx, fy, s) = (self.matrix[(0, 0)], self.matrix[(1, 1)], self.matrix[(0, 1)]);
        let by_normal = nalgebra::Matrix2::new(fx * dxx + s * dxy, fx * dxy + s * dyy, fy * dxy, fy * dyy);
        let by_camera = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / p.z;
        Some((self.pixel(xd, yd), by_normal * by_camera * self.rotation))
    }

    fn pixel(&self, x: f64, y: f64) -> Vector2<f64> {
        let k = &self.matrix;
        Vector2::new(k[(0, 0)] * x + k[(0, 1)] * y + k[(0, 2)], k[(1, 1)] * y + k[(1, 2)])
    }

    #[inline]
    fn distort(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = x * x + y * y;
        if r2 > self.largest_r2 {
            return None;
        }
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        Some((
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ))
    }
}

/// The first r² at which the distorted radius stops growing; infinite where it always grows.
fn largest_r2([k1, k2, _, _, k3]: &[f64; 5]) -> f64 {
    const STEPS: usize = 4000;
    const FARTHEST_R2: f64 = 16.0;
    (1..=STEPS)
        .map(|i| FARTHEST_R2 * i as f64 / STEPS as f64)
        .find(|r2| 1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) <= 0.0)
        .unwrap_or(f64::INFINITY)
}

/// Squared distances from `pixel` of what `m p + s` projects to; NaN behind the camera.
#[multiversion(targets("x86_64+avx2"))]
fn squared_distances_linear(
    m: &Matrix3<f64>,
    s: &Vector3<f64>,
    [px, py, pz]: [&[f64]; 3],
    pixel: Vector2<f64>,
    out: &mut [f64],
) {
    for i in 0..out.len() {
        let (x, y, z) = (px[i], py[i], pz[i]);
        let depth = m[(2, 0)] * x + m[(2, 1)] * y + m[(2, 2)] * z + s.z;
        let inverse = 1.0 / depth;
        let u = (m[(0, 0)] * x + m[(0, 1)] * y + m[(0, 2)] * z + s.x) * inverse - pixel.x;
        let v = (m[(1, 0)] * x + m[(1, 1)] * y + m[(1, 2)] * z + s.y) * inverse - pixel.y;
        out[i] = if depth > 0.0 { u * u + v * v } else { f64::NAN };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn camera(distortion: [f64; 5]) -> Camera {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 710.0, 240.0, 0.0, 0.0, 1.0);
        Camera::new(matrix, distortion, Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap()
    }

    #[test]
    fn a_ray_passes_through_its_pixel() {
        let k = Matrix3::new(700.0, 2.0, 320.0, 0.0, 690.0, 240.0, 0.0, 0.0, 1.0);
        let turn = *nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 0.1).matrix();
        let camera = Camera::new(k, [-0.2, 0.05, 0.001, -0.002, 0.0], turn, Vector3::new(0.1, 0.2, 2.0)).unwrap();
        for pixel in [Vector2::new(320.0, 240.0), Vector2::new(12.0, 400.0), Vector2::new(600.0, 20.0)] {
            let seen = camera.project(camera.centre() + 1.7 * camera.ray(pixel)).unwrap();
            assert!((seen - pixel).norm() < 1e-6, "{seen} is not {pixel}");
        }
    }

    #[test]
    fn principal_point_is_a_pixel_centre() {
        assert_eq!(camera([0.0; 5]).project(Vector3::zeros()), Some(Vector2::new(320.0, 240.0)));
    }

    #[test]
    fn right_is_plus_u_and_down_is_plus_v() {
        let pixel = camera([0.0; 5]).project(Vector3::new(0.2, 0.1, 0.0)).unwrap();
        assert_eq!(pixel, Vector2::new(390.0, 275.5));
    }

    #[test]
    fn behind_the_camera_is_nowhere() {
        assert_eq!(camera([0.0; 5]).project(Vector3::new(0.0, 0.0, -3.0)), None);
    }

    #[test]
    fn strong_barrel_distortion_does_not_fold_back() {
        let camera = camera([-0.3, 0.0, 0.0, 0.0, 0.0]);
        assert!(camera.project(Vector3::new(1.0, 0.0, 0.0)).is_some());
        assert_eq!(camera.project(Vector3::new(3.0, 0.0, 0.0)), None);
    }

    /// cv2.projectPoints of OpenCV 5.0 with the same numbers.
    #[test]
    fn agrees_with_opencv() {
        let pixel = camera([-0.2, 0.05, 0.001, -0.002, 0.01]).project(Vector3::new(0.5, -0.4, 0.1)).unwrap();
        assert!((pixel - Vector2::new(OPENCV[0], OPENCV[1])).norm() < 1e-9, "{pixel}");
    }
    const OPENCV: [f64; 2] = [483.288_636_965_793_67, 107.463_329_134_150_57];

    #[test]
    fn many_points_are_as_one_by_one() {
        for k in [[0.0; 5], [-0.2, 0.05, 0.001, -0.002, 0.01]] {
            let (camera, offset, pixel) = (camera(k), Vector3::new(0.01, -0.02, 0.03), Vector2::new(300.0, 250.0));
            let column = |d: f64| (0..40).map(|i| (f64::from(i) * d).sin() * 3.0).collect::<Vec<_>>();
            let (x, y, z) = (column(0.3), column(0.5), column(0.7));
            let mut out = vec![0.0; 40];
            camera.squared_distances([&x, &y, &z], offset, pixel, &mut out);
            for i in 0..40 {
                match camera.project(Vector3::new(x[i], y[i], z[i]) + offset) {
                    None => assert!(out[i].is_nan()),
                    Some(p) => assert!((out[i] / (p - pixel).norm_squared() - 1.0).abs() < 1e-9),
                }
            }
        }
    }

    #[test]
    fn what_is_not_a_camera_is_refused() {
        let good = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
        let part = |matrix, rotation| match Camera::new(matrix, [0.0; 5], rotation, Vector3::zeros()) {
            Err(Error::Camera { part, .. }) => part,
            _ => "accepted",
        };
        assert_eq!(part(good.transpose(), Matrix3::identity()), "matrix");
        assert_eq!(part(-good, Matrix3::identity()), "matrix");
        assert_eq!(part(good, Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0))), "rotation");
        assert_eq!(part(good, Matrix3::identity() * 1.1), "rotation");
    }

    proptest! {
        #[test]
        fn jacobian_is_the_derivative(p in prop::array::uniform3(-0.5..0.5f64), k in prop::array::uniform5(-0.05..0.05f64)) {
            let (camera, p, h) = (camera(k), Vector3::from(p), 1e-6);
            let (_, jacobian) = camera.project_with_jacobian(p).unwrap();
            for d in 0..3 {
                let mut step = Vector3::zeros();
                step[d] = h;
                let slope = (camera.project(p + step).unwrap() - camera.project(p - step).unwrap()) / (2.0 * h);
                prop_assert!((jacobian.column(d) - slope).norm() < 1e-4 * (1.0 + slope.norm()));
            }
        }
    }
}
