//! The tracked figure: the sub-model, its key joints, its outer shape as a table of parts, and the limits of its joints.

use super::balance::Balance;
use super::facing::Facing;
use super::joints::{Group, KEY_JOINTS, KEYPOINTS};
use super::model::{Place, SubModel};
use crate::particles::ParticleSet;
use crate::projection::{Projected, Projection};
use crate::skeleton::{Channel, Skeleton};
use crate::{Error, Result, error::require};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// What wears skin: ends of the line whose middle the blob shows: (bone, along) twice.
const SKIN: [[(&str, f64); 2]; 3] =
    [[("upperneck", 0.0), ("head", 1.0)], [("lhand", 0.6), ("lhand", 0.6)], [("rhand", 0.6), ("rhand", 0.6)]];

/// Of what a detector may see, the key joints after the root come first, then the hips.
const HIPS: usize = KEY_JOINTS.len() - 1;

impl Group {
    /// `torso`, `left_arm` or `right_arm`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "torso" => Ok(Self::Torso),
            "left_arm" => Ok(Self::LeftArm),
            "right_arm" => Ok(Self::RightArm),
            _ => Err(Error::UnknownName { what: "group", name: name.into(), known: "torso, left_arm, right_arm" }),
        }
    }

    fn of(skeleton: &Skeleton, bone: usize) -> Self {
        let mut next = Some(bone);
        while let Some(b) = next {
            match skeleton.bones()[b].name.as_str() {
                "lclavicle" | "lhumerus" => return Self::LeftArm,
                "rclavicle" | "rhumerus" => return Self::RightArm,
                _ => next = skeleton.bones()[b].parent,
            }
        }
        Self::Torso
    }

    /// The wearer of skin ([`super::skin::WEARERS`]) that belongs to it.
    pub fn wearer(self) -> usize {
        self as usize
    }
}

/// A part of the outer shape: a rectangle about a line between two places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Where it starts: bone, along it.
    pub start: (String, f64),
    /// Where it ends.
    pub end: (String, f64),
    /// Half-width at either end, m.
    pub half_width_m: [f64; 2],
}

/// A part, ready: indices of its ends among the points of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limb {
    /// Point at which it starts.
    pub start: usize,
    /// Point at which it ends.
    pub end: usize,
    /// Half-width at either end, m.
    pub half_width_m: [f64; 2],
    /// What it belongs to.
    pub group: Group,
}

/// The figure that particles pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Its kinematics; the first eight points are the key joints, the next six the ends of what wears skin.
    pub model: SubModel,
    /// Its outer shape.
    pub limbs: Vec<Limb>,
    /// So many of the model's first points its key joints, skin and outer shape need.
    pub drawn: usize,
    /// Where what a detector may see is among the points of the model; none where the skeleton has no such bone.
    pub keypoints: [Option<usize>; KEYPOINTS.len()],
    /// Points a metre from each elbow along its axis: left, right.
    pub elbow_axes: [usize; 2],
    /// Group of every column of the state.
    pub groups: Vec<Group>,
    /// What every column of the state is.
    pub channels: Vec<(usize, Channel)>,
    /// Limits of every column, rad, widened to hold the pose it starts from; infinite where there are none.
    pub limits: Vec<[f64; 2]>,
    /// How it gives way to its arms, where it does.
    pub balance: Option<Balance>,
    /// Channels of the root's place.
    root: [Option<usize>; 3],
    /// How the world is turned in which its state is counted, where it is.
    facing: Option<Facing>,
}

impl Figure {
    /// `pose` `(C,)` is where it starts and what stays fixed, `free` `(D,)` the channels of the state, `limits` `(C,)`
    /// those of every channel (rad, infinite for none). The root's channels of the state are counted as `projection` sees it
    /// ([`Facing`]).
    ///
    /// # Errors
    /// [`Error::Skeleton`] for a bone that is not there, [`Error::Size`], [`Error::Parameter`].
    pub fn new(
        skeleton: &Skeleton,
        pose: &[f64],
        free: &[usize],
        limits: &[[f64; 2]],
        parts: &[Part],
        projection: &Projection,
    ) -> Result<Self> {
        let root = skeleton.pose(pose)?.starts[0];
        let facing = Facing::new(skeleton, projection.viewing_direction(root));
        let pose = &facing.as_ref().map_or_else(|| pose.to_vec(), |facing| facing.turned(pose));
        let place = |bone: &str, along: f64| Ok(Place { bone: skeleton.bone(bone)?, along, aside: Vector3::zeros() });
        let mut places = KEY_JOINTS.iter().map(|(_, bone, along)| place(bone, *along)).collect::<Result<Vec<_>>>()?;
        for (bone, along) in SKIN.iter().flatten() {
            places.push(place(bone, *along)?);
        }
        let mut limbs = Vec::with_capacity(parts.len());
        for part in parts {
            for half_width in part.half_width_m {
                let expected = "a positive length in metres, at most 1";
                require(half_width > 0.0 && half_width <= 1.0, "half_width_m", half_width, expected)?;
            }
            let mut index = |(bone, along): &(String, f64)| {
                let wanted = place(bone, *along)?;
                let known = places.iter().position(|p| *p == wanted);
                Ok::<_, Error>(known.unwrap_or_else(|| {
                    places.push(wanted);
                    places.len() - 1
                }))
            };
            let (start, end) = (index(&part.start)?, index(&part.end)?);
            let group = Group::of(skeleton, skeleton.bone(&part.end.0)?);
            limbs.push(Limb { start, end, half_width_m: part.half_width_m, group });
        }
        let drawn = places.len();
        let hips = ["lhipjoint", "rhipjoint"].map(|bone| place(bone, 1.0).ok());
        let mut added = |place: Place| {
            places.push(place);
            places.len() - 1
        };
        let [left_hip, right_hip] = hips.map(|hip| hip.map(&mut added));
        let keypoint = |k: usize| [left_hip, right_hip].get(k.wrapping_sub(HIPS)).map_or(Some(k + 1), |hip| *hip);
        let mut elbow_axes = [0; 2];
        for (axis, (upper, lower)) in elbow_axes.iter_mut().zip([("lhumerus", "lradius"), ("rhumerus", "rradius")]) {
            let aside = skeleton.bones()[skeleton.bone(lower)?].frame.column(0).into_owned();
            *axis = added(Place { aside, ..place(upper, 1.0)? });
        }
        let channels: Vec<_> = skeleton.channels().collect();
        let model = SubModel::new(skeleton, pose, free, &places, facing.as_ref().map(Facing::rotation))?;
        if limits.len() != channels.len() {
            return Err(Error::Size { name: "limits", got: limits.len(), unit: "channels", expected: channels.len() });
        }
        let widened = |c: &usize| [limits[*c][0].min(pose[*c]), limits[*c][1].max(pose[*c])];
        Ok(Self {
            limbs,
            drawn,
            keypoints: std::array::from_fn(keypoint),
            elbow_axes,
            groups: free.iter().map(|c| Group::of(skeleton, channels[*c].0)).collect(),
            channels: free.iter().map(|c| channels[*c]).collect(),
            limits: free.iter().map(widened).collect(),
            root: std::array::from_fn(|axis| channels.iter().position(|c| *c == (0, Channel::Translation(axis)))),
            balance: None,
            facing,
            model,
        })
    }

