//! Acclaim skeletons: bones and axes as flat arrays; forward kinematics as a pure function of the pose.
//!
//! Acclaim's convention: a bone's joint turns about axes fixed in the bone's own frame `C`, so that its global rotation is
//! `parent · C · M · C⁻¹`; its end is its start + global rotation · (direction · length). `C` and `M` are rotations
//! about fixed axes, applied in the order that the file names, usually x, y, z: `Rz · Ry · Rx`.

use crate::{Error, Result};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// What a channel of the pose does to its bone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// Moves along x, y or z (0, 1, 2), m; the root only.
    Translation(usize),
    /// Turns about x, y or z, rad.
    Rotation(usize),
}

impl Channel {
    /// `tx`, `ty`, `tz`, `rx`, `ry` or `rz`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        const KNOWN: &str = "tx, ty, tz, rx, ry, rz";
        let unknown = || Error::UnknownName { what: "channel", name: name.into(), known: KNOWN };
        let axis =
            name.get(1..).and_then(|axis| ["x", "y", "z"].iter().position(|a| *a == axis)).ok_or_else(unknown)?;
        match name.as_bytes()[0] {
            b't' => Ok(Self::Translation(axis)),
            b'r' => Ok(Self::Rotation(axis)),
            _ => Err(unknown()),
        }
    }
}

/// One bone; the first of a skeleton is the root, which has no length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bone {
    /// Its name in the file, `root` for the first.
    pub name: String,
    /// Index of the bone that it hangs on; `None` for the root.
    pub parent: Option<usize>,
    /// Direction times length, in global axes of the base pose, m.
    pub reach: Vector3<f64>,
    /// `C`: the frame in which the joint turns.
    pub frame: Matrix3<f64>,
    /// In which order the turns are applied; `[0, 1, 2]` is x, y, z.
    pub order: [usize; 3],
    /// What moves it.
    pub channels: Vec<Channel>,
}

/// Bones in an order in which parents come first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Skeleton {
    bones: Vec<Bone>,
}

/// No bone is longer, m.
const MOST_REACH_M: f64 = 100.0;

/// Rotation about one coordinate axis.
pub fn axis_rotation(axis: usize, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = Matrix3::identity();
    (m[(j, j)], m[(j, k)], m[(k, j)], m[(k, k)]) = (c, -s, s, c);
    m
}

/// Turns about fixed axes, applied in `order`; `angles` by axis, rad.
pub fn fixed_axes_rotation(angles: [f64; 3], order: [usize; 3]) -> Matrix3<f64> {
    order.iter().fold(Matrix3::identity(), |m, axis| axis_rotation(*axis, angles[*axis]) * m)
}

/// Angles by axis, rad, of which [`fixed_axes_rotation`] in `order` makes `rotation`; where the second turn is a right angle, those
/// of many that leave the first as it is.
pub fn fixed_axes_angles(rotation: &Matrix3<f64>, order: [usize; 3]) -> [f64; 3] {
    let [first, second, third] = order;
    // An order against the clock turns the other way.
    let sign = if (first + 1) % 3 == second { 1.0 } else { -1.0 };
    let at = |row: usize, column: usize| rotation[(row, column)];
    let mut angles = [0.0; 3];
    angles[first] = (sign * at(third, second)).atan2(at(third, third));
    angles[second] = (-sign * at(third, first)).atan2(at(third, second).hypot(at(third, third)));
    angles[third] = (sign * at(second, first)).atan2(at(first, first));
    angles
}

/// The six channels by which a root stands anywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Root {
    place: [usize; 3],
    turn: [usize; 3],
    frame: Matrix3<f64>,
    order: [usize; 3],
}

impl Root {
    /// A pose `(C,)` of a world in one that `rotation` turns it to: bones are where they were, turned.
    pub fn turned(&self, pose: &[f64], rotation: &Matrix3<f64>) -> Vec<f64> {
        let (place, angles) = (self.place.map(|channel| pose[channel]), self.turn.map(|channel| pose[channel]));
        let root = self.frame.transpose() * rotation * self.frame * fixed_axes_rotation(angles, self.order);
        let (place, angles) = (rotation * Vector3::from(place), fixed_axes_angles(&root, self.order));
        let mut turned = pose.to_vec();
        for axis in 0..3 {
            (turned[self.place[axis]], turned[self.turn[axis]]) = (place[axis], angles[axis]);
        }
        turned
    }
}

