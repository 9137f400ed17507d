//! Any subset of a skeleton's channels as a state, and its forward kinematics for many particles at once.
//!
//! What does not move with the state is multiplied out beforehand: bones become *segments*, one for each joint that the
//! state turns, and the wanted points sit still in a segment's frame. So a particle costs what its free channels cost.

use super::forward::forward;
use super::jacobian::PosedModel;
use super::segment::{Segment, Source, Turn};
use crate::particles::Block;
use crate::skeleton::{Channel, Skeleton};
use crate::{Error, Result};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Frames that differ by less are the same: a billionth of a millimetre at arm's length.
const SAME_FRAME: f64 = 1e-12;

/// A place on a bone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Index of the bone.
    pub bone: usize,
    /// 0 at its start, 1 at its end.
    pub along: f64,
    /// From there, m, along the world's axes in the skeleton's base pose; it turns with the bone.
    pub aside: Vector3<f64>,
}

/// A sub-model: the skeleton, the pose that it keeps, and what is free of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SubModel {
    segments: Vec<Segment>,
    /// Where the wanted points sit: segment, place in its frame.
    points: Vec<(usize, Vector3<f64>)>,
    pose: Vec<f64>,
    free: Vec<usize>,
}

/// How a bone sits in the frame of its segment.
struct Rigid {
    segment: usize,
    rotation: Matrix3<f64>,
    start: Vector3<f64>,
    end: Vector3<f64>,
}

impl SubModel {
    /// `pose` `(C,)` is kept where it is not free, `free` `(D,)` are indices of channels, `points` `(P,)` what is wanted; both pose
    /// and state are of a world that is turned by `within` in that of the points, where there is one.
    ///
    /// # Errors
    /// [`Error::Size`] for a pose of another length or a channel that is not there.
    pub fn new(
        skeleton: &Skeleton,
        pose: &[f64],
        free: &[usize],
        points: &[Place],
        within: Option<Matrix3<f64>>,
    ) -> Result<Self> {
        let expected = skeleton.channels().count();
        if pose.len() != expected {
            return Err(Error::Size { name: "pose", got: pose.len(), unit: "values", expected });
        }
        if let Some(got) = free.iter().find(|channel| **channel >= expected) {
            return Err(Error::Size { name: "free", got: *got, unit: "as a channel", expected });
        }
        let mut model = Self { segments: Vec::new(), points: Vec::new(), pose: pose.to_vec(), free: free.to_vec() };
        let still = [Source::Fixed(0.0); 3];
        let world = |frame| Segment { parent: None, origin: still, frame: Some(frame), turns: Vec::new() };
        model.segments.extend(within.map(world));
        let outermost = within.map(|_| 0);
        let mut rigid: Vec<Rigid> = Vec::with_capacity(skeleton.bones().len());
        let mut first_channel = 0;
        for bone in skeleton.bones() {
            let source = |index: usize| {
                let column = free.iter().position(|f| *f == index);
                column.map_or(Source::Fixed(pose[index]), Source::Free)
            };
            let (mut shift, mut angles) = (still, still);
            for (k, channel) in bone.channels.iter().enumerate() {
                match channel {
                    Channel::Translation(axis) => shift[*axis] = source(first_channel + k),
                    Channel::Rotation(axis) => angles[*axis] = source(first_channel + k),
                }
            }
            first_channel += bone.channels.len();
            let joint = Joint { order: bone.order, angles };
            let parent = bone.parent.map(|p| &rigid[p]);
            let placed = match parent {
                Some(parent) if joint.is_fixed() => {
                    let rotation = parent.rotation * bone.frame * joint.matrix() * bone.frame.transpose();
                    let end = parent.end + rotation * bone.reach;
                    Rigid { segment: parent.segment, rotation, start: parent.end, end }
                }
                _ => {
                    let (frame, origin) = match parent {
                        None => (bone.frame, shift),
                        Some(p) => (p.rotation * bone.frame, p.end.data.0[0].map(Source::Fixed)),
                    };
                    let is_same = (frame - Matrix3::identity()).amax() < SAME_FRAME;
                    let frame = (!is_same).then_some(frame);
                    let turns = joint.turns();
                    let parent = parent.map_or(outermost, |p| Some(p.segment));
                    model.segments.push(Segment { parent, origin, frame, turns });
                    let rotation = bone.frame.transpose();
                    let (segment, end) = (model.segments.len() - 1, rotation * bone.reach);
                    Rigid { segment, rotation, start: Vector3::zeros(), end }
                }
            };
            rigid.push(placed);
        }
        model.points = points
            .iter()
            .map(|place| {
                let bone = &rigid[place.bone];
                (bone.segment, bone.start + (bone.end - bone.start) * place.along + bone.rotation * place.aside)
            })
            .collect();
        model.drop_unused();
        Ok(model)
    }

