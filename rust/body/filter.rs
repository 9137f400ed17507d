//! The body as a tracker's subject: an image's evidence in, a pose with error bars out.

use super::cues::keypoints::{Person, nearest};
use super::cues::orientation::Orientation;
use super::cues::region::bareness;
use super::cues::{Frame, Picture};
use super::figure::Figure;
use super::joints::KEY_JOINTS;
use super::method::BodyMethod;
use super::skin::{Assignment, Blobs};
use super::smooth::{Recorded, seen};
use super::trajectory::Kept;
use super::unseen::{UNSEEN, Unseen};
use super::weighing::Weighing;
use crate::error::{require, require_time};
use crate::estimate::{Estimate, Point};
use crate::filter::{Blend, Islands, Layer, LayeredFilter, Recorder};
use crate::particles::ParticleSet;
use crate::projection::Projection;
use crate::smoothing::Windowed;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// No angle is less known.
const MOST_RAD: f64 = 10.0;
/// An orientation older than this says nothing of a frame, s.
const STALE_S: f64 = 0.1;

/// The latest orientation of a segment that wears a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Worn {
    time_s: f64,
    orientation: Orientation,
}

/// Particles over the poses of one body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyFilter {
    figure: Figure,
    projection: Projection,
    method: BodyMethod,
    islands: Islands,
    /// Of blobs to head and hands, island by island.
    assignments: Vec<Assignment>,
    /// Segment by segment.
    worn: Vec<Worn>,
    /// Times of the first and the last.
    frames_s: Option<[f64; 2]>,
    /// How bare the forearms are, told at the first frame that shows skin.
    bare: Option<f64>,
    /// What every frame brought, where the recording is smoothed.
    kept: Vec<Kept>,
}

/// What every island sees of one frame.
struct AtFrame<'a> {
    figure: &'a Figure,
    projection: &'a Projection,
    method: &'a BodyMethod,
    picture: &'a Picture,
    orientations: &'a [Orientation],
    time_s: f64,
    elapsed_s: f64,
    bare: f64,
}

/// What an island knows at one frame.
struct Posterior {
    /// Before the last resampling.
    particles: ParticleSet,
    blobs: Blobs,
}

