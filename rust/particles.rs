//! A particle set: states and log-weights in one struct, so that they cannot fall out of step.
//!
//! Memory is laid out in blocks of [`BLOCK`] particles; inside a block the columns of the state are
//! contiguous, which is what vector instructions want, and a block is the unit of work of a thread and the
//! owner of a random stream. Sums run inside a block, then over blocks in order, so that they do not depend
//! on the number of threads.

use crate::Result;
use crate::error::{require, room};
use crate::resample::{Ancestors, Scheme};
use crate::rng::{BLOCK, Streams};
use crate::sums::dot;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

mod block;
mod exponential;
mod summary;
mod weighing;

pub use block::{Block, BlockMut};
pub use summary::{Interval, LOWER, NORMAL_UPPER, Summary, UPPER};

/// More particles than any laptop works through.
const MOST: usize = 100_000_000;

/// So many are held by whatever runs Python.
const CERTAINLY_HELD: usize = 100_000;

/// Numbers a particle takes besides its state, at the most: weights, their logarithms, ancestors, sorting.
const BESIDES: usize = 10;

/// From this many blocks on, work is shared between threads; below it the sharing costs more than it saves.
const PARALLEL_BLOCKS: usize = 32;

/// `N` weighted particles of `D` columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParticleSet {
    len: usize,
    dim: usize,
    blocks: Vec<f64>,
    /// Logarithms of the weights, less what is the same for all.
    log_weights: Vec<f64>,
    /// The logarithm of the sum that `log_weights` have.
    log_sum: f64,
    weights: Vec<f64>,
    #[serde(skip)]
    scratch: Scratch,
}

/// Memory kept from call to call; holds nothing between them.
#[derive(Debug, Clone, Default)]
struct Scratch {
    blocks: Vec<f64>,
    ancestors: Ancestors,
}

impl PartialEq for Scratch {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Weights of one block, and their logarithms.
type Weights<'a> = (&'a mut [f64], &'a mut [f64]);

impl ParticleSet {
    /// `len` particles of `dim` columns at zero, with equal weights.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when either is zero or there are more than a hundred million particles;
    /// [`crate::Error::Memory`] where the machine cannot hold them.
    pub fn new(len: usize, dim: usize) -> Result<Self> {
        require((1..=MOST).contains(&len), "particles", len as f64, "1 to 100000000")?;
        require(dim >= 1, "state columns", dim as f64, "at least 1")?;
        if len > CERTAINLY_HELD {
            room("particles", len.saturating_mul(3 * dim + BESIDES))?;
        }
        Ok(Self {
            len,
            dim,
            blocks: vec![0.0; len.div_ceil(BLOCK) * BLOCK * dim],
            log_weights: vec![0.0; len],
            log_sum: (len as f64).ln(),
            weights: vec![1.0 / len as f64; len],
            scratch: Scratch::default(),
        })
    }

    /// Particles of equal weight from rows `(N, D)`, flattened.
    ///
    /// # Errors
    /// As [`ParticleSet::new`]; [`crate::Error::Size`] where a row is not whole.
    pub fn from_rows(dim: usize, rows: &[f64]) -> Result<Self> {
        let mut set = Self::new(rows.len() / dim.max(1), dim)?;
        if !rows.len().is_multiple_of(dim) {
            return Err(crate::Error::Size { name: "row", got: rows.len() % dim, unit: "columns", expected: dim });
        }
        set.for_each_block(|b, mut block| {
            let rows = &rows[b * BLOCK * dim..];
            for d in 0..dim {
                for (value, row) in block.column_mut(d).iter_mut().zip(rows.chunks_exact(dim)) {
                    *value = row[d];
                }
            }
        });
        Ok(set)
    }

    /// How many particles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Never: a set holds at least one particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many columns the state has.
    pub fn dim(&self) -> usize {
        self.dim
    }

    /// Normalised weights, `(N,)`.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The state as rows, `(N, D)` flattened: a copy for those outside.
    pub fn rows(&self) -> Vec<f64> {
        let mut rows = vec![0.0; self.len * self.dim];
        for (block, rows) in self.blocks().zip(rows.chunks_mut(BLOCK * self.dim)) {
            for d in 0..self.dim {
                for (row, value) in rows.chunks_exact_mut(self.dim).zip(block.column(d)) {
                    row[d] = *value;
                }
            }
        }
        rows
    }

    /// The blocks, in order.
    pub fn blocks(&self) -> impl Iterator<Item = Block<'_>> {
        let len = self.len;
        self.blocks
            .chunks(self.dim * BLOCK)
            .enumerate()
            .map(move |(b, data)| Block { data, len: (len - b * BLOCK).min(BLOCK) })
    }

