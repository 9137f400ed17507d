//! From the world to the image: weak perspective (Li & Kulić eq. 3) or a pinhole camera.

use crate::camera::Camera;
use crate::{Error, Result};
use nalgebra::{Matrix2x3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// No picture is larger, px, and no metre is more of it.
const MOST: f64 = 1e9;

/// How world points become pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// Rows `u` and `v`: px/m along x, y, z, and px. Eq. (3) has no z; a fit may.
    Weak([[f64; 4]; 2]),
    /// A calibrated camera.
    Pinhole(Box<Camera>),
}

/// A point of the image, px, and how many pixels a metre has there; NaN behind the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Right, px.
    pub u: f64,
    /// Down, px.
    pub v: f64,
    /// Pixels per metre across the viewing direction.
    pub px_per_m: f64,
}

impl Projection {
    /// A weak-perspective matrix, checked.
    ///
    /// # Errors
    /// [`Error::Camera`] where it is not finite or has no extent.
    pub fn weak(rows: [[f64; 4]; 2]) -> Result<Self> {
        let fault = |reason: String| Err(Error::Camera { part: "affine", reason });
        if !rows.iter().flatten().all(|x| x.abs() <= MOST) {
            return fault(format!("is {rows:?}, expected finite numbers within ±{MOST:e}"));
        }
        if rows.iter().any(|row| length(row) <= 0.0) {
            return fault(format!("is {rows:?}, expected px/m that are not all zero in a row"));
        }
        Ok(Self::Weak(rows))
    }

    /// Where a world point, m, is seen.
    #[inline]
    pub fn see(&self, [x, y, z]: [f64; 3]) -> Projected {
        match self {
            Self::Weak([a, b]) => Projected {
                u: a[0] * x + a[1] * y + a[2] * z + a[3],
                v: b[0] * x + b[1] * y + b[2] * z + b[3],
                px_per_m: 0.5 * (length(a) + length(b)),
            },
            Self::Pinhole(camera) => {
                let world = Vector3::new(x, y, z);
                let pixel = camera.project(world);
                let focal = 0.5 * (camera.matrix()[(0, 0)] + camera.matrix()[(1, 1)]);
                pixel.map_or(Projected { u: f64::NAN, v: f64::NAN, px_per_m: f64::NAN }, |pixel| Projected {
                    u: pixel.x,
                    v: pixel.y,
                    px_per_m: focal / camera.depth(world),
                })
            }
        }
    }

    /// Where a world point is seen, px, and how that moves with it, `(2, 3)` px/m; none behind the camera.
    pub fn see_with_slope(&self, world: Vector3<f64>) -> Option<(Vector2<f64>, Matrix2x3<f64>)> {
        match self {
            Self::Weak([a, b]) => {
                let slope = Matrix2x3::new(a[0], a[1], a[2], b[0], b[1], b[2]);
                Some((slope * world + Vector2::new(a[3], b[3]), slope))
            }
            Self::Pinhole(camera) => camera.project_with_jacobian(world),
        }
    }

    /// Unit vector from the camera to a world point, m: the direction in which moving it does not move its pixel.
    pub fn viewing_direction(&self, world: Vector3<f64>) -> Vector3<f64> {
        match self {
            // Image axes are right and down, so that right x down is away.
            Self::Weak([a, b]) => Vector3::new(a[0], a[1], a[2]).cross(&Vector3::new(b[0], b[1], b[2])),
            Self::Pinhole(camera) => world - camera.centre(),
        }
        .try_normalize(1e-9)
        .unwrap_or(Vector3::z())
    }
}

fn length(row: &[f64; 4]) -> f64 {
    (row[0] * row[0] + row[1] * row[1] + row[2] * row[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn weak_perspective_is_eq_3() {
        let weak = Projection::weak([[100.0, 2.0, 0.0, 160.0], [0.0, -100.0, 0.0, 240.0]]).unwrap();
        let seen = weak.see([0.5, 1.0, 7.0]);
        assert_eq!((seen.u, seen.v), (212.0, 140.0));
        assert!((seen.px_per_m - 100.0).abs() < 0.02);
        let towards = Vector3::new(0.3, 1.2, 0.4);
        let moved = towards + weak.viewing_direction(towards);
        assert_eq!(weak.see(towards.into()), weak.see(moved.into()));
        assert!(weak.viewing_direction(towards).z < -0.99, "y is up, so that the camera looks along -z");
        assert!(Projection::weak([[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]).is_err());
        assert!(Projection::weak([[f64::NAN, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]).is_err());
    }

    #[test]
    fn a_metre_shrinks_with_depth() {
        let matrix = Matrix3::new(500.0, 0.0, 160.0, 0.0, 500.0, 120.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::zeros()).unwrap();
        let pinhole = Projection::Pinhole(Box::new(camera));
        let (at, beside) = (pinhole.see([0.0, 0.0, 4.0]), pinhole.see([1.0, 0.0, 4.0]));
        assert_eq!(beside.u - at.u, 125.0);
        assert_eq!(at.px_per_m, 125.0);
        assert!(pinhole.see([0.0, 0.0, -1.0]).u.is_nan());
        assert_eq!(pinhole.viewing_direction(Vector3::new(0.0, 0.0, 4.0)), Vector3::z());
    }
}