    /// The same figure, which gives way to `share` of how far its arms reach towards the camera; where its root has a place of its own.
    #[must_use]
    pub fn balanced(mut self, projection: &Projection, share: f64) -> Self {
        let first = self.points_of(&self.model.start(), KEY_JOINTS.len());
        let ray = projection.viewing_direction(Vector3::from_column_slice(&first[..3]));
        self.balance = Balance::new(ray, share, &first).filter(|_| self.root.iter().all(Option::is_some));
        self
    }

    /// The first `count` points of the model in one state, `(count * 3,)`.
    fn points_of(&self, state: &[f64], count: usize) -> Vec<f64> {
        let one = ParticleSet::from_rows(state.len(), state).expect("one particle");
        let mut points = vec![0.0; 3 * count];
        one.blocks().for_each(|block| self.model.points(block, 0, 1, &mut points));
        points
    }

    /// The whole pose `(C,)` of a state `(D,)`, its root where balance has it.
    ///
    /// # Panics
    /// When the state has no column.
    pub fn pose(&self, state: &[f64]) -> Vec<f64> {
        let mut pose = self.model.pose(state);
        if let Some(facing) = &self.facing {
            pose = facing.given(&pose);
        }
        if let Some(balance) = &self.balance {
            let joints = self.points_of(state, KEY_JOINTS.len());
            let shift = balance.shift(|k| joints[k]);
            for (channel, shift) in self.root.iter().zip(&shift) {
                if let Some(channel) = channel {
                    pose[*channel] += shift;
                }
            }
        }
        pose
    }

    /// Key joints `(N, 8 * 3)` where balance has them.
    pub fn in_balance(&self, joints: ParticleSet) -> ParticleSet {
        let Some(balance) = &self.balance else { return joints };
        joints.mapped(joints.dim(), |block, out| {
            for i in 0..block.len() {
                let shift = balance.shift(|k| block.column(k)[i]);
                for k in 0..3 * KEY_JOINTS.len() {
                    out.column_mut(k)[i] = block.column(k)[i] + shift[k % 3];
                }
            }
        })
    }

    /// Key joints of every particle as columns, `(N, 8 * 3)`, world, m, with the particles' weights; as cues have them.
    pub fn key_joints(&self, particles: &ParticleSet) -> ParticleSet {
        particles.mapped(3 * KEY_JOINTS.len(), |block, out| {
            let count = block.len();
            // They are the model's first points.
            let mut points = vec![0.0; 3 * KEY_JOINTS.len() * count];
            self.model.points(block, 0, count, &mut points);
            for d in 0..3 * KEY_JOINTS.len() {
                out.column_mut(d).copy_from_slice(&points[d * count..(d + 1) * count]);
            }
        })
    }

    /// Where the points of the model are seen in one state, `(D,)`.
    ///
    /// # Panics
    /// When the state has no column.
    pub fn seen(&self, projection: &Projection, state: &[f64]) -> Vec<Projected> {
        let points = self.points_of(state, self.model.len());
        points.as_chunks::<3>().0.iter().map(|point| projection.see(*point)).collect()
    }

    /// Height of the root, m, in the pose of the first frame.
    pub(super) fn root_height_m(&self) -> f64 {
        self.points_of(&self.model.start(), 1)[1]
    }

    /// Where balance has the key joints of states from elsewhere.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of columns than the figure's state has.
    pub fn joints_of(&self, states: &ParticleSet) -> Result<ParticleSet> {
        let (got, expected) = (states.dim(), self.model.dim());
        if got == expected {
            Ok(self.in_balance(self.key_joints(states)))
        } else {
            Err(Error::Size { name: "states", got, unit: "columns", expected })
        }
    }
}