    /// Change every block in place; `change(b, block)` must depend on nothing but its block.
    pub fn for_each_block(&mut self, change: impl Fn(usize, BlockMut<'_>) + Sync) {
        let (len, stride) = (self.len, self.dim * BLOCK);
        let work = |(b, data): (usize, &mut [f64])| change(b, BlockMut { data, len: (len - b * BLOCK).min(BLOCK) });
        if self.is_parallel() {
            self.blocks.par_chunks_mut(stride).enumerate().for_each(work);
        } else {
            self.blocks.chunks_mut(stride).enumerate().for_each(work);
        }
    }

    /// Fill `out` (one value a particle) block by block.
    ///
    /// # Panics
    /// When `out` has another length than the set.
    pub fn map_blocks(&self, out: &mut [f64], map: impl Fn(Block<'_>, &mut [f64]) + Sync) {
        assert_eq!(out.len(), self.len, "one value a particle");
        let stride = self.dim * BLOCK;
        let work = |(data, out): (&[f64], &mut [f64])| map(Block { data, len: out.len() }, out);
        if self.is_parallel() {
            self.blocks.par_chunks(stride).zip(out.par_chunks_mut(BLOCK)).for_each(work);
        } else {
            self.blocks.chunks(stride).zip(out.chunks_mut(BLOCK)).for_each(work);
        }
    }

    /// Whether loops over this set are shared between threads.
    pub(crate) fn is_parallel(&self) -> bool {
        self.len >= PARALLEL_BLOCKS * BLOCK
    }

    /// Several sets as one, each with the weight that its number of particles has among all.
    ///
    /// # Panics
    /// When there is none, or they differ in their columns.
    pub fn together(sets: &[&Self]) -> Self {
        if let [one] = sets {
            return (*one).clone();
        }
        let (len, dim) = (sets.iter().map(|set| set.len).sum(), sets[0].dim);
        let mut all = Self::new(len, dim).expect("particles and columns");
        let mut first = 0;
        for set in sets {
            assert_eq!(set.dim, dim, "the same columns");
            let share = set.len as f64 / len as f64;
            for (b, block) in set.blocks().enumerate() {
                for i in 0..block.len() {
                    let to = first + b * BLOCK + i;
                    for d in 0..dim {
                        all.blocks[(to / BLOCK) * BLOCK * dim + d * BLOCK + to % BLOCK] = block.column(d)[i];
                    }
                    all.weights[to] = set.weights[b * BLOCK + i] * share;
                    all.log_weights[to] = all.weights[to].ln();
                }
            }
            first += set.len;
        }
        all.log_sum = 0.0;
        all
    }

    /// Another set of the same weights, whose `dim` columns are made from this one's, block by block.
    ///
    /// # Panics
    /// When `dim` is zero.
    pub fn mapped(&self, dim: usize, map: impl Fn(Block<'_>, &mut BlockMut<'_>) + Sync) -> Self {
        assert!(dim > 0, "a set has columns");
        let mut blocks = vec![0.0; self.len.div_ceil(BLOCK) * BLOCK * dim];
        let from: Vec<Block<'_>> = self.blocks().collect();
        let work = |(block, data): (&Block<'_>, &mut [f64])| map(*block, &mut BlockMut { data, len: block.len() });
        if self.is_parallel() {
            from.par_iter().zip(blocks.par_chunks_mut(dim * BLOCK)).for_each(work);
        } else {
            from.iter().zip(blocks.chunks_mut(dim * BLOCK)).for_each(work);
        }
        let (log_weights, weights) = (self.log_weights.clone(), self.weights.clone());
        Self { dim, blocks, log_weights, weights, scratch: Scratch::default(), ..*self }
    }

    /// Forget what was weighed.
    pub fn weigh_equally(&mut self) {
        self.log_weights.fill(0.0);
        self.log_sum = (self.len as f64).ln();
        self.weights.fill(1.0 / self.len as f64);
    }

    /// Effective sample size, `1 / sum(w²)`: between 1 and `N`.
    pub fn ess(&self) -> f64 {
        1.0 / dot(&self.weights, &self.weights)
    }

    /// Draw the next generation in proportion to the weights; afterwards all weigh the same.
    ///
    /// Returns the ancestors, ascending: particle `i` is a copy of particle `ancestors[i]`.
    pub fn resample(&mut self, scheme: Scheme, streams: Streams) -> &[u32] {
        let mut ancestors = std::mem::take(&mut self.scratch.ancestors);
        scheme.draw(&self.weights, self.len, &mut streams.resampling(), &mut ancestors);
        self.become_copies_of(ancestors.indices());
        self.scratch.ancestors = ancestors;
        self.scratch.ancestors.indices()
    }

    /// The next generation: copies of `ancestors`, weighing the same.
    fn become_copies_of(&mut self, ancestors: &[u32]) {
        let mut next = std::mem::take(&mut self.scratch.blocks);
        next.resize(self.blocks.len(), 0.0);
        let (stride, source) = (self.dim * BLOCK, &self.blocks);
        let (equal, is_parallel) = (1.0 / self.len as f64, self.is_parallel());
        let work = |((to, (weights, logs)), ancestors): ((&mut [f64], Weights<'_>), &[u32])| {
            weights.fill(equal);
            logs.fill(0.0);
            let mut from = [0; BLOCK];
            for (from, &ancestor) in from.iter_mut().zip(ancestors) {
                *from = ancestor as usize / BLOCK * stride + ancestor as usize % BLOCK;
            }
            for (d, column) in to.chunks_mut(BLOCK).enumerate() {
                let source = &source[d * BLOCK..];
                for (value, &from) in column.iter_mut().zip(&from[..ancestors.len()]) {
                    *value = source[from];
                }
            }
        };
        let (weights, logs) = (&mut self.weights, &mut self.log_weights);
        if is_parallel {
            let weights = weights.par_chunks_mut(BLOCK).zip(logs.par_chunks_mut(BLOCK));
            next.par_chunks_mut(stride).zip(weights).zip(ancestors.par_chunks(BLOCK)).for_each(work);
        } else {
            let weights = weights.chunks_mut(BLOCK).zip(logs.chunks_mut(BLOCK));
            next.chunks_mut(stride).zip(weights).zip(ancestors.chunks(BLOCK)).for_each(work);
        }
        self.log_sum = (self.len as f64).ln();
        self.scratch.blocks = std::mem::replace(&mut self.blocks, next);
    }

    /// Weighted mean and covariance, 95 % bands of the first `k` columns, and where these are densest.
    pub fn summary(&self, k: usize) -> Summary {
        summary::summarise(self, k)
    }

    /// Weighted mean, `(D,)`, and covariance, `(D, D)`.
    pub fn moments(&self) -> (DVector<f64>, DMatrix<f64>) {
        summary::moments(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(len: usize) -> ParticleSet {
        let mut set = ParticleSet::new(len, 2).unwrap();
        set.for_each_block(|b, mut block| {
            for i in 0..block.len() {
                block.column_mut(0)[i] = (b * BLOCK + i) as f64;
                block.column_mut(1)[i] = -((b * BLOCK + i) as f64);
            }
        });
        set
    }

    #[test]
    fn rows_are_particles() {
        let rows = ramp(300).rows();
        assert_eq!(rows.len(), 600);
        assert_eq!(&rows[2 * 299..], &[299.0, -299.0]);
    }

    #[test]
    fn resampling_moves_states_and_weights_together() {
        let mut set = ramp(700);
        let mut likelihood = vec![f64::NEG_INFINITY; 700];
        likelihood[5] = 0.0;
        likelihood[600] = 3f64.ln();
        set.reweigh(&likelihood).unwrap();
        let ancestors = set.resample(Scheme::Systematic, Streams::new(1, 2, 3)).to_vec();
        let rows = set.rows();
        for (i, a) in ancestors.iter().enumerate() {
            assert_eq!(rows[2 * i], f64::from(*a));
        }
        assert_eq!(ancestors.iter().filter(|a| **a == 5).count(), 175);
        assert!(set.weights().iter().all(|w| *w == 1.0 / 700.0));
    }

    #[test]
    fn together_they_weigh_as_many_as_they_are() {
        let (mut a, mut b) = (ramp(300), ramp(100));
        a.reweigh(&(0..300).map(|i| f64::from(i % 7)).collect::<Vec<_>>()).unwrap();
        b.reweigh(&(0..100).map(|i| f64::from(i % 5)).collect::<Vec<_>>()).unwrap();
        let all = ParticleSet::together(&[&a, &b]);
        assert_eq!(all.rows(), [a.rows(), b.rows()].concat());
        assert!((all.weights().iter().sum::<f64>() - 1.0).abs() < 1e-14);
        let mean = |set: &ParticleSet| set.moments().0[0];
        assert!((mean(&all) - 0.75 * mean(&a) - 0.25 * mean(&b)).abs() < 1e-12);
        let mut again = all.clone();
        let evidence = again.reweigh(&[2f64.ln(); 400]).unwrap();
        assert!((evidence - 2f64.ln()).abs() < 1e-12);
        assert_eq!(ParticleSet::together(&[&a]), a);
    }
}