impl BodyFilter {
    /// All particles at the figure's own pose (paper IV-C1).
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::Size`].
    pub fn new(figure: Figure, projection: Projection, method: BodyMethod, seed: u64) -> Result<Self> {
        method.check()?;
        let BodyMethod { particles, islands: count, resampling, cue_parameters, balance, .. } = method;
        let figure = figure.balanced(&projection, balance);
        let islands = Islands::new(&figure.model.start(), particles, count, resampling, seed)?;
        let assignments = vec![Assignment::new(cue_parameters.blobs.gate_m); count];
        let (worn, frames_s, bare, kept) = (Vec::new(), None, None, Vec::new());
        Ok(Self { figure, projection, method, islands, assignments, worn, frames_s, bare, kept })
    }

    /// The figure.
    pub fn figure(&self) -> &Figure {
        &self.figure
    }

    /// The particles as they stand, of all islands: the free channels; then, where the method has it, what the camera does
    /// not see: distance, m, lean and turn, rad.
    pub fn particles(&self) -> ParticleSet {
        let particles = self.islands.particles();
        if self.method.unseen.is_none() {
            return particles;
        }
        let [first_s, last_s] = self.frames_s.unwrap_or_default();
        self.method.unseen.drawn(&particles, last_s - first_s)
    }

    /// Where states put the key joints, `(N, 8 * 3)`, m: of the free channels, or with columns of what is not seen besides.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of columns.
    pub fn pose(&self, states: &ParticleSet) -> Result<ParticleSet> {
        let dim = self.figure.model.dim();
        if states.dim() != dim + UNSEEN || self.method.unseen.is_none() {
            return self.figure.joints_of(states);
        }
        let seen = states.mapped(dim, |block, out| {
            (0..dim).for_each(|d| out.column_mut(d).copy_from_slice(block.column(d)));
        });
        let (joints, states) = (self.figure.joints_of(&seen)?, states.rows());
        let each = joints
            .rows()
            .chunks(joints.dim())
            .zip(states.chunks(dim + UNSEEN))
            .flat_map(|(joints, state)| {
                Unseen::moved(joints, [state[dim], state[dim + 1], state[dim + 2]], &self.projection)
            })
            .collect::<Vec<_>>();
        ParticleSet::from_rows(joints.dim(), &each)
    }

    /// Take what a sensor says of the segment that wears it; it holds for a tenth of a second.
    ///
    /// # Errors
    /// [`Error::Late`], [`Error::NotFinite`], [`Error::Parameter`]; the filter is then as before.
    pub fn take(&mut self, time_s: f64, orientation: &Orientation) -> Result<()> {
        require_time("orientation time", time_s)?;
        if let Some(odd) = orientation.q_world_segment.coords.iter().find(|x| !x.is_finite()) {
            return Err(Error::NotFinite { name: "orientation", time_s, value: *odd });
        }
        let Orientation { sd, roll_sd, segment, .. } = *orientation;
        require(sd > 0.0 && sd <= MOST_RAD, "spread of an orientation", sd, "a positive angle")?;
        require(roll_sd > 0.0, "spread of a roll", roll_sd, "a positive angle, or infinite")?;
        let orientation = *orientation;
        match self.worn.iter_mut().find(|worn| worn.orientation.segment == segment) {
            Some(worn) if time_s <= worn.time_s => {
                return Err(Error::Late { what: "orientation", time_s, latest_s: worn.time_s });
            }
            Some(worn) => *worn = Worn { time_s, orientation },
            None => self.worn.push(Worn { time_s, orientation }),
        }
        Ok(())
    }

    /// Take a frame that was checked, `elapsed_s` after the last. The first moves nothing: the figure's pose is the pose
    /// there. `recorder` sees every layer, island by island.
    ///
    /// # Errors
    /// [`Error::AllWeightsZero`] and [`Error::RanAway`], after which it must not be used again.
    pub fn update(
        &mut self,
        time_s: f64,
        elapsed_s: f64,
        picture: &Picture,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Estimate> {
        if let (None, Some(skin)) = (self.bare, &picture.skin) {
            self.bare = Some(bareness(skin, &self.figure.seen(&self.projection, &self.figure.model.start())));
        }
        let bare = self.bare.unwrap_or(1.0);
        let fresh = self.worn.iter().filter(|worn| time_s - worn.time_s <= STALE_S);
        let orientations: Vec<Orientation> = fresh.map(|worn| worn.orientation).collect();
        let Self { figure, projection, method, islands, assignments, .. } = self;
        let orientations = orientations.as_slice();
        let sight = AtFrame { figure, projection, method, picture, orientations, time_s, elapsed_s, bare };
        let posteriors = islands
            .each(assignments, recorder, |filter, assignment, recorder| sight.update(filter, assignment, recorder))?;
        let first_s = self.frames_s.map_or(time_s, |[first_s, _]| first_s);
        self.frames_s = Some([first_s, time_s]);
        let sets: Vec<&ParticleSet> = posteriors.iter().map(|posterior| &posterior.particles).collect();
        let together = ParticleSet::together(&sets);
        let joints = self.figure.key_joints(&together);
        let blobs = most_given(&posteriors);
        if self.method.smoothing.is_some() {
            let (mean, _) = together.moments();
            let parameters = self.method.cue_parameters.keypoints;
            let joints = joints.summary(joints.dim());
            let seen = seen((&self.figure, &self.projection), picture, parameters, (&mean, &joints));
            let (orientations, mean) = (orientations.to_vec(), mean.as_slice().to_vec());
            self.kept.push(Kept { time_s, seen, orientations, mean, blobs });
        }
        let joints = self.figure.in_balance(joints);
        let mut joints = joints.summary(joints.dim());
        self.method.unseen.add(&mut joints, &self.projection, time_s - first_s);
        let estimate = Estimate {
            time_s,
            state: together.summary(together.dim()),
            places: (0..KEY_JOINTS.len()).map(|joint| Point::of_columns(&joints, 3 * joint)).collect(),
            ess: Some(together.ess()),
            // Distances and losses are no normalised densities: their mean is no evidence.
            log_evidence: None,
            doubt: None,
            blobs,
        };
        estimate.checked()
    }

    /// Frames so far, from number `first` on, each given those about it: as many as are smoothed together; none beyond the
    /// last, or of a method that does not smooth.
    ///
    /// # Errors
    /// [`Error::Singular`], [`Error::RanAway`] where no trajectory is found.
    pub(crate) fn smoothed(&self, first: usize) -> Result<Windowed> {
        let Self { figure, projection, method, kept, .. } = self;
        method.smoothing.as_ref().map_or(Ok(Windowed::default()), |momentum| {
            Recorded { figure, projection, method, momentum, frames: kept }.window(first)
        })
    }

    /// Check what was read back.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check_parameters(&self) -> Result<()> {
        self.method.check()
    }
}

impl AtFrame<'_> {
    /// One cycle of an island.
    fn update(
        &self,
        filter: &mut LayeredFilter,
        assignment: &mut Assignment,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Posterior> {
        let Self { figure, projection, method, picture, orientations, time_s, elapsed_s, bare } = *self;
        let (blobs, person) = self.assign(filter.particles(), assignment);
        let frame = Frame { figure, projection, picture, orientations, blobs, person: person.as_ref(), bare };
        let walks: Vec<_> = method.layers.iter().map(|layer| method.walk(figure, &layer.mover, elapsed_s)).collect();
        let weighings: Vec<Weighing<'_>> = method.layers.iter().map(|layer| method.weighing(layer, &frame)).collect();
        let layers: Vec<Layer<'_>> = walks
            .iter()
            .zip(&weighings)
            .map(|(walk, weighing)| Layer { transition: walk, likelihoods: vec![weighing], blend: Blend::PRODUCT })
            .collect();
        filter.cycle(time_s, &layers, recorder, |particles, _| Posterior { particles: particles.clone(), blobs })
    }

    /// Blobs to wearers, and which of the people found is this one, by where the mean of the particles expects them.
    fn assign(&self, particles: &ParticleSet, assignment: &mut Assignment) -> (Blobs, Option<Person>) {
        let Self { figure, projection, method, picture, .. } = *self;
        let (mean, _) = particles.moments();
        let seen = figure.seen(projection, mean.as_slice());
        let expected = [0, 1, 2].map(|wearer| {
            let [a, b] = [0, 1].map(|end| seen[KEY_JOINTS.len() + 2 * wearer + end]);
            [0.5 * (a.u + b.u), 0.5 * (a.v + b.v)]
        });
        let blobs = assignment.assign(&picture.blobs, &expected, seen[0].px_per_m);
        (blobs, nearest(&picture.keypoints, figure, &seen, method.cue_parameters.keypoints))
    }
}

/// The blob that most islands gave to each wearer; of as many, the first.
fn most_given(posteriors: &[Posterior]) -> Blobs {
    std::array::from_fn(|wearer| {
        let given = |posterior: &Posterior| posterior.blobs[wearer];
        let count = |blob: Option<[f64; 2]>| posteriors.iter().filter(|p| given(p) == blob).count();
        let mut best = given(&posteriors[0]);
        for blob in posteriors.iter().map(given) {
            if count(blob) > count(best) {
                best = blob;
            }
        }
        best
    })
}
