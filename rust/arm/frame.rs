//! A camera frame of the arm, with what the IMU has said up to it: what every method takes.

use super::cues::landmark::SeenLandmark;
use super::cues::length::UpperArmLength;
use super::cues::rest::Rest;
use super::cues::upper_arm::Direction;
use super::cues::{Cue, CueName};
use super::motion::Motion;
use super::posed::{Moment, Sighting};
use super::state::{Layout, Noise};
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
    /// What the IMU says at its time.
    pub fn moment(&self) -> Moment {
        let Self { time_s, world_sensor, acceleration, stale_s, .. } = *self;
        Moment { time_s, world_sensor, acceleration, stale_s }
    }

    /// What a cue says in this frame, of a state that has these columns: as many measurements as there are.
    pub fn cues(&self, name: CueName, layout: Layout, noise: &Noise) -> Vec<Box<dyn Cue + '_>> {
        match name {
            CueName::Colour => {
                let landmarks = self.landmarks.iter().filter(|seen| layout.landmarks[seen.column()].is_some());
                let patches = self.sightings.iter().map(|patch| Box::new(*patch) as Box<dyn Cue>);
                patches.chain(landmarks.map(|seen| Box::new(*seen) as Box<dyn Cue>)).collect()
            }
            CueName::ArmLength => match self.upper_arm.filter(|_| layout.upper_arm.is_some()) {
                Some(direction) => vec![Box::new(direction)],
                None => vec![Box::new(UpperArmLength)],
            },
            CueName::Rest if self.is_rest => vec![Box::new(Rest::new(noise))],
            CueName::Rest => Vec::new(),
        }
    }

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
