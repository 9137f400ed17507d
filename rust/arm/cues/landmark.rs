//! Joints that a camera sees besides the patch: by a second patch, or as a detector's keypoints.
//!
//! Not in the paper, whose shoulder is still. What is seen lies beside the joint, on skin or where a detector thinks it is: by a
//! displacement in the world that is part of the state, so that a joint's movement tells and its place tells less.

use super::Cue;
use crate::arm::posed::{Posed, Sighting};
use crate::arm::state::{View, require_finite};
use crate::filter::Linear;
use crate::{Error, Result, error::require};
use nalgebra::{DMatrix, DVector, Matrix3, Vector2};
use serde::{Deserialize, Serialize};

/// Nobody sees more finely, or less, px.
const SD_PX: std::ops::RangeInclusive<f64> = 1e-3..=1e4;
/// A sighting is of the frame that comes no later after it, s.
pub const SAME_FRAME_S: f64 = 0.01;

/// What may be seen besides the patch on the wrist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SeenJoint {
    /// Of the arm.
    Shoulder,
    /// Likewise.
    Elbow,
}

impl SeenJoint {
    /// One of [`crate::arm::state::JOINTS`].
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "shoulder" => Ok(Self::Shoulder),
            "elbow" => Ok(Self::Elbow),
            _ => Err(Error::UnknownName { what: "joint", name: name.into(), known: "shoulder, elbow" }),
        }
    }
}

/// Where a camera saw a joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Landmark {
    /// Which joint.
    pub joint: SeenJoint,
    /// Which of the cameras.
    pub camera: usize,
    /// Where, px.
    pub pixel: Vector2<f64>,
    /// Standard deviation per axis, from frame to frame, px.
    pub sd: f64,
}

impl Landmark {
    /// Check its numbers, of so many cameras.
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::NotFinite`].
    pub fn check(&self, time_s: f64, cameras: usize) -> Result<()> {
        require(self.camera < cameras, "camera of a landmark", self.camera as f64, "one of the recording's, from 0")?;
        require(SD_PX.contains(&self.sd), "sd_px of a landmark", self.sd, "0.001 to 10000 px")?;
        require_finite("pixel of a landmark", time_s, self.pixel.as_slice())
    }

    /// With the camera that saw it.
    pub(in crate::arm) fn seen_by<'a>(&self, views: &'a [View]) -> SeenLandmark<'a> {
        let Self { joint, camera, pixel, sd } = *self;
        SeenLandmark { joint, sd, sighting: Sighting { view: &views[camera], camera, pixel } }
    }
}

/// A landmark with the camera that saw it.
#[derive(Debug, Clone, Copy)]
pub struct SeenLandmark<'a> {
    joint: SeenJoint,
    sd: f64,
    sighting: Sighting<'a>,
}

impl SeenLandmark<'_> {
    /// Which of [`crate::arm::state::JOINTS`] it is.
    pub(in crate::arm) fn column(&self) -> usize {
        self.joint as usize
    }
}

impl Cue for SeenLandmark<'_> {
    fn linearise(&self, posed: &Posed<'_>, state: &DVector<f64>, _: Option<&DMatrix<f64>>) -> Result<Option<Linear>> {
        let (mut place, mut by_state) = match self.joint {
            SeenJoint::Shoulder => posed.shoulder(state),
            SeenJoint::Elbow => posed.elbow_seen(state),
        };
        if let Some(column) = posed.layout.landmarks[self.column()] {
            place += state.fixed_rows::<3>(column);
            let mut by_displacement = by_state.fixed_view_mut::<3, 3>(0, column);
            by_displacement += Matrix3::identity();
        }
        let mut noise = DMatrix::from_diagonal_element(2, 2, self.sd * self.sd);
        let (pixel, slope) = match self.joint {
            SeenJoint::Shoulder => posed.pixel_beside_shoulder(&self.sighting, state, place, &by_state)?,
            SeenJoint::Elbow => {
                let (pixel, by_place, slope) = posed.pixel(&self.sighting, state, place, &by_state)?;
                let spread = by_place * posed.beside_forearm() * by_place.transpose();
                noise += DMatrix::from_column_slice(2, 2, spread.as_slice());
                (pixel, slope)
            }
        };
        let residual = DVector::from_column_slice((self.sighting.pixel - pixel).as_slice());
        Ok(Some((residual, slope, noise)))
    }
}
