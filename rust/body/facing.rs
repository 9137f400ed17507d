//! A world turned about its vertical, so that the camera looks along its z axis.
//!
//! The root moves and leans in the picture's plane (Li & Kulić IV-A1: `root_tx`, `root_ty`, `root_rz`), which is the world's
//! x-y plane where the camera looks along z. Where a laboratory's world has another axis there, what is free of the root would be
//! its distance and its lean towards the camera, and what is seen best would be fixed: so its channels are counted in a
//! world that is turned. Places, and poses of the whole, stay in the world that was given.

use crate::skeleton::{Root, Skeleton, axis_rotation};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// A camera that looks less far beside the z axis stays as it is, rad: half a radian costs a tenth of what moves across.
const BESIDE: f64 = 0.5;
/// A camera that looks so steeply down or up has no side, as a share of a unit of its direction.
const STEEP: f64 = 0.2;

/// How a figure's world is turned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facing {
    /// From the turned world to the one that was given.
    rotation: Matrix3<f64>,
    root: Root,
}

impl Facing {
    /// For a camera that looks along `direction` at a skeleton's root; none where it looks along z nearly, steeply, or where the
    /// root lacks a channel.
    pub fn new(skeleton: &Skeleton, direction: Vector3<f64>) -> Option<Self> {
        let beside = (direction.x / direction.z).atan();
        let is_beside = direction.xz().norm() >= STEEP && beside.abs() >= BESIDE;
        let root = skeleton.root().filter(|_| is_beside)?;
        Some(Self { rotation: axis_rotation(1, beside), root })
    }

    /// From the turned world to the one that was given.
    pub fn rotation(&self) -> Matrix3<f64> {
        self.rotation
    }

    /// A pose of the world that was given, `(C,)`, in the turned one.
    pub fn turned(&self, pose: &[f64]) -> Vec<f64> {
        self.root.turned(pose, &self.rotation.transpose())
    }

    /// A pose of the turned world, `(C,)`, in the one that was given.
    pub fn given(&self, pose: &[f64]) -> Vec<f64> {
        self.root.turned(pose, &self.rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::{Bone, Channel, fixed_axes_rotation};
    use proptest::prelude::*;

    fn skeleton(frame: [f64; 3], order: [usize; 3]) -> Skeleton {
        let channels = [[0, 1, 2].map(Channel::Rotation), [0, 1, 2].map(Channel::Translation)].concat();
        let frame = fixed_axes_rotation(frame, [0, 1, 2]);
        let reach = Vector3::zeros();
        let root = Bone { name: "root".into(), parent: None, reach, frame, order, channels };
        let (channels, reach) = (vec![Channel::Rotation(2)], Vector3::new(0.1, 0.5, 0.2));
        Skeleton::new(vec![root, Bone { name: "spine".into(), parent: Some(0), reach, frame, order, channels }])
            .unwrap()
    }

    #[test]
    fn a_camera_along_z_turns_nothing() {
        let facing = |x: f64, y: f64, z: f64| Facing::new(&skeleton([0.0; 3], [0, 1, 2]), Vector3::new(x, y, z));
        assert!(
            [(0.1, -0.3, -0.9), (0.1, -0.3, 0.9), (0.1, -0.99, 0.0)].iter().all(|d| facing(d.0, d.1, d.2).is_none())
        );
        for (x, z) in [(1.0, 0.0), (-1.0, 0.1), (0.7, -0.7), (-0.6, -0.6)] {
            let inside = facing(x, -0.2, z).unwrap().rotation().transpose() * Vector3::new(x, -0.2, z);
            assert!(inside.x.abs() < 1e-12 && (inside.y + 0.2).abs() < 1e-12, "{inside}");
        }
    }

    proptest! {
        /// The same bones, of whatever frame and order; there and back it is the same pose.
        #[test]
        fn a_turned_pose_is_the_pose_turned(
            pose in prop::collection::vec(-1.5..1.5f64, 7),
            frame in prop::array::uniform3(-3.0..3.0f64),
            order in Just([0usize, 1, 2]).prop_shuffle(),
            angle in 0.0..std::f64::consts::TAU,
        ) {
            let skeleton = skeleton(frame, order);
            let direction = Vector3::new(angle.sin(), -0.3, angle.cos());
            if let Some(facing) = Facing::new(&skeleton, direction) {
                let turned = facing.turned(&pose);
                let (ours, theirs) = (skeleton.pose(&turned).unwrap(), skeleton.pose(&pose).unwrap());
                for (end, expected) in ours.ends.iter().zip(&theirs.ends) {
                    prop_assert!((facing.rotation() * end - expected).amax() < 1e-9);
                }
                let back = skeleton.pose(&facing.given(&turned)).unwrap();
                prop_assert!((back.rotations[1] - theirs.rotations[1]).amax() < 1e-9);
            }
        }
    }
}
