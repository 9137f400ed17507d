//! What reaches a tracker, from a recording or from a live source: a time, and what was observed then.

use crate::arm::cues::landmark::Landmark;
use crate::body::Picture;
use crate::body::cues::orientation::Orientation;
use crate::quaternion::Quaternion;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// One IMU sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Recording time, s.
    pub time_s: f64,
    /// Specific force in the sensor frame, m/s²; at rest, z up, `(0, 0, 9.81)`.
    pub acceleration: Vector3<f64>,
    /// Sensor to world.
    pub world_sensor: Quaternion,
    /// Turn rate in the sensor frame, rad/s, where there is a gyroscope.
    pub turn_rate: Option<Vector3<f64>>,
}

/// What was observed, and by what.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// Arm: by the IMU on the forearm.
    Inertial(Sample),
    /// Arm, a frame: where each camera saw the patch, px; `None` where it did not.
    Patch(Vec<Option<Vector2<f64>>>),
    /// Arm: where a camera saw shoulder or elbow, of the frame that comes next.
    Landmark(Landmark),
    /// How a segment that wears an IMU is turned: of a body, or the upper arm of an arm.
    Orientation(Orientation),
    /// Body, a frame: what the camera shows and a detector found.
    Picture(Arc<Picture>),
}

impl What {
    /// Whether it is a frame, at which there is an estimate.
    pub fn is_frame(&self) -> bool {
        matches!(self, Self::Patch(_) | Self::Picture(_))
    }

    /// In words, for messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Inertial(_) => "IMU sample",
            Self::Landmark(_) => "landmark",
            Self::Orientation(_) => "orientation",
            Self::Patch(_) | Self::Picture(_) => "frame",
        }
    }
}

/// An observation at its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Recording time, s.
    pub time_s: f64,
    /// Its number among those of its source, from 0, for messages; none where nobody counted.
    pub index: Option<usize>,
    /// What was observed.
    pub what: What,
}

impl Observation {
    /// Of an IMU on the forearm.
    pub fn inertial(sample: Sample) -> Self {
        Self { time_s: sample.time_s, index: None, what: What::Inertial(sample) }
    }

    /// Where a camera saw shoulder or elbow of an arm.
    pub fn landmark(time_s: f64, landmark: Landmark) -> Self {
        Self { time_s, index: None, what: What::Landmark(landmark) }
    }

    /// A frame: where each camera saw the patch.
    pub fn patch(time_s: f64, pixels: Vec<Option<Vector2<f64>>>) -> Self {
        Self { time_s, index: None, what: What::Patch(pixels) }
    }

    /// How a segment that wears an IMU is turned.
    pub fn orientation(time_s: f64, orientation: Orientation) -> Self {
        Self { time_s, index: None, what: What::Orientation(orientation) }
    }

    /// A frame: what a body's camera shows.
    pub fn picture(time_s: f64, picture: Arc<Picture>) -> Self {
        Self { time_s, index: None, what: What::Picture(picture) }
    }

    /// The same with its number among those of its source.
    #[must_use]
    pub fn numbered(self, index: usize) -> Self {
        Self { index: Some(index), ..self }
    }
}
