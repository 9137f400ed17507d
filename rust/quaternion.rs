//! Hamilton unit quaternions, scalar first: `q_a_b` takes vectors of frame b to frame a.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// A quaternion `w + xi + yj + zk`; the methods that rotate expect unit length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Scalar part.
    pub w: f64,
    /// Vector part.
    pub v: Vector3<f64>,
}

impl Quaternion {
    /// No rotation.
    pub fn identity() -> Self {
        Self { w: 1.0, v: Vector3::zeros() }
    }

    /// From `[w, x, y, z]`, as given.
    pub fn from_wxyz(q: [f64; 4]) -> Self {
        Self { w: q[0], v: Vector3::new(q[1], q[2], q[3]) }
    }

    /// As `[w, x, y, z]`.
    pub fn wxyz(self) -> [f64; 4] {
        [self.w, self.v.x, self.v.y, self.v.z]
    }

    /// The rotation about `vector` by its length in radians (the exponential map).
    pub fn from_rotation_vector(vector: Vector3<f64>) -> Self {
        let half = 0.5 * vector.norm();
        // sin(h)/h by its series near zero, where the quotient loses digits.
        let scale = if half < 1e-4 { 0.5 * (1.0 - half * half / 6.0) } else { 0.5 * half.sin() / half };
        Self { w: half.cos(), v: vector * scale }
    }

    /// The length; 1 for a rotation.
    pub fn norm(self) -> f64 {
        (self.w * self.w + self.v.norm_squared()).sqrt()
    }

    /// The same direction with unit length.
    pub fn normalized(self) -> Self {
        let scale = 1.0 / self.norm();
        Self { w: self.w * scale, v: self.v * scale }
    }

    /// The inverse of a unit quaternion.
    pub fn conjugate(self) -> Self {
        Self { w: self.w, v: -self.v }
    }

    /// `q * vector * q'`: the vector in the other frame (the rotation in Tao & Hu eq. 4).
    pub fn rotate(self, vector: Vector3<f64>) -> Vector3<f64> {
        let twice_cross = 2.0 * self.v.cross(&vector);
        vector + self.w * twice_cross + self.v.cross(&twice_cross)
    }

    /// The rotation matrix whose columns are this frame's axes in the other.
    pub fn to_matrix(self) -> Matrix3<f64> {
        Matrix3::from_columns(&[self.rotate(Vector3::x()), self.rotate(Vector3::y()), self.rotate(Vector3::z())])
    }
}

impl std::ops::Mul for Quaternion {
    type Output = Self;

    /// Hamilton's product: `q_a_b * q_b_c` is `q_a_c`.
    fn mul(self, other: Self) -> Self {
        Self {
            w: self.w * other.w - self.v.dot(&other.v),
            v: self.w * other.v + other.w * self.v + self.v.cross(&other.v),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion as Other, UnitQuaternion};
    use proptest::prelude::*;
    use std::f64::consts::FRAC_1_SQRT_2;

    #[test]
    fn quarter_turn_about_z_takes_x_to_y() {
        let q = Quaternion::from_wxyz([FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
        assert!((q.rotate(Vector3::x()) - Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn i_times_j_is_k() {
        let (i, j) = (Quaternion::from_wxyz([0.0, 1.0, 0.0, 0.0]), Quaternion::from_wxyz([0.0, 0.0, 1.0, 0.0]));
        assert_eq!((i * j).wxyz(), [0.0, 0.0, 0.0, 1.0]);
    }

    fn unit() -> impl Strategy<Value = Quaternion> {
        prop::array::uniform4(-1.0..1.0f64)
            .prop_filter("needs a direction", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3)
            .prop_map(|q| Quaternion::from_wxyz(q).normalized())
    }

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-10.0..10.0f64).prop_map(Vector3::from)
    }

    fn twin(q: Quaternion) -> UnitQuaternion<f64> {
        let [w, x, y, z] = q.wxyz();
        UnitQuaternion::from_quaternion(Other::new(w, x, y, z))
    }

    proptest! {
        #[test]
        fn rotates_as_nalgebra_does(q in unit(), v in vector()) {
            prop_assert!((q.rotate(v) - twin(q) * v).norm() < 1e-12);
            prop_assert!((q.to_matrix() * v - q.rotate(v)).norm() < 1e-12);
        }

        #[test]
        fn composes_as_nalgebra_does(a in unit(), b in unit(), v in vector()) {
            prop_assert!(((a * b).rotate(v) - twin(a) * (twin(b) * v)).norm() < 1e-12);
            prop_assert!(((a * b).norm() - 1.0).abs() < 1e-14);
        }

        #[test]
        fn conjugate_undoes(q in unit(), v in vector()) {
            prop_assert!((q.conjugate().rotate(q.rotate(v)) - v).norm() < 1e-12);
        }

        #[test]
        fn rotation_vector_is_the_exponential(v in vector(), scale in prop::sample::select(vec![1e-9, 1e-5, 1e-3, 0.3])) {
            let v = v * scale;
            let [w, x, y, z] = Quaternion::from_rotation_vector(v).wxyz();
            let other = UnitQuaternion::from_scaled_axis(v);
            prop_assert!((Other::new(w, x, y, z) - other.quaternion()).norm() < 1e-14);
        }
    }
}