    /// How many columns the state has.
    pub fn dim(&self) -> usize {
        self.free.len()
    }

    /// How many points are wanted.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether no point is wanted.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The state of the pose that it was made with, `(D,)`.
    pub fn start(&self) -> Vec<f64> {
        self.free.iter().map(|channel| self.pose[*channel]).collect()
    }

    /// The whole pose `(C,)` of a state `(D,)`.
    pub fn pose(&self, state: &[f64]) -> Vec<f64> {
        let mut pose = self.pose.clone();
        for (channel, value) in self.free.iter().zip(state) {
            pose[*channel] = *value;
        }
        pose
    }

    /// In one state `(D,)`, with how points move with it.
    pub(super) fn posed(&self, state: &[f64]) -> PosedModel<'_> {
        PosedModel::new(&self.segments, &self.points, state)
    }

    /// Leave out segments that carry no point, such as legs that nobody asks for.
    fn drop_unused(&mut self) {
        let mut is_used = vec![false; self.segments.len()];
        for (segment, _) in &self.points {
            let mut next = Some(*segment);
            while let Some(s) = next {
                is_used[s] = true;
                next = self.segments[s].parent;
            }
        }
        let new: Vec<usize> = is_used
            .iter()
            .scan(0, |count, used| {
                *count += usize::from(*used);
                Some(count.saturating_sub(1))
            })
            .collect();
        let mut kept = is_used.iter();
        self.segments.retain(|_| *kept.next().unwrap_or(&true));
        for segment in &mut self.segments {
            segment.parent = segment.parent.map(|p| new[p]);
        }
        for (segment, _) in &mut self.points {
            *segment = new[*segment];
        }
    }

    /// Points of the particles `first..first + count` of a block, m: as many of the first as `out` has room for,
    /// `(P, 3, count)` flattened.
    ///
    /// # Panics
    /// When the block has fewer columns or particles, or `out` is no whole number of points, or longer than all.
    pub fn points(&self, block: Block<'_>, first: usize, count: usize, out: &mut [f64]) {
        let wanted = out.len().checked_div(3 * count).unwrap_or(0);
        assert_eq!(out.len(), wanted * 3 * count, "three coordinates a point and particle");
        let columns: Vec<&[f64]> = (0..self.dim()).map(|d| &block.column(d)[first..first + count]).collect();
        forward(&self.segments, &self.points[..wanted], &columns, count, out);
    }
}

/// The turns of a bone's joint.
struct Joint {
    order: [usize; 3],
    angles: [Source; 3],
}

impl Joint {
    fn is_fixed(&self) -> bool {
        self.angles.iter().all(|angle| matches!(angle, Source::Fixed(_)))
    }

    fn matrix(&self) -> Matrix3<f64> {
        let angle = |source: Source| if let Source::Fixed(x) = source { x } else { 0.0 };
        crate::skeleton::fixed_axes_rotation(self.angles.map(angle), self.order)
    }

