//! A camera frame of the arm, with what the IMU has said up to it: what every method takes.

use super::colour::Sighting;
use super::landmark::SeenLandmark;
use super::motion::Motion;
use super::upper_arm::Direction;
use super::worn::WornMotion;
use crate::quaternion::Quaternion;
use nalgebra::Vector3;

/// What a frame brings to any method.
#[derive(Debug, Clone)]
pub struct Frame<'a> {
    /// Recording time, s.
    pub time_s: f64,
    /// Composed motion since the last frame.
    pub motion: Motion,
    /// The same for a worn sensor, where it is composed.
    pub worn: Option<WornMotion>,
    /// Orientation at the last frame.
    pub last_world_sensor: Quaternion,
    /// Orientation now.
    pub world_sensor: Quaternion,
    /// Acceleration now, world, m/s², as measured.
    pub acceleration: Vector3<f64>,
    /// For how long nothing has said how the sensor is oriented, s.
    pub stale_s: f64,
    /// Whether the sensor lies still.
    pub is_rest: bool,
    /// Where the patch was seen, if it was.
    pub sightings: Vec<Sighting<'a>>,
    /// Which joints were seen besides, and where.
    pub landmarks: Vec<SeenLandmark<'a>>,
    /// Where the upper arm points, by its sensor.
    pub upper_arm: Option<Direction>,
}

impl Frame<'_> {
    /// One that brings nothing.
    pub fn empty(time_s: f64, world_sensor: Quaternion) -> Self {
        Self {
            time_s,
            motion: Motion::none(),
            worn: None,
            last_world_sensor: world_sensor,
            world_sensor,
            acceleration: Vector3::zeros(),
            stale_s: 0.0,
            is_rest: false,
            sightings: Vec::new(),
            landmarks: Vec::new(),
            upper_arm: None,
        }
    }
}
