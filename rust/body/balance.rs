//! A body that stands keeps its balance: where its arms reach out, the trunk goes the other way.
//!
//! Where they reach towards the camera, or from it, a camera does not see that. Arms are a tenth of the body's mass (de Leva,
//! J. Biomechanics 29(9), 1996): as they go forward the rest leans back about the ankles, so that all of it stays over the
//! feet. To first order, and above the hips, the figure moves as a whole. It moves along the viewing ray, after all cues:
//! of a trunk that seems larger they would have to say that the arms go the other way.

use super::joints::KEY_JOINTS;
use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

/// Coordinates of the key joints.
const COORDINATES: usize = 3 * KEY_JOINTS.len();
/// How far arms reach: from each shoulder to the middle of elbow and wrist, the mean of both; (key joint, its share).
const REACH: [(usize, f64); 6] = [(2, -0.5), (3, -0.5), (4, 0.25), (5, 0.25), (6, 0.25), (7, 0.25)];

/// By how much, and where to, a figure gives way to its arms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// The viewing ray, for a unit of reach, m.
    by_reach: Vector3<f64>,
    /// Level, away from the camera.
    away: Vector3<f64>,
    /// The reach of the first pose, which is balanced, m.
    first_m: f64,
}

impl Balance {
    /// Along the ray to a figure whose first pose has these key joints `(8 * 3,)`: `share` of how far its arms reach. None
    /// where there is nothing to move.
    pub fn new(ray: Vector3<f64>, share: f64, first: &[f64]) -> Option<Self> {
        // Of a camera that looks down a level way is seen for the most part.
        let away = Vector3::new(ray.x, 0.0, ray.z).try_normalize(1e-3).filter(|_| share > 0.0)?;
        let by_reach = ray * (-share * away.dot(&ray));
        let first_m = Self { by_reach, away, first_m: 0.0 }.reach(|k| first[k]);
        Some(Self { by_reach, away, first_m })
    }

    /// How far arms reach away from the camera, beyond the first pose, by the coordinates of the key joints, m.
    fn reach(&self, at: impl Fn(usize) -> f64) -> f64 {
        let along = |joint: usize| (0..3).map(|d| self.away[d] * at(3 * joint + d)).sum::<f64>();
        REACH.iter().map(|(joint, share)| share * along(*joint)).sum::<f64>() - self.first_m
    }

    /// Where a figure goes whose key joints have these coordinates, m.
    pub fn shift(&self, at: impl Fn(usize) -> f64) -> Vector3<f64> {
        self.by_reach * self.reach(at)
    }

    /// Key joints `(8 * 3,)` that have moved, and how they go with those that have not, `(8 * 3, 8 * 3)`.
    pub fn moved(&self, joints: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let shift = self.shift(|k| joints[k]);
        let mut slope = DMatrix::identity(COORDINATES, COORDINATES);
        for row in 0..COORDINATES {
            for (joint, share) in REACH {
                for d in 0..3 {
                    slope[(row, 3 * joint + d)] += self.by_reach[row % 3] * share * self.away[d];
                }
            }
        }
        (DVector::from_fn(COORDINATES, |k, _| joints[k] + shift[k % 3]), slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shoulders at 1.4 m, arms that hang; a camera in front looks along -z, a little down.
    fn hanging() -> DVector<f64> {
        let at = [[0.0, 0.9, 0.0], [0.0, 1.6, 0.0], [0.2, 1.4, 0.0], [-0.2, 1.4, 0.0]];
        let arms = [[0.2, 1.1, 0.0], [-0.2, 1.1, 0.0], [0.2, 0.85, 0.0], [-0.2, 0.85, 0.0]];
        DVector::from_iterator(COORDINATES, at.into_iter().chain(arms).flatten())
    }

    #[test]
    fn who_reaches_out_leans_back() {
        let (first, ray) = (hanging(), Vector3::new(0.0, -0.28, -0.96));
        let balance = Balance::new(ray, 0.1, first.as_slice()).unwrap();
        assert_eq!(balance.moved(&first).0, first);
        let mut reaching = first.clone();
        for (joint, z) in [(4, 0.3), (5, 0.3), (6, 0.5), (7, 0.5)] {
            reaching[3 * joint + 2] = z;
        }
        let (moved, slope) = balance.moved(&reaching);
        // Both arms by 0.4 m: along the ray, of which 0.96 is level.
        for (k, off) in (&moved - &reaching).iter().enumerate() {
            assert!((off - ray[k % 3] * 0.1 * 0.96 * 0.4).abs() < 1e-12);
        }
        assert!((&slope * (&reaching - &first) - (&moved - &first)).amax() < 1e-12);
    }

    #[test]
    fn from_above_and_without_a_share_nothing_moves() {
        assert_eq!(Balance::new(-Vector3::y(), 0.1, hanging().as_slice()), None);
        assert_eq!(Balance::new(Vector3::z(), 0.0, hanging().as_slice()), None);
    }
}