    /// The last applied first, without those that do nothing.
    fn turns(&self) -> Vec<(usize, Turn)> {
        let all = self.order.iter().rev().map(|axis| (*axis, self.angles[*axis]));
        let turn = |source| match source {
            Source::Fixed(angle) => Turn::Fixed(angle.sin(), angle.cos()),
            Source::Free(column) => Turn::Free(column),
        };
        all.filter(|(_, source)| *source != Source::Fixed(0.0)).map(|(axis, source)| (axis, turn(source))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::forward::forward_by_lanes;
    use super::*;
    use crate::particles::ParticleSet;
    use crate::rng::Streams;
    use crate::skeleton::{Bone, fixed_axes_rotation};
    use rand::RngExt;

    /// A root with six channels and three chains of bones with odd frames, orders and channels.
    fn skeleton() -> Skeleton {
        let all = [0, 1, 2].map(Channel::Rotation);
        let root = [[0, 1, 2].map(Channel::Translation), all].concat();
        let bone = |name: &str, parent, channels: &[Channel], k: f64, order| Bone {
            name: name.into(),
            parent,
            reach: Vector3::new(0.1 + 0.05 * k, -0.2 * k, 0.1 * k * k),
            frame: fixed_axes_rotation([0.3 * k, -0.5 * k, 0.9 - k], [0, 1, 2]),
            order,
            channels: channels.to_vec(),
        };
        let mut first = bone("root", None, &root, 0.0, [0, 1, 2]);
        first.reach = Vector3::zeros();
        Skeleton::new(vec![
            first,
            bone("spine", Some(0), &all, 0.4, [0, 1, 2]),
            bone("still", Some(1), &[], 0.5, [0, 1, 2]),
            bone("upper", Some(2), &all, 0.8, [2, 0, 1]),
            bone("lower", Some(3), &[Channel::Rotation(1)], 1.1, [0, 1, 2]),
            bone("leg", Some(0), &all[..2], -0.7, [0, 2, 1]),
        ])
        .unwrap()
    }

    /// Any subset of channels gives what the plain kinematics of the whole pose gives.
    #[test]
    fn any_sub_model_agrees_with_the_whole_skeleton() {
        let skeleton = skeleton();
        let channels = skeleton.channels().count();
        let mut rng = Streams::new(1, 2, 3).block(0);
        for case in 0..40_u32 {
            let pose: Vec<f64> = (0..channels).map(|_| rng.random::<f64>() * 4.0 - 2.0).collect();
            let free: Vec<usize> =
                (0..channels).filter(|c| case == 0 || (c + case as usize).is_multiple_of(3)).collect();
            let places: Vec<Place> = if case % 2 == 0 {
                (0..6)
                    .flat_map(|bone| [0.0, 0.3, 1.0].map(|along| Place { bone, along, aside: Vector3::zeros() }))
                    .collect()
            } else {
                vec![Place { bone: 4, along: 1.0, aside: Vector3::zeros() }]
            };
            let model = SubModel::new(&skeleton, &pose, &free, &places, None).unwrap();
            let mut set = ParticleSet::new(11, free.len()).unwrap();
            set.for_each_block(|_, mut block| {
                for d in 0..free.len() {
                    for (i, x) in block.column_mut(d).iter_mut().enumerate() {
                        *x = model.start()[d] + 0.1 * i as f64;
                    }
                }
            });
            let (first, count) = (2, 9);
            let mut out = vec![0.0; places.len() * 3 * count];
            model.points(set.blocks().next().unwrap(), first, count, &mut out);
            // What every processor could run gives the same bits.
            let columns: Vec<Vec<f64>> = (0..free.len())
                .map(|d| set.blocks().next().unwrap().column(d)[first..first + count].to_vec())
                .collect();
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let mut plain = vec![0.0; out.len()];
            forward_by_lanes(&model.segments, &model.points, &columns, count, &mut plain);
            assert_eq!(plain, out);
            let rows = set.rows();
            for i in 0..count {
                let state = &rows[(first + i) * free.len()..(first + i + 1) * free.len()];
                let posed = skeleton.pose(&model.pose(state)).unwrap();
                let alone = model.posed(state);
                for (p, place) in places.iter().enumerate() {
                    let expected = posed.starts[place.bone].lerp(&posed.ends[place.bone], place.along);
                    assert!((alone.at(p) - expected).amax() < 1e-13, "case {case}");
                    for d in 0..3 {
                        assert!((out[(3 * p + d) * count + i] - expected[d]).abs() < 1e-13, "case {case}");
                    }
                }
            }
        }
    }

    /// How a point moves is the difference between a state and its neighbours, of whatever is free, in a turned world too.
    #[test]
    fn slopes_are_those_of_the_points() {
        const STEP: f64 = 1e-6;
        let skeleton = skeleton();
        let channels = skeleton.channels().count();
        let places: Vec<Place> =
            (0..6).map(|bone| Place { bone, along: 0.6, aside: Vector3::new(0.03, -0.1, 0.05) }).collect();
        let mut rng = Streams::new(4, 5, 6).block(0);
        for case in 0..20_usize {
            let pose: Vec<f64> = (0..channels).map(|_| rng.random::<f64>() * 4.0 - 2.0).collect();
            let free: Vec<usize> = (0..channels).filter(|c| case == 0 || !(c + case).is_multiple_of(3)).collect();
            let within = (case % 2 == 1).then(|| fixed_axes_rotation([0.4, -0.2, 0.1 * case as f64], [0, 1, 2]));
            let model = SubModel::new(&skeleton, &pose, &free, &places, within).unwrap();
            let state = model.start();
            let posed = model.posed(&state);
            for (p, d) in (0..places.len()).flat_map(|p| (0..free.len()).map(move |d| (p, d))) {
                let moved = |by: f64| {
                    let mut state = state.clone();
                    state[d] += by;
                    model.posed(&state).at(p)
                };
                let expected = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                assert!((posed.slope(p).column(d) - expected).amax() < 1e-9, "case {case}");
            }
        }
    }
}
