//! The body as a mixture of Gaussians over its channels and their velocities: a limb that leans towards the camera and one that
//! leans away from it look alike, and are components.
//!
//! Not in the paper. It needs joints that a detector saw, or orientations of sensors: what is linear enough to correct by.

use super::cues::keypoints::{KeypointDistance, nearest};
use super::cues::{CueName, Frame};
use super::figure::Figure;
use super::method::MixtureMethod;
use super::moment::Moment;
use super::momentum::{Momentum, Moving};
use super::skin::Blobs;
use super::trajectory::Body;
use super::unseen::Known;
use crate::Result;
use crate::estimate::Estimate;
use crate::filter::{Gaussian, Mixture, Reduction};
use crate::projection::Projected;
use nalgebra::{DMatrix, DVector, Vector2};
use serde::{Deserialize, Serialize};

/// There may be so many times the components that are kept, while they are split; then they are merged.
const SPLIT_TO: usize = 2;
const MERGE_WITHIN: f64 = 0.5;
const LEAST_WEIGHT: f64 = 1e-4;
/// A component is split where a joint bends away from its slope by more than this share of its keypoint's spread.
const BENT: f64 = 0.2;
/// How often what is seen is linearised.
const TIMES: usize = 3;
/// How soon is forgotten what told components apart, s: a detector's errors last, so that they tell less than they seem to.
const MEMORY_S: f64 = 1.3;
/// Limbs that may lean either way: near and far end among the figure's points.
const LIMBS: [[usize; 2]; 4] = [[2, 4], [3, 5], [4, 6], [5, 7]];

/// A mixture filter of the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyMixture {
    momentum: Momentum,
    /// Components that are kept.
    most: usize,
    state: Mixture,
}

impl BodyMixture {
    /// About the figure's own pose.
    pub fn new(figure: &Figure, method: &MixtureMethod) -> Self {
        let MixtureMethod { components, momentum } = *method;
        Self::about(momentum.of(figure).start(&figure.model.start(), 1.0), momentum, components)
    }

    /// About a state; at most `most` components are kept.
    pub(super) fn about(state: Gaussian, momentum: Momentum, most: usize) -> Self {
        Self { momentum, most, state: Mixture::new(state) }
    }

    /// Take a frame.
    ///
    /// # Errors
    /// [`crate::Error::Singular`].
    pub(super) fn update(&mut self, moment: &Moment<'_>) -> Result<Estimate> {
        let Moment { figure, projection, picture, orientations, time_s, elapsed_s, since_s, bare, .. } = *moment;
        let (method, moving) = (moment.method.for_postures(elapsed_s, self.momentum.lasts_s), self.momentum.of(figure));
        let layer = Body::whole(&method);
        let body = Body { figure, projection, method: &method, layer: &layer, moving: &moving };
        self.predict(&moving, elapsed_s);
        // Between two components there is no pose.
        let expected = figure.seen(projection, &self.parts()[0].1.mean.as_slice()[..figure.model.dim()]);
        let person = nearest(&picture.keypoints, figure, &expected, method.cue_parameters.keypoints);
        let (blobs, person) = (Blobs::default(), person.as_ref());
        let frame = Frame { figure, projection, picture, orientations, blobs, person, bare };
        self.correct(body, &frame, time_s)?;
        // It sees no outlines.
        let known = Known { since_s, by_outlines: false, root_m: figure.root_height_m() };
        Ok(moment.posing().estimate(time_s, known, &self.parts(), blobs))
    }

    /// Its components and their weights, the heaviest first.
    pub(super) fn parts(&self) -> Vec<(f64, &Gaussian)> {
        let mut parts: Vec<_> = self.state.components().iter().map(|c| (c.log_weight.exp(), &c.gaussian)).collect();
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        parts
    }

    /// Move by `elapsed_s`, as channels move.
    pub(super) fn predict(&mut self, moving: &Moving, elapsed_s: f64) {
        if elapsed_s > 0.0 {
            self.state.forget((-elapsed_s / MEMORY_S).exp());
            self.state.for_each(|gaussian| {
                moving.predict(elapsed_s, gaussian);
                moving.bound(gaussian);
            });
        }
    }

    /// Correct by all that a frame shows.
    ///
    /// # Errors
    /// [`crate::Error::Singular`].
    pub(super) fn correct(&mut self, body: Body<'_>, frame: &Frame<'_>, time_s: f64) -> Result<()> {
        if body.layer.cues.contains(&CueName::Keypoints) {
            self.state.split(SPLIT_TO * self.most + 1, |gaussian| bent(body, frame, gaussian));
        }
        let measured = |state: &DVector<f64>, covariance: &DMatrix<f64>| {
            Ok(body.measured(frame, &body.sloped(state).within(covariance)).uncounted().linear(body.moving.dim()))
        };
        self.state.correct(time_s, TIMES, measured)?;
        self.state.reduce(&Reduction { most: self.most, merge_within: MERGE_WITHIN, least_weight: LEAST_WEIGHT });
        Ok(())
    }
}

/// Along which a Gaussian is split `(2 D,)`: how far towards the camera a limb leans, where its far end moves on a circle within
/// the spread of that, and not on a line.
fn bent(body: Body<'_>, frame: &Frame<'_>, gaussian: &Gaussian) -> Option<DVector<f64>> {
    let Body { figure, projection, method, layer, .. } = body;
    let dim = figure.model.dim();
    let at = body.sloped(&gaussian.mean);
    let parameters = method.cue_parameters.keypoints;
    let seen = KeypointDistance { person: frame.person?, groups: &layer.mover.groups, parameters }.off(&at);
    let mut most: Option<(f64, DVector<f64>)> = None;
    for [near, far] in LIMBS {
        let Some(spread) = seen.iter().find(|off| off.point == far).map(|off| off.spread) else { continue };
        let away = projection.viewing_direction(at.at(near));
        let mut lean = DVector::zeros(gaussian.mean.len());
        lean.rows_mut(0, dim).copy_from(&(at.slope(far) - at.slope(near)).tr_mul(&away));
        let with = &gaussian.covariance * &lean;
        let sd = lean.dot(&with).sqrt();
        let state = |times: f64| (&gaussian.mean + &with * (times / sd)).rows(0, dim).into_owned();
        let pixel = |times: f64| place(figure.seen(projection, state(times).as_slice())[far]);
        let bend = 0.5 * (pixel(1.0) + pixel(-1.0)) - pixel(0.0);
        let share = bend.norm() / spread;
        if share > most.as_ref().map_or(BENT, |most| most.0) {
            most = Some((share, lean.normalize()));
        }
    }
    most.map(|(_, lean)| lean)
}

fn place(seen: Projected) -> Vector2<f64> {
    Vector2::new(seen.u, seen.v)
}
