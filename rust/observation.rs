//! What reaches a tracker, from a recording or from a live source: a time, and what was observed then.

use crate::arm::cues::landmark::Landmark;
use crate::body::Picture;
use crate::body::cues::orientation::{Orientation, Segment};
use crate::quaternion::Quaternion;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};
use std::fmt;
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

/// Who observed: each source numbers its own observations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The IMU on an arm's forearm.
    Forearm,
    /// An IMU on a segment, of a body or of an arm besides the forearm's.
    Worn(Segment),
    /// A camera, by its number.
    Camera(usize),
    /// All cameras of an arm, which see a frame together.
    Cameras,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Forearm => f.write_str("forearm"),
            Self::Worn(segment) => f.write_str(segment.name()),
            Self::Camera(number) => write!(f, "camera[{number}]"),
            Self::Cameras => f.write_str("cameras"),
        }
    }
}

/// An observation at its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Recording time, s.
    pub time_s: f64,
    /// Who observed.
    pub source: Source,
    /// Its number among those of its source, from 0, for messages; none where nobody counted.
    pub index: Option<usize>,
    /// What was observed.
    pub what: What,
}

impl Observation {
    /// Of an IMU on the forearm.
    pub fn inertial(sample: Sample) -> Self {
        Self::new(sample.time_s, Source::Forearm, What::Inertial(sample))
    }

    /// Where a camera saw shoulder or elbow of an arm.
    pub fn landmark(time_s: f64, landmark: Landmark) -> Self {
        Self::new(time_s, Source::Camera(landmark.camera), What::Landmark(landmark))
    }

    /// A frame: where each camera saw the patch.
    pub fn patch(time_s: f64, pixels: Vec<Option<Vector2<f64>>>) -> Self {
        Self::new(time_s, Source::Cameras, What::Patch(pixels))
    }

    /// How a segment that wears an IMU is turned.
    pub fn orientation(time_s: f64, orientation: Orientation) -> Self {
        Self::new(time_s, Source::Worn(orientation.segment), What::Orientation(orientation))
    }

    /// A frame: what a body's camera shows.
    pub fn picture(time_s: f64, picture: Arc<Picture>) -> Self {
        Self::new(time_s, Source::Camera(0), What::Picture(picture))
    }

    fn new(time_s: f64, source: Source, what: What) -> Self {
        Self { time_s, source, index: None, what }
    }

    /// The same with its number among those of its source.
    #[must_use]
    pub fn numbered(self, index: usize) -> Self {
        Self { index: Some(index), ..self }
    }
}