/// Where a pose puts every bone: world, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Posed {
    /// Start of every bone.
    pub starts: Vec<Vector3<f64>>,
    /// End of every bone; the root's is its start.
    pub ends: Vec<Vector3<f64>>,
    /// How every bone is turned from the base pose, in the world.
    pub rotations: Vec<Matrix3<f64>>,
}

impl Skeleton {
    /// Checked: the first bone is the root, parents come first, names differ, only the root is moved.
    ///
    /// # Errors
    /// [`Error::Skeleton`] naming the bone.
    pub fn new(bones: Vec<Bone>) -> Result<Self> {
        let fault = |bone: &Bone, reason: &str| Err(Error::Skeleton { bone: bone.name.clone(), reason: reason.into() });
        let Some(root) = bones.first() else {
            return Err(Error::Size { name: "skeleton", got: 0, unit: "bones", expected: 1 });
        };
        if root.parent.is_some() {
            return fault(root, "is first but has a parent, expected the root first");
        }
        for bone in &bones {
            let numbers = bone.reach.iter().map(|x| x / MOST_REACH_M).chain(bone.frame.iter().copied());
            if !numbers.into_iter().all(|x| x.abs() <= 1.0 + 1e-6) {
                return fault(bone, "has a direction, length or axis beyond 100 m or that is not a finite number");
            }
            let mut order = bone.order;
            order.sort_unstable();
            let axes = bone.channels.iter().map(|channel| match channel {
                Channel::Translation(axis) | Channel::Rotation(axis) => *axis,
            });
            if order != [0, 1, 2] || axes.max().unwrap_or(0) > 2 {
                return fault(bone, "turns about axes that are not x, y and z, expected each once");
            }
        }
        for (index, bone) in bones.iter().enumerate().skip(1) {
            if bone.parent.is_none_or(|parent| parent >= index) {
                return fault(bone, "comes before its parent, expected parents first");
            }
            if bone.channels.iter().any(|c| matches!(c, Channel::Translation(_))) {
                return fault(bone, "has a translation channel, expected rotations: only the root may move");
            }
            if bones[..index].iter().any(|other| other.name == bone.name) {
                return fault(bone, "is there twice, expected different names");
            }
        }
        Ok(Self { bones })
    }

    /// The bones; the first is the root.
    pub fn bones(&self) -> &[Bone] {
        &self.bones
    }

    /// How the root stands; none where it lacks a channel.
    pub fn root(&self) -> Option<Root> {
        let root = &self.bones[0];
        let find = |wanted: Channel| root.channels.iter().position(|channel| *channel == wanted);
        let all = |of: fn(usize) -> Channel| Some([find(of(0))?, find(of(1))?, find(of(2))?]);
        let (place, turn) = (all(Channel::Translation)?, all(Channel::Rotation)?);
        Some(Root { place, turn, frame: root.frame, order: root.order })
    }

    /// Index of a bone.
    ///
    /// # Errors
    /// [`Error::Skeleton`] when there is none of that name.
    pub fn bone(&self, name: &str) -> Result<usize> {
        let found = self.bones.iter().position(|bone| bone.name == name);
        found.ok_or_else(|| Error::Skeleton { bone: name.into(), reason: "is not in the skeleton".into() })
    }

    /// The channels of a pose in order: the root's, then every bone's: (bone, channel).
    pub fn channels(&self) -> impl Iterator<Item = (usize, Channel)> {
        self.bones.iter().enumerate().flat_map(|(b, bone)| bone.channels.iter().map(move |channel| (b, *channel)))
    }

