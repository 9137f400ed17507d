//! Upper arms and forearms against the orientation of an inertial sensor that they wear.
//!
//! Not in the paper. The frame of a segment: +y from its far end to its near one (wrist to elbow, elbow to shoulder), +x
//! along the elbow's axis. Where a segment points is what a camera sees least, its depth; its roll shows in where the next
//! one goes. A forearm also turns within itself, which the state does not hold: its roll has a wide spread.

use super::super::figure::Figure;
use super::super::joints::Group;
use super::super::sloped::{Rows, Sloped};
use super::super::weighing::{Cue, Posed};
use crate::parameters::{Parameters, require_positive};
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

    /// As [`Segment::from_name`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::UpperArm(Group::LeftArm) => "left_upper_arm",
            Self::UpperArm(_) => "right_upper_arm",
            Self::Forearm(Group::LeftArm) => "left_forearm",
            Self::Forearm(_) => "right_forearm",
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

impl Orientation {
    /// Of an upper arm: from elbow to shoulder, of unit length, world; none of a forearm.
    pub fn to_shoulder(&self) -> Option<Vector3<f64>> {
        matches!(self.segment, Segment::UpperArm(_)).then(|| self.q_world_segment * Vector3::y())
    }
}

/// How much orientations count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OrientationParameters {
    /// How many times the spread of a single frame: errors of neighbouring frames are much alike.
    pub inflation: f64,
}

impl OrientationParameters {
    /// Of a method's `orientation_inflation`.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self { inflation: from.get("orientation_inflation")? })
    }

    /// Check its range.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_positive("orientation_inflation", self.inflation, "a positive number")
    }
}

/// Half the squares of the angles between what sensors say and the posed segments, in standard deviations.
pub struct OrientationDistance<'a> {
    /// What they say.
    pub orientations: &'a [Orientation],
    /// Groups whose segments count.
    pub groups: &'a [Group],
    /// How much they count.
    pub parameters: OrientationParameters,
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

impl Orientation {
    fn linearise(&self, at: &Sloped<'_>, inflation: f64, rows: &mut Rows) {
        let [near, far, elbow] = self.segment.ends();
        let reach = at.at(near) - at.at(far);
        let Some(along) = Unit::try_new(reach, 1e-9) else { return };
        // Beyond its reach it says less and less.
        let variance = |off: f64, sd: f64| (inflation * sd * (1.0 + (off / (REACH * inflation * sd)).powi(2))).powi(2);
        let measured = self.q_world_segment * Vector3::y();
        let off = measured - *along;
        let slope = (at.slope(near) - at.slope(far)) / reach.norm();
        let across = &slope - *along * along.tr_mul(&slope);
        rows.push_vector(off, &across, variance(off.norm(), self.sd));
        if self.roll_sd.is_finite() {
            let swing = UnitQuaternion::rotation_between(&measured, &along).unwrap_or_default();
            let turned = swing * (self.q_world_segment * Vector3::x());
            let end = at.figure.elbow_axes[usize::from(self.segment.group() == Group::RightArm)];
            let (axis, aside) = (at.at(end) - at.at(elbow), along.cross(&turned));
            let (sin, cos) = (axis.dot(&aside), axis.dot(&turned));
            let (roll, squared) = (sin.atan2(cos), sin.hypot(cos).powi(2).max(1e-9));
            let slope = (at.slope(end) - at.slope(elbow)).tr_mul(&((aside * cos - turned * sin) / squared));
            rows.push(-roll, slope, variance(roll, self.roll_sd));
        }
    }
}

impl Cue for OrientationDistance<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        let worn = || self.orientations.iter().filter(|worn| self.groups.contains(&worn.segment.group()));
        for (i, out) in out.iter_mut().enumerate() {
            *out = worn().map(|worn| worn.loss(posed, i, self.parameters.inflation)).sum();
        }
    }

    /// Direction and roll, as vectors: an angle's slope has no end where it turns over.
    fn linearise(&self, at: &Sloped<'_>, rows: &mut Rows) {
        for worn in self.orientations.iter().filter(|worn| self.groups.contains(&worn.segment.group())) {
            worn.linearise(at, self.parameters.inflation, rows);
        }
    }

    fn reads(&self, figure: &Figure) -> usize {
        figure.model.len()
    }
}
