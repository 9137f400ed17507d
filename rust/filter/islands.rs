//! Islands: shares of the particles that are filtered on their own.
//!
//! A state with two branches, such as an arm that points at the camera, has two depths. Resampling lets one of them die out
//! by chance, and the cloud that is left is surer than it should be. Islands are independent filters of equal say (unlike
//! those of Vergé et al., Statistics and Computing 25, 2015, which are weighed against each other): where they disagree, the
//! state is not known, and the spread of all of them together says so.

use super::{History, LayeredFilter, Recorder, Resampling};
use crate::particles::ParticleSet;
use crate::rng::branch;
use crate::{Result, error::require};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Filters side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Islands(Vec<LayeredFilter>);

impl Islands {
    /// `len` particles at `start` `(D,)` on `count` islands, which have as many each, or one more.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for no island, or more than particles.
    pub fn new(start: &[f64], len: usize, count: usize, resampling: Resampling, seed: u64) -> Result<Self> {
        require((1..=len.max(1)).contains(&count), "islands", count as f64, "1 to the number of particles")?;
        let island = |k: usize| {
            let mut particles = ParticleSet::new(len / count + usize::from(k < len % count), start.len())?;
            particles.for_each_block(|_, mut block| {
                for (d, value) in start.iter().enumerate() {
                    block.column_mut(d).fill(*value);
                }
            });
            Ok(LayeredFilter::new(particles, resampling, branch(seed, k as u64)))
        };
        (0..count).map(island).collect::<Result<_>>().map(Self)
    }

    /// The particles as they stand, of all islands.
    pub fn particles(&self) -> ParticleSet {
        ParticleSet::together(&self.0.iter().map(LayeredFilter::particles).collect::<Vec<_>>())
    }

    /// `work` on every island, each with its own `guide`: side by side, or one after the other before a recorder.
    ///
    /// # Errors
    /// The first island's, for any number of threads.
    pub fn each<G: Send, E: Send>(
        &mut self,
        guides: &mut [G],
        recorder: Option<&mut dyn Recorder>,
        work: impl Fn(&mut LayeredFilter, &mut G, Option<&mut dyn Recorder>) -> Result<E> + Sync,
    ) -> Result<Vec<E>> {
        if let Some(recorder) = recorder {
            let mut found = Vec::new();
            for (island, (filter, guide)) in self.0.iter_mut().zip(guides).enumerate() {
                let mut history = History::default();
                found.push(work(filter, guide, Some(&mut history))?);
                for record in history.layers {
                    recorder.record(super::LayerRecord { island, ..record });
                }
            }
            return Ok(found);
        }
        if let ([filter], [guide]) = (self.0.as_mut_slice(), &mut *guides) {
            return Ok(vec![work(filter, guide, None)?]);
        }
        let each: Vec<Result<E>> =
            self.0.par_iter_mut().zip(guides).map(|(filter, guide)| work(filter, guide, None)).collect();
        each.into_iter().collect()
    }
}
