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
use serde::{Deserialize, Serialize};

/// Frames that follow each other faster say the same again, s: where a patch sits on a wrist, what skin, strap and shoulder do
/// and how an arm bends is alike in them, and a filter that took each for news would be too sure of it.
pub const NEWS_S: f64 = 0.03;

/// Which frames a worn arm's filter is corrected by.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct News {
    /// When each camera last said something new, and when anything did.
    of_camera_s: Vec<Option<f64>>,
    last_s: Option<f64>,
}

impl News {
    /// Whether a frame, each later than the one before, says something new, of these cameras or, where none saw the patch, at
    /// all: some 30 in a second of each camera do, however many there are.
    pub fn is_new(&mut self, time_s: f64, cameras: impl Iterator<Item = usize> + Clone) -> bool {
        let is_due = |last_s: Option<f64>| last_s.is_none_or(|last_s| time_s - last_s >= NEWS_S);
        let of_camera = |camera: usize| self.of_camera_s.get(camera).copied().flatten();
        let is_new = match cameras.clone().next() {
            Some(_) => cameras.clone().any(|camera| is_due(of_camera(camera))),
            None => is_due(self.last_s),
        };
        if is_new {
            self.last_s = Some(time_s);
            for camera in cameras {
                self.of_camera_s.resize(self.of_camera_s.len().max(camera + 1), None);
                self.of_camera_s[camera] = Some(time_s);
            }
        }
        is_new
    }
}

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
    /// Where the wrist rests: by how much it trembles, standard deviation of its velocity, m/s per axis.
    pub rest: Option<f64>,
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
            CueName::Rest => {
                self.rest.iter().map(|tremor| Box::new(Rest::new(*tremor, noise)) as Box<dyn Cue>).collect()
            }
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
            rest: None,
            sightings: Vec::new(),
            landmarks: Vec::new(),
            upper_arm: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_thirty_frames_a_second_are_news() {
        for (rate_hz, expected) in
            [(12.0, 12), (25.0, 25), (30.0, 30), (50.0, 25), (60.0, 30), (120.0, 30), (240.0, 30)]
        {
            let mut news = News::default();
            let frames = 0..(10.0 * rate_hz) as u32;
            let count = frames.filter(|k| news.is_new(f64::from(*k) / rate_hz, std::iter::once(0))).count();
            assert_eq!(count, 10 * expected, "{rate_hz}");
        }
    }

    #[test]
    fn cameras_that_take_turns_are_all_heard() {
        let mut news = News::default();
        let mut heard = [0, 0];
        for k in 0..60_u32 {
            let camera = (k % 2) as usize;
            heard[camera] += usize::from(news.is_new(f64::from(k) / 60.0, std::iter::once(camera)));
        }
        assert_eq!(heard, [30, 30]);
        // Between them a frame without the patch is none.
        assert!(!news.is_new(59.5 / 60.0, std::iter::empty()));
        assert!(news.is_new(62.0 / 60.0, std::iter::empty()));
    }
}
