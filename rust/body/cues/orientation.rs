//! Upper arms and forearms against the orientation of an inertial sensor that they wear.
//!
//! Not in the paper. The frame of a segment: +y from its far end to its near one (wrist to elbow, elbow to shoulder), +x
//! along the elbow's axis. Where a segment points is what a camera sees least, its depth; its roll shows in where the next
//! one goes. A forearm also turns within itself, which the state does not hold: its roll has a wide spread.

use super::super::figure::{Figure, Group};
use super::{Cue, Posed};
use crate::{Error, Result};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Beyond so many standard deviations a sensor says nothing more: it may have slipped.
const REACH: f64 = 4.0;

/// What can wear a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Segment {
    /// Shoulder to elbow.
    UpperArm(Group),
    /// Elbow to wrist.
    Forearm(Group),
}

impl Segment {
    /// `left_upper_arm`, `right_upper_arm`, `left_forearm` or `right_forearm`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "left_upper_arm" => Ok(Self::UpperArm(Group::LeftArm)),
            "right_upper_arm" => Ok(Self::UpperArm(Group::RightArm)),
            "left_forearm" => Ok(Self::Forearm(Group::LeftArm)),
            "right_forearm" => Ok(Self::Forearm(Group::RightArm)),
            _ => Err(Error::UnknownName {
                what: "segment",
                name: name.into(),
                known: "left_upper_arm, right_upper_arm, left_forearm, right_forearm",
            }),
        }
    }

    fn group(self) -> Group {
        match self {
            Self::UpperArm(group) | Self::Forearm(group) => group,
        }
    }

    /// Near end, far end and elbow among the points of the figure.
    fn ends(self) -> [usize; 3] {
        match self {
            Self::UpperArm(Group::LeftArm) => [2, 4, 4],
            Self::UpperArm(_) => [3, 5, 5],
            Self::Forearm(Group::LeftArm) => [4, 6, 4],
            Self::Forearm(_) => [5, 7, 5],
        }
    }
}

/// What a sensor says of the segment that wears it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Orientation {
    /// Who wears it.
    pub segment: Segment,
    /// Segment to world.
    pub q_world_segment: UnitQuaternion<f64>,
    /// Standard deviation of where it points, rad.
    pub sd: f64,
    /// Standard deviation of its roll, rad; infinite where it says nothing of it.
    pub roll_sd: f64,
}

/// Half the squares of the angles between what sensors say and the posed segments, in standard deviations.
pub struct OrientationDistance<'a> {
    /// What they say.
    pub orientations: &'a [Orientation],
    /// Groups whose segments count.
    pub groups: &'a [Group],
    /// How many times the spread of a single frame: errors of neighbouring frames are much alike.
    pub inflation: f64,
}

impl Orientation {
    fn loss(&self, posed: &Posed<'_>, particle: usize, inflation: f64) -> f64 {
        let at = |point: usize| Vector3::from(posed.at(particle, point));
        let [near, far, elbow] = self.segment.ends();
        let Some(along) = Unit::try_new(at(near) - at(far), 1e-9) else { return 0.0 };
        let measured = self.q_world_segment * Vector3::y_axis();
        let off = along.cross(&measured).norm().atan2(along.dot(&measured));
        let axis = at(posed.figure.elbow_axes[usize::from(self.segment.group() == Group::RightArm)]) - at(elbow);
        // Its roll is what is left when the one is swung onto the other.
        let swing = UnitQuaternion::rotation_between(&measured, &along).unwrap_or_default();
        let turned = swing * (self.q_world_segment * Vector3::x());
        let roll = turned.cross(&axis).dot(&along).atan2(turned.dot(&axis));
        let half_square = |angle: f64, sd: f64| 0.5 * (angle / (inflation * sd)).abs().min(REACH).powi(2);
        half_square(off, self.sd) + if self.roll_sd.is_finite() { half_square(roll, self.roll_sd) } else { 0.0 }
    }
}

impl Cue for OrientationDistance<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        let worn = || self.orientations.iter().filter(|worn| self.groups.contains(&worn.segment.group()));
        for (i, out) in out.iter_mut().enumerate() {
            *out = worn().map(|worn| worn.loss(posed, i, self.inflation)).sum();
        }
    }

    fn reads(&self, figure: &Figure) -> usize {
        figure.model.len()
    }
}
