//! A stretch of a body's recording as a chain of states that is smoothed ([`super::smooth`]).

use super::cues::keypoints::{KeypointDistance, Off, Person};
use super::cues::orientation::Orientation;
use super::cues::{CueName, Frame, Picture};
use super::figure::Figure;
use super::method::{BodyLayer, BodyMethod};
use super::momentum::Moving;
use super::skin::Blobs;
use super::sloped::{Rows, Sloped};
use crate::Result;
use crate::estimate::Point;
use crate::filter::{Chain, Gaussian, Linear, LinearTransition, cost_of};
use crate::projection::Projection;
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// How near a place is wanted to where it is pulled, m.
const PULLED_SD_M: f64 = 0.02;

/// A frame as the particles met it, and what they made of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Recording time, s.
    pub time_s: f64,
    /// Where the joints were seen: by a detector, or by the particles where there was none.
    pub seen: Option<Person>,
    /// Of segments that wore a sensor.
    pub orientations: Vec<Orientation>,
    /// The particles' mean, `(D,)`.
    pub mean: Vec<f64>,
    /// What else they say, where outlines and skin were all that they saw.
    pub outlined: Option<Outlined>,
    /// The blob given to each wearer.
    pub blobs: Blobs,
}

/// What particles say of a frame that no detector saw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outlined {
    /// Of channels, `(D, D)`.
    pub covariance: DMatrix<f64>,
    /// The key joints.
    pub places: Vec<Point>,
}

/// What is posed, by what it is seen and how it moves.
#[derive(Clone, Copy)]
pub(super) struct Body<'a> {
    pub figure: &'a Figure,
    pub projection: &'a Projection,
    pub method: &'a BodyMethod,
    /// All that it weighs by ([`Body::whole`]).
    pub layer: &'a BodyLayer,
    pub moving: &'a Moving,
}

impl<'a> Body<'a> {
    /// All that any layer weighs by, of all groups.
    pub fn whole(method: &BodyMethod) -> BodyLayer {
        let mut cues: Vec<CueName> = Vec::new();
        for cue in method.layers.iter().flat_map(|layer| &layer.cues) {
            if !cues.contains(cue) {
                cues.push(*cue);
            }
        }
        BodyLayer::whole(cues)
    }

    /// A frame that was kept, of which there is no picture any more: `nothing`.
    pub fn frame(&self, kept: &'a Kept, nothing: &'a Picture) -> Frame<'a> {
        let (figure, projection, blobs) = (self.figure, self.projection, Blobs::default());
        let (orientations, person) = (kept.orientations.as_slice(), kept.seen.as_ref());
        Frame { figure, projection, picture: nothing, orientations, blobs, person, bare: 1.0 }
    }

    /// A state's channels, posed.
    pub fn sloped(&self, state: &'a DVector<f64>) -> Sloped<'a> {
        Sloped::new(self.figure, self.projection, &state.as_slice()[..self.figure.model.dim()])
    }

    /// What every cue that is smooth measures of a state, of what a frame shows.
    pub fn measured(&self, frame: &Frame<'_>, at: &Sloped<'_>) -> Rows {
        let mut rows = Rows::default();
        for cue in self.method.cues_of(self.layer, frame) {
            cue.linearise(at, &mut rows);
        }
        rows
    }
}

/// Points of the figure that are drawn to given places: at a step, a point, the place.
pub(super) type Pulls = Vec<(usize, usize, Vector3<f64>)>;

/// Frames that follow each other, what is known where they begin, and where they must end.
pub(super) struct Trajectory<'a> {
    pub body: Body<'a>,
    pub frames: &'a [Kept],
    pub start: Gaussian,
    /// Where a longer trajectory goes on.
    pub end: Option<Gaussian>,
    pub pulls: Pulls,
}

impl Chain for Trajectory<'_> {
    fn len(&self) -> usize {
        self.frames.len()
    }

    fn time_s(&self, step: usize) -> f64 {
        self.frames[step].time_s
    }

    fn start(&self, step: usize) -> Option<Gaussian> {
        (step == 0).then(|| self.start.clone())
    }

    fn predict(&self, step: usize, state: &mut Gaussian) {
        self.body.moving.predict(self.elapsed_s(step), state);
    }

    fn transition(&self, step: usize) -> LinearTransition {
        self.body.moving.transition(self.elapsed_s(step))
    }

    fn surprise(&self, step: usize, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
        self.body.moving.surprise(self.elapsed_s(step), from, to)
    }

    fn measure(&self, step: usize, at: &DVector<f64>) -> Result<Vec<Linear>> {
        let moving = self.body.moving;
        let sloped = self.body.sloped(at);
        let mut rows = self.body.measured(&self.body.frame(&self.frames[step], &Picture::default()), &sloped);
        for (_, point, place) in self.pulls.iter().filter(|(at, ..)| *at == step) {
            rows.push_vector(place - sloped.at(*point), &sloped.slope(*point), PULLED_SD_M.powi(2));
        }
        let mut measured: Vec<Linear> = rows.linear(moving.dim()).into_iter().collect();
        if let Some(end) = self.end.as_ref().filter(|_| step + 1 == self.frames.len()) {
            let identity = DMatrix::identity(moving.dim(), moving.dim());
            measured.push((&end.mean - at, identity, end.covariance.clone()));
        }
        Ok(measured)
    }
}

impl Trajectory<'_> {
    /// Minus twice the log posterior of a trajectory, but for a constant, where so many frames' errors are alike.
    ///
    /// # Errors
    /// What cannot be linearised there.
    pub fn implausibility(&self, at: &[DVector<f64>], alike: f64) -> Result<f64> {
        let priors = [CueName::Effort, CueName::Posture, CueName::Limits];
        let layer = self.body.layer;
        let cues = layer.cues.iter().copied().filter(|cue| priors.contains(cue)).collect();
        let unseen = BodyLayer { cues, ..layer.clone() };
        let (start, end, pulls) = (self.start.clone(), self.end.clone(), Pulls::new());
        let body = Body { layer: &unseen, ..self.body };
        let prior = cost_of(&Trajectory { body, frames: self.frames, start, end, pulls }, at)?;
        Ok(prior + (cost_of(self, at)? - prior) / alike)
    }

    /// How many frames' errors are one and the same: what the sum of all errors is more than that of as many that are not alike.
    pub fn alike(&self, at: &[DVector<f64>]) -> f64 {
        let Body { figure, method, layer, .. } = self.body;
        let parameters = method.cue_parameters.keypoints;
        let (mut sums, mut squares) = (vec![Vector2::zeros(); figure.model.len()], 0.0);
        for (kept, state) in self.frames.iter().zip(at) {
            let Some(person) = &kept.seen else { continue };
            let sloped = self.body.sloped(state);
            let cue = KeypointDistance { person, groups: &layer.mover.groups, parameters };
            for Off { point, residual, spread, .. } in cue.off(&sloped) {
                let off = residual / spread;
                if off.norm() < parameters.reach {
                    sums[point] += off;
                    squares += off.norm_squared();
                }
            }
        }
        let sum: f64 = sums.iter().map(Vector2::norm_squared).sum();
        (sum / squares.max(f64::MIN_POSITIVE) / parameters.inflation.powi(2)).max(1.0)
    }

    fn elapsed_s(&self, step: usize) -> f64 {
        self.frames[step].time_s - self.frames[step - 1].time_s
    }
}
