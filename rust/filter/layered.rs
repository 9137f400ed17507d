//! One cycle of the layered particle filter (Tao & Hu III-E, Fig. 4, for any list of layers).

use super::{Blend, Layer, LayerRecord, Likelihood, Recorder};
use crate::particles::{BlockMut, ParticleSet};
use crate::resample::Scheme;
use crate::rng::Streams;
use crate::{Error, Result, error::require};
use serde::{Deserialize, Serialize};

/// When and how the set is resampled after a layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Resampling {
    /// How.
    pub scheme: Scheme,
    /// Resample when ESS falls to this share of `N`, 0 to 1; 1 is always (the papers).
    pub threshold: f64,
}

impl Resampling {
    /// Checked.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn new(scheme: Scheme, threshold: f64) -> Result<Self> {
        require((0.0..=1.0).contains(&threshold), "ess_threshold", threshold, "0 to 1 (1: always)")?;
        Ok(Self { scheme, threshold })
    }
}

/// A particle set that layers are applied to, cycle by cycle.
///
/// Clone or serialise it to resume later: the random streams follow from the seed and the count of cycles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LayeredFilter {
    particles: ParticleSet,
    resampling: Resampling,
    seed: u64,
    step: u64,
    #[serde(skip)]
    scratch: Scratch,
}

/// Log-likelihoods: of a layer, and of one of several likelihoods. Holds nothing between cycles.
#[derive(Debug, Clone, Default)]
struct Scratch {
    total: Vec<f64>,
    one: Vec<f64>,
}

impl PartialEq for Scratch {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LayeredFilter {
    /// Start from `particles`, drawn from the prior.
    pub fn new(particles: ParticleSet, resampling: Resampling, seed: u64) -> Self {
        Self { particles, resampling, seed, step: 0, scratch: Scratch::default() }
    }

    /// The seed of all streams.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Draw every particle anew, block by block; all weigh the same.
    pub fn start_again(&mut self, draw: impl Fn(usize, BlockMut<'_>) + Sync) {
        self.particles.weigh_equally();
        self.particles.for_each_block(draw);
    }

    /// The set as the last cycle left it.
    pub fn particles(&self) -> &ParticleSet {
        &self.particles
    }

    /// Apply `layers` in order; `posterior` sees the set before the last resampling, with the log evidence
    /// summed over the layers (`None` where no likelihood weighed anything, or what weighed was none).
    ///
    /// # Errors
    /// [`Error::AllWeightsZero`], at the time given, when no particle explains an observation.
    pub fn cycle<E: Send>(
        &mut self,
        time_s: f64,
        layers: &[Layer<'_>],
        recorder: Option<&mut dyn Recorder>,
        posterior: impl FnOnce(&ParticleSet, Option<f64>) -> E + Send,
    ) -> Result<E> {
        if self.particles.is_parallel() {
            // Enter the thread pool once, not at every loop over the particles.
            rayon::scope(|_| self.apply(time_s, layers, recorder, posterior))
        } else {
            self.apply(time_s, layers, recorder, posterior)
        }
    }

    fn apply<E>(
        &mut self,
        time_s: f64,
        layers: &[Layer<'_>],
        mut recorder: Option<&mut dyn Recorder>,
        posterior: impl FnOnce(&ParticleSet, Option<f64>) -> E,
    ) -> Result<E> {
        let (mut evidence, mut is_evidence) = (None, true);
        let mut posterior = Some(posterior);
        let mut estimate = None;
        for (index, layer) in layers.iter().enumerate() {
            let streams = Streams::new(self.seed, self.step, index as u64);
            self.particles.for_each_block(|b, block| layer.transition.propagate(block, &mut streams.block(b)));
            let predicted = recorder.as_ref().map(|_| self.particles.rows());
            if let Some(log_likelihood) = self.scratch.log_likelihood(&self.particles, layer) {
                let gained = self.particles.reweigh(log_likelihood).ok_or(Error::AllWeightsZero {
                    time_s,
                    layer: index,
                    particles: self.particles.len(),
                })?;
                is_evidence &= layer.blend == Blend::PRODUCT;
                is_evidence &= layer.likelihoods.iter().all(|likelihood| likelihood.has_evidence());
                *evidence.get_or_insert(0.0) += gained;
            }
            if index + 1 == layers.len() {
                estimate = posterior.take().map(|see| see(&self.particles, evidence.filter(|_| is_evidence)));
            }
            let weights = predicted.as_ref().map(|_| self.particles.weights().to_vec());
            let step = self.step;
            let ancestors = self.resample_if_due(streams, !layer.likelihoods.is_empty());
            if let (Some(recorder), Some(predicted), Some(weights)) = (recorder.as_deref_mut(), predicted, weights) {
                let ancestors = ancestors.map(<[u32]>::to_vec);
                let layer = index;
                recorder.record(LayerRecord { step, time_s, island: 0, layer, predicted, weights, ancestors });
            }
        }
        self.step += 1;
        match (estimate, posterior) {
            (Some(estimate), _) => Ok(estimate),
            (None, Some(see)) => Ok(see(&self.particles, evidence)),
            (None, None) => unreachable!("the posterior is taken only to make the estimate"),
        }
    }

    /// The ancestors, where the set was resampled.
    fn resample_if_due(&mut self, streams: Streams, weighed: bool) -> Option<&[u32]> {
        let Resampling { scheme, threshold } = self.resampling;
        let due = weighed && (threshold >= 1.0 || self.particles.ess() <= threshold * self.particles.len() as f64);
        due.then(|| self.particles.resample(scheme, streams))
    }
}

impl Scratch {
    /// Of all likelihoods of a layer, blended; `None` where it has none.
    fn log_likelihood(&mut self, particles: &ParticleSet, layer: &Layer<'_>) -> Option<&[f64]> {
        let (first, rest) = layer.likelihoods.split_first()?;
        if layer.blend != Blend::PRODUCT {
            let loss = |likelihood: &&dyn Likelihood| {
                let mut row = vec![0.0; particles.len()];
                likelihood.log_likelihood(particles, &mut row);
                for x in &mut row {
                    *x = -*x;
                }
                row
            };
            self.total.resize(particles.len(), 0.0);
            let losses: Vec<Vec<f64>> = layer.likelihoods.iter().map(loss).collect();
            layer.blend.log_weights(&losses, &mut self.total);
            return Some(&self.total);
        }
        self.total.resize(particles.len(), 0.0);
        first.log_likelihood(particles, &mut self.total);
        for likelihood in rest {
            self.one.resize(particles.len(), 0.0);
            likelihood.log_likelihood(particles, &mut self.one);
            for (sum, value) in self.total.iter_mut().zip(&self.one) {
                *sum += value;
            }
        }
        Some(&self.total)
    }
}
