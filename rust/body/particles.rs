//! The body as a particle set: evidence weighs it, layer by layer, on islands.

use super::cues::Frame;
use super::cues::keypoints::{Person, nearest};
use super::figure::Figure;
use super::joints::KEY_JOINTS;
use super::method::{BodyMethod, ParticleMethod};
use super::moment::Moment;
use super::skin::{Assignment, Blobs};
use super::smooth::{Recorded, seen_by_particles};
use super::trajectory::{Kept, Outlined};
use super::unseen::Known;
use super::weighing::Weighing;
use crate::Result;
use crate::estimate::{Estimate, Point};
use crate::filter::{Blend, Islands, Layer, LayeredFilter, Recorder};
use crate::particles::ParticleSet;
use crate::projection::Projection;
use crate::smoothing::Windowed;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Particles over the poses of one body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyParticles {
    method: ParticleMethod,
    islands: Islands,
    /// Of blobs to head and hands, island by island.
    assignments: Vec<Assignment>,
    /// Outlines and skin were all that showed the body last.
    by_outlines: bool,
    /// What every frame brought, where the recording is smoothed.
    kept: Vec<Kept>,
}

/// What an island knows at one frame.
struct Posterior {
    /// Before the last resampling.
    particles: ParticleSet,
    blobs: Blobs,
}

impl BodyParticles {
    /// All particles at the figure's own pose (paper IV-C1); blobs are given to head and hands within `gate_m`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`], [`crate::Error::Size`].
    pub fn new(figure: &Figure, method: ParticleMethod, gate_m: f64, seed: u64) -> Result<Self> {
        let ParticleMethod { particles, islands: count, resampling, .. } = method;
        let islands = Islands::new(&figure.model.start(), particles, count, resampling, seed)?;
        let assignments = vec![Assignment::new(gate_m); count];
        Ok(Self { method, islands, assignments, by_outlines: true, kept: Vec::new() })
    }

    /// The particles as they stand, of all islands.
    pub fn particles(&self) -> ParticleSet {
        self.islands.particles()
    }

    /// Whether outlines and skin were all that showed the body last.
    pub(super) fn by_outlines(&self) -> bool {
        self.by_outlines
    }

    /// Take a frame; `recorder` sees every layer, island by island.
    ///
    /// # Errors
    /// [`crate::Error::AllWeightsZero`].
    pub(super) fn update(&mut self, moment: &Moment<'_>, recorder: Option<&mut dyn Recorder>) -> Result<Estimate> {
        let Self { method, islands, assignments, by_outlines, kept } = self;
        let for_particles = moment.method.for_particles(moment.elapsed_s);
        let moment = Moment { method: &for_particles, ..*moment };
        let Moment { figure, projection, time_s, since_s, .. } = moment;
        let posteriors = islands.each(assignments, recorder, |filter, assignment, recorder| {
            moment.update(method, filter, assignment, recorder)
        })?;
        let sets: Vec<&ParticleSet> = posteriors.iter().map(|posterior| &posterior.particles).collect();
        let together = ParticleSet::together(&sets);
        let joints = figure.key_joints(&together);
        let blobs = most_given(&posteriors);
        let (mean, covariance) = together.moments();
        let person = moment.person(&mean);
        *by_outlines = person.is_none() && moment.picture.edges.is_some();
        let seen = || seen_by_particles(projection, &joints.summary(joints.dim()));
        let seen = method.smoothing.as_ref().and_then(|_| person.or_else(|| by_outlines.then(seen)));
        let joints = figure.in_balance(joints);
        let mut joints = joints.summary(joints.dim());
        let known = Known { since_s, by_outlines: *by_outlines, root_m: figure.root_height_m() };
        moment.method.unseen.add(&mut joints, projection, known);
        let places: Vec<_> = (0..KEY_JOINTS.len()).map(|joint| Point::of_columns(&joints, 3 * joint)).collect();
        if method.smoothing.is_some() {
            let (orientations, mean) = (moment.orientations.to_vec(), mean.as_slice().to_vec());
            let outlined = by_outlines.then(|| Outlined { covariance, places: places.clone() });
            kept.push(Kept { time_s, seen, orientations, mean, outlined, blobs });
        }
        Ok(Estimate {
            time_s,
            state: together.summary(together.dim()),
            places,
            ess: Some(together.ess()),
            // Distances and losses are no normalised densities: their mean is no evidence.
            log_evidence: None,
            doubt: None,
            blobs,
        })
    }

    /// Frames so far, from number `first` on, each given those about it: as many as are smoothed together; none beyond the
    /// last, or of a method that does not smooth.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], [`crate::Error::RanAway`] where no trajectory is found.
    pub(super) fn smoothed(
        &self,
        (figure, projection, method): (&Figure, &Projection, &BodyMethod),
        first: usize,
    ) -> Result<Windowed> {
        self.method.smoothing.as_ref().map_or(Ok(Windowed::default()), |momentum| {
            Recorded { figure, projection, method, momentum, frames: &self.kept }.window(first)
        })
    }
}

impl Moment<'_> {
    /// One cycle of an island.
    fn update(
        &self,
        particles: &ParticleMethod,
        filter: &mut LayeredFilter,
        assignment: &mut Assignment,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Posterior> {
        let Self { figure, projection, method, picture, orientations, time_s, elapsed_s, bare, .. } = *self;
        let (blobs, person) = self.assign(filter.particles(), assignment);
        let frame = Frame { figure, projection, picture, orientations, blobs, person: person.as_ref(), bare };
        let walks: Vec<_> = method.layers.iter().map(|layer| particles.walk(figure, &layer.mover, elapsed_s)).collect();
        let weighings: Vec<Weighing<'_>> = method.layers.iter().map(|layer| method.weighing(layer, &frame)).collect();
        let layers: Vec<Layer<'_>> = walks
            .iter()
            .zip(&weighings)
            .map(|(walk, weighing)| Layer { transition: walk, likelihoods: vec![weighing], blend: Blend::PRODUCT })
            .collect();
        filter.cycle(time_s, &layers, recorder, |particles, _| Posterior { particles: particles.clone(), blobs })
    }

    /// Which of the people found is this one, by where a pose has the joints.
    fn person(&self, pose: &DVector<f64>) -> Option<Person> {
        let Self { figure, projection, method, picture, .. } = *self;
        let seen = figure.seen(projection, pose.as_slice());
        nearest(&picture.keypoints, figure, &seen, method.cue_parameters.keypoints)
    }

    /// Blobs to wearers, and which of the people found is this one, by where the mean of the particles expects them.
    fn assign(&self, particles: &ParticleSet, assignment: &mut Assignment) -> (Blobs, Option<Person>) {
        let Self { figure, projection, picture, .. } = *self;
        let (mean, _) = particles.moments();
        let seen = figure.seen(projection, mean.as_slice());
        let expected = [0, 1, 2].map(|wearer| {
            let [a, b] = [0, 1].map(|end| seen[KEY_JOINTS.len() + 2 * wearer + end]);
            [0.5 * (a.u + b.u), 0.5 * (a.v + b.v)]
        });
        let blobs = assignment.assign(&picture.blobs, &expected, seen[0].px_per_m);
        (blobs, self.person(&mean))
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
