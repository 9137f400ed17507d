//! What a filter of the body is given of one frame.

use super::cues::Picture;
use super::cues::orientation::Orientation;
use super::figure::Figure;
use super::gaussians::Posing;
use super::method::BodyMethod;
use crate::projection::Projection;

/// A frame, and whom it shows.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub figure: &'a Figure,
    pub projection: &'a Projection,
    pub method: &'a BodyMethod,
    pub picture: &'a Picture,
    /// Of segments that wear a sensor.
    pub orientations: &'a [Orientation],
    /// Recording time, s.
    pub time_s: f64,
    /// Since the last frame, and since the first, s.
    pub elapsed_s: f64,
    pub since_s: f64,
    /// How bare the forearms are, 0 to 1.
    pub bare: f64,
}

impl<'a> Moment<'a> {
    /// How Gaussians are posed there.
    pub fn posing(&self) -> Posing<'a> {
        Posing { figure: self.figure, projection: self.projection, unseen: &self.method.unseen }
    }
}
