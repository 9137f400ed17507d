//! A share of the particles that is filtered on its own.
//!
//! A pose with an arm that points at the camera has two depths. Resampling lets one of them die out by chance, and the cloud
//! that is left is surer than it should be. Islands are independent filters of equal say (unlike those of Vergé et al.,
//! Statistics and Computing 25, 2015, which are weighed against each other): where they disagree, the depth is not
//! known, and the spread of all of them together says so.

use super::cues::Weighing;
use super::cues::keypoints::{Person, nearest};
use super::figure::{Figure, KEY_JOINTS};
use super::method::{BodyMethod, Frame};
use super::skin::{Assignment, Blobs};
use super::tracker::BodyEvidence;
use crate::Result;
use crate::filter::{Layer, LayeredFilter, Recorder};
use crate::particles::ParticleSet;
use crate::projection::Projection;
use serde::{Deserialize, Serialize};

/// A filter and the blobs that it gives to head and hands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Island {
    filter: LayeredFilter,
    assignment: Assignment,
}

/// What an island knows at one frame.
pub(super) struct Posterior {
    /// Before the last resampling.
    pub particles: ParticleSet,
    /// The blob that each wearer was given, px.
    pub blobs: Blobs,
}

/// What every island sees of one frame.
pub(super) struct Sight<'a> {
    pub figure: &'a Figure,
    pub projection: &'a Projection,
    pub method: &'a BodyMethod,
    pub evidence: &'a BodyEvidence,
    pub time_s: f64,
    /// Since the frame before; 0 at the first.
    pub elapsed_s: f64,
    /// How bare the forearms are, 0 to 1.
    pub bare: f64,
}

impl Island {
    /// `len` particles at the figure's own pose.
    pub fn new(figure: &Figure, method: &BodyMethod, len: usize, seed: u64) -> Result<Self> {
        let start = figure.model.start();
        let mut particles = ParticleSet::new(len, start.len())?;
        particles.for_each_block(|_, mut block| {
            for (d, value) in start.iter().enumerate() {
                block.column_mut(d).fill(*value);
            }
        });
        let filter = LayeredFilter::new(particles, method.resampling, seed);
        Ok(Self { filter, assignment: Assignment::new(method.gate_m) })
    }

    /// The particles as they stand.
    pub fn particles(&self) -> &ParticleSet {
        self.filter.particles()
    }

    /// One cycle.
    pub fn update(&mut self, sight: &Sight<'_>, recorder: Option<&mut dyn Recorder>) -> Result<Posterior> {
        let Sight { figure, projection, method, evidence, time_s, elapsed_s, bare } = *sight;
        let (blobs, person) = self.assign(sight);
        let frame = Frame { figure, projection, evidence, blobs, person, bare };
        let walks: Vec<_> = method.layers.iter().map(|layer| method.walk(figure, layer, elapsed_s)).collect();
        let weighings: Vec<Weighing<'_>> = method.layers.iter().map(|layer| method.weighing(layer, &frame)).collect();
        let layers: Vec<Layer<'_>> = walks
            .iter()
            .zip(&weighings)
            .map(|(walk, weighing)| Layer { transition: walk, likelihoods: vec![weighing] })
            .collect();
        self.filter.cycle(time_s, &layers, recorder, |particles, _| Posterior { particles: particles.clone(), blobs })
    }

    /// Blobs to wearers, and which of the people found is this one, by where the mean of the particles expects them.
    fn assign<'a>(&mut self, sight: &Sight<'a>) -> (Blobs, Option<&'a Person>) {
        let Sight { figure, projection, method, evidence, .. } = *sight;
        let (mean, _) = self.filter.particles().moments();
        let seen = figure.seen(projection, mean.as_slice());
        let expected = [0, 1, 2].map(|wearer| {
            let [a, b] = [0, 1].map(|end| seen[KEY_JOINTS.len() + 2 * wearer + end]);
            [0.5 * (a.u + b.u), 0.5 * (a.v + b.v)]
        });
        let blobs = self.assignment.assign(&evidence.blobs, &expected, seen[0].px_per_m);
        (blobs, nearest(&evidence.keypoints, figure, &seen, method.keypoints))
    }
}

/// The blob that most islands gave to each wearer; of as many, the first.
pub(super) fn most_given(posteriors: &[Posterior]) -> Blobs {
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