    /// Forward kinematics of one pose, `(C,)`: metres and radians in the order of [`Skeleton::channels`].
    ///
    /// # Errors
    /// [`Error::Size`] for another number of values than channels.
    pub fn pose(&self, pose: &[f64]) -> Result<Posed> {
        let expected = self.channels().count();
        if pose.len() != expected {
            return Err(Error::Size { name: "pose", got: pose.len(), unit: "values", expected });
        }
        let mut posed = Posed { starts: Vec::new(), ends: Vec::new(), rotations: Vec::with_capacity(self.bones.len()) };
        let mut values = pose.iter();
        for bone in &self.bones {
            let (mut shift, mut angles) = (Vector3::zeros(), [0.0; 3]);
            for (channel, value) in bone.channels.iter().zip(values.by_ref()) {
                match channel {
                    Channel::Translation(axis) => shift[*axis] = *value,
                    Channel::Rotation(axis) => angles[*axis] = *value,
                }
            }
            let turn = bone.frame * fixed_axes_rotation(angles, bone.order) * bone.frame.transpose();
            let (start, rotation) = match bone.parent {
                None => (shift, turn),
                Some(parent) => (posed.ends[parent], posed.rotations[parent] * turn),
            };
            posed.starts.push(start);
            posed.ends.push(start + rotation * bone.reach);
            posed.rotations.push(rotation);
        }
        Ok(posed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn bone(name: &str, parent: Option<usize>, reach: [f64; 3], channels: &[Channel]) -> Bone {
        let (frame, order) = (Matrix3::identity(), [0, 1, 2]);
        Bone { name: name.into(), parent, reach: reach.into(), frame, order, channels: channels.to_vec() }
    }

    #[test]
    fn turns_are_applied_in_order_about_fixed_axes() {
        // x to y by the turn about z, after the turn about x has left it.
        let m = fixed_axes_rotation([FRAC_PI_2, 0.0, FRAC_PI_2], [0, 1, 2]);
        assert!((m * Vector3::x() - Vector3::y()).norm() < 1e-15);
        assert!((m * Vector3::y() - Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn angles_make_the_rotation_again() {
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let angles = [0.4, -0.9, 1.3];
            let found = fixed_axes_angles(&fixed_axes_rotation(angles, order), order);
            assert!(found.iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-12), "{order:?}: {found:?}");
        }
    }

    #[test]
    fn a_joint_turns_in_its_own_frame_and_carries_its_children() {
        let mut upper = bone("upper", Some(0), [0.3, 0.0, 0.0], &[Channel::Rotation(0)]);
        // The bone's own x is the world's z.
        upper.frame = axis_rotation(1, -FRAC_PI_2);
        let lower = bone("lower", Some(1), [0.2, 0.0, 0.0], &[]);
        let root = bone("root", None, [0.0; 3], &[Channel::Translation(1), Channel::Rotation(1)]);
        let skeleton = Skeleton::new(vec![root, upper, lower]).unwrap();
        let posed = skeleton.pose(&[1.0, 0.0, FRAC_PI_2]).unwrap();
        assert!((posed.ends[2] - Vector3::new(0.0, 1.5, 0.0)).norm() < 1e-15);
        let posed = skeleton.pose(&[0.0, -FRAC_PI_2, 0.0]).unwrap();
        assert!((posed.ends[2] - Vector3::new(0.0, 0.0, 0.5)).norm() < 1e-15);
    }

    #[test]
    fn what_is_not_a_skeleton_is_refused() {
        let root = || bone("root", None, [0.0; 3], &[]);
        let words = |bones| Skeleton::new(bones).unwrap_err().to_string();
        assert!(words(vec![root(), bone("a", Some(1), [0.0; 3], &[])]).contains("bone 'a' comes before its parent"));
        let moved = bone("a", Some(0), [0.0; 3], &[Channel::Translation(0)]);
        assert!(words(vec![root(), moved]).contains("only the root may move"));
        let twice = vec![root(), bone("a", Some(0), [0.0; 3], &[]), bone("a", Some(0), [0.0; 3], &[])];
        assert!(words(twice).contains("twice"));
        assert!(Skeleton::new(vec![root()]).unwrap().pose(&[1.0]).is_err());
    }
}
