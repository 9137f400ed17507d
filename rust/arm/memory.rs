//! What a tracker keeps of a recording of an arm, to smooth it ([`super::smooth`]).

use super::cues::landmark::Landmark;
use super::setup::Setup;
use crate::estimate::Point;
use crate::filter::Gaussian;
use crate::observation::Sample;
use crate::quaternion::Quaternion;
use nalgebra::{DVector, Vector2};
use serde::{Deserialize, Serialize};

/// A frame as the mixture met it, and what it made of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Recording time, s.
    pub time_s: f64,
    /// Orientation then.
    pub world_sensor: Quaternion,
    /// Where each camera saw the patch.
    pub pixels: Vec<Option<Vector2<f64>>>,
    /// Which joints were seen besides, and where.
    pub landmarks: Vec<Landmark>,
    /// Whether nothing has said where the arm is since a pause.
    pub is_unknown: bool,
    /// What was known beforehand, where the track starts here.
    pub start: Option<Gaussian>,
    /// Mean of the mixture, and of its heaviest component.
    pub means: [DVector<f64>; 2],
    /// What it says of each place; none where that must not be believed.
    pub filtered: Option<Vec<Point>>,
}

/// What a tracker keeps to smooth it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Every frame so far.
    pub frames: Vec<Kept>,
    /// Every sample so far.
    pub samples: Vec<Sample>,
    /// How well lengths and cameras are known.
    pub setup: Option<Setup>,
}
