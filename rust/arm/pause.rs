//! After a pause: where the arm may be when neither IMU nor camera has said anything for a while.
//!
//! Not in the paper. Dead reckoning over a gap says nothing of an arm, that may have gone anywhere within its reach and come
//! to rest. The next sighting does: the wrist lies on the patch's ray, as far along it as the arm reaches.

use super::posed::Sighting;
use super::state::{Arm, Layout, Noise, POSITION, VELOCITY};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Without IMU and sighting for longer, nothing is known of the arm, s.
pub const BLIND_S: f64 = 0.5;
/// Without a frame for longer the IMU alone has led astray, s.
pub const NO_FRAME_S: f64 = 2.0;
/// Velocity of an arm that nothing is known of, m/s per axis.
const SPEED: f64 = 0.5;
/// A shoulder moves, and lengths are measured that badly, m.
const SLACK_M: f64 = 0.05;

/// A stretch of a ray on which the wrist lies somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Its middle, world, m.
    pub middle: Vector3<f64>,
    /// From the middle to its far end, m.
    pub half: Vector3<f64>,
    /// Standard deviation across it, m per axis.
    pub across_sd: f64,
}

impl Stretch {
    /// Where the ray of `sighting`, less the patch's `glued` offset in the world (m), lies within the arm's reach.
    pub fn within_reach(arm: &Arm, noise: &Noise, sighting: &Sighting<'_>, glued: Vector3<f64>) -> Self {
        let camera = &sighting.view.camera;
        let (origin, ray) = (camera.centre() - glued, camera.ray(sighting.pixel));
        let reach = arm.upper_arm_m + arm.forearm_m + SLACK_M;
        let nearest = ray.dot(&(arm.shoulder - origin));
        let miss = (origin + nearest * ray - arm.shoulder).norm();
        // A ray that passes the arm by: the point of it that is nearest.
        let half = (reach * reach - miss * miss).max(SLACK_M * SLACK_M).sqrt();
        let depth = camera.depth(origin + nearest * ray).abs();
        let offset_sd = noise.patch_offset.map_or(0.0, |offset| offset.start_sd);
        let across_sd = (noise.pixel_sd * depth / camera.matrix()[(0, 0)]).hypot(offset_sd);
        Self { middle: origin + nearest * ray, half: half * ray, across_sd }
    }

    /// Standard deviation `(D,)` of a state on it, but for the stretch itself.
    pub fn sd(&self, layout: Layout, arm: &Arm, noise: &Noise) -> DVector<f64> {
        let (_, mut sd) = layout.start(arm, noise);
        sd.rows_mut(POSITION, 3).fill(self.across_sd);
        sd.rows_mut(VELOCITY, 3).fill(SPEED);
        sd
    }

    /// As one Gaussian: mean `(D,)` and covariance `(D, D)`.
    pub fn gaussian(&self, layout: Layout, arm: &Arm, noise: &Noise) -> (DVector<f64>, DMatrix<f64>) {
        let mut mean = DVector::zeros(layout.dim);
        mean.fixed_rows_mut::<3>(POSITION).copy_from(&self.middle);
        let sd = self.sd(layout, arm, noise);
        let mut covariance = DMatrix::from_diagonal(&sd.component_mul(&sd));
        // Evenly spread over a length of two halves.
        let along: Matrix3<f64> = self.half * self.half.transpose() / 3.0;
        let mut position = covariance.fixed_view_mut::<3, 3>(POSITION, POSITION);
        position += along;
        (mean, covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::super::state::View;
    use super::*;
    use crate::camera::Camera;
    use nalgebra::Vector2;

    #[test]
    fn it_lies_on_the_ray_and_within_reach() {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        let view = View { camera, patch_offset: Vector3::zeros() };
        let arm = Arm {
            shoulder: Vector3::new(0.1, 0.0, 0.2),
            upper_arm_m: 0.3,
            forearm_m: 0.25,
            wrist_start: Vector3::zeros(),
        };
        for pixel in [Vector2::new(330.0, 200.0), Vector2::new(250.0, 260.0), Vector2::new(20.0, 30.0)] {
            let sighting = Sighting { view: &view, camera: 0, pixel };
            let stretch = Stretch::within_reach(&arm, &Noise::default(), &sighting, Vector3::zeros());
            for place in [stretch.middle - stretch.half, stretch.middle, stretch.middle + stretch.half] {
                assert!((view.camera.project(place).unwrap() - pixel).norm() < 1e-6);
                assert!((place - arm.shoulder).norm() < 0.601 || pixel.x < 100.0);
            }
            assert!((stretch.across_sd - 4.0 / 700.0 * 2.0).abs() < 2e-3);
        }
    }
}
