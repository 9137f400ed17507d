//! A particle set: states and log-weights in one struct, so that they cannot fall out of step.
//!
//! Memory is laid out in blocks of [`BLOCK`] particles; inside a block the columns of the state are
//! contiguous, which is what vector instructions want, and a block is the unit of work of a thread and the
//! owner of a random stream. Sums run inside a block, then over blocks in order, so that they do not depend
//! on the number of threads.

use crate::resample::Scheme;
use crate::rng::{BLOCK, Streams};
use crate::{Result, error::require};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

mod summary;

pub use summary::{Interval, LOWER, UPPER};

/// From this many blocks on, work is shared between threads; below it the sharing costs more than it saves.
const PARALLEL_BLOCKS: usize = 16;

/// `N` weighted particles of `D` columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParticleSet {
    len: usize,
    dim: usize,
    blocks: Vec<f64>,
    log_weights: Vec<f64>,
    weights: Vec<f64>,
    #[serde(skip)]
    scratch: Scratch,
}

/// Memory kept from call to call; holds nothing between them.
#[derive(Debug, Clone, Default)]
struct Scratch {
    blocks: Vec<f64>,
    ancestors: Vec<u32>,
}

impl PartialEq for Scratch {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The particles of one block, read.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    data: &'a [f64],
    len: usize,
}

impl<'a> Block<'a> {
    /// How many particles.
    pub fn len(self) -> usize {
        self.len
    }

    /// Never: a block holds at least one particle.
    pub fn is_empty(self) -> bool {
        self.len == 0
    }

    /// Column `d` of the state, one value a particle.
    pub fn column(self, d: usize) -> &'a [f64] {
        &self.data[d * BLOCK..d * BLOCK + self.len]
    }

    /// Columns `d..d + K`.
    pub fn columns<const K: usize>(self, d: usize) -> [&'a [f64]; K] {
        std::array::from_fn(|k| self.column(d + k))
    }
}

/// The particles of one block, changed in place.
#[derive(Debug)]
pub struct BlockMut<'a> {
    data: &'a mut [f64],
    len: usize,
}

impl BlockMut<'_> {
    /// The same block, for a callee that takes it by value.
    pub fn reborrow(&mut self) -> BlockMut<'_> {
        BlockMut { data: self.data, len: self.len }
    }

    /// How many particles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Never: a block holds at least one particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Column `d` of the state.
    pub fn column_mut(&mut self, d: usize) -> &mut [f64] {
        &mut self.data[d * BLOCK..d * BLOCK + self.len]
    }

    /// The `K` columns named, in that order.
    ///
    /// # Panics
    /// When two are the same or one is not there.
    pub fn columns_mut<const K: usize>(&mut self, columns: [usize; K]) -> [&mut [f64]; K] {
        let len = self.len;
        let ranges = columns.map(|d| d * BLOCK..d * BLOCK + len);
        self.data.get_disjoint_mut(ranges).expect("columns differ and lie inside the block")
    }
}

impl ParticleSet {
    /// `len` particles of `dim` columns at zero, with equal weights.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when either is zero or there are more than `u32::MAX` particles.
    pub fn new(len: usize, dim: usize) -> Result<Self> {
        require(len >= 1 && u32::try_from(len).is_ok(), "particles", len as f64, "1 to 4294967295")?;
        require(dim >= 1, "state columns", dim as f64, "at least 1")?;
        let mut set = Self {
            len,
            dim,
            blocks: vec![0.0; len.div_ceil(BLOCK) * BLOCK * dim],
            log_weights: vec![0.0; len],
            weights: vec![0.0; len],
            scratch: Scratch::default(),
        };
        set.equal_weights();
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
        let mut rows = Vec::with_capacity(self.len * self.dim);
        for block in self.blocks() {
            for i in 0..block.len() {
                rows.extend((0..self.dim).map(|d| block.column(d)[i]));
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

    fn is_parallel(&self) -> bool {
        self.len >= PARALLEL_BLOCKS * BLOCK
    }

    fn equal_weights(&mut self) {
        self.log_weights.fill(-(self.len as f64).ln());
        self.weights.fill(1.0 / self.len as f64);
    }

    /// Multiply the weights by likelihoods given as logarithms, and normalise.
    ///
    /// Returns the log of the weighted mean likelihood (the evidence of this observation), or `None`, with
    /// the weights unchanged, when every weight would be zero or one is not a number.
    ///
    /// # Panics
    /// When `log_likelihood` has another length than the set.
    pub fn reweigh(&mut self, log_likelihood: &[f64]) -> Option<f64> {
        assert_eq!(log_likelihood.len(), self.len, "one value a particle");
        let largest = self.log_weights.iter().zip(log_likelihood).map(|(w, l)| w + l).fold(f64::NEG_INFINITY, f64::max);
        if !largest.is_finite() || log_likelihood.iter().any(|l| l.is_nan()) {
            return None;
        }
        for (w, l) in self.log_weights.iter_mut().zip(log_likelihood) {
            *w += l;
        }
        let work = |(weights, logs): (&mut [f64], &[f64])| {
            for (w, l) in weights.iter_mut().zip(logs) {
                *w = (l - largest).exp();
            }
            weights.iter().sum::<f64>()
        };
        let sum: f64 = if self.is_parallel() {
            let sums: Vec<f64> =
                self.weights.par_chunks_mut(BLOCK).zip(self.log_weights.par_chunks(BLOCK)).map(work).collect();
            sums.iter().sum()
        } else {
            self.weights.chunks_mut(BLOCK).zip(self.log_weights.chunks(BLOCK)).map(work).sum()
        };
        let (scale, evidence) = (1.0 / sum, largest + sum.ln());
        self.weights.iter_mut().for_each(|w| *w *= scale);
        self.log_weights.iter_mut().for_each(|w| *w -= evidence);
        Some(evidence)
    }

    /// Effective sample size, `1 / sum(w²)`: between 1 and `N`.
    pub fn ess(&self) -> f64 {
        1.0 / self.weights.chunks(BLOCK).map(|w| w.iter().map(|x| x * x).sum::<f64>()).sum::<f64>()
    }

    /// Draw the next generation in proportion to the weights; afterwards all weigh the same.
    ///
    /// Returns the ancestors, ascending: particle `i` is a copy of particle `ancestors[i]`.
    pub fn resample(&mut self, scheme: Scheme, streams: Streams) -> &[u32] {
        let mut ancestors = std::mem::take(&mut self.scratch.ancestors);
        scheme.draw(&self.weights, self.len, &mut streams.resampling(), &mut ancestors);
        self.copy_from(&ancestors);
        self.equal_weights();
        self.scratch.ancestors = ancestors;
        &self.scratch.ancestors
    }

    fn copy_from(&mut self, ancestors: &[u32]) {
        let mut next = std::mem::take(&mut self.scratch.blocks);
        next.resize(self.blocks.len(), 0.0);
        let (stride, source) = (self.dim * BLOCK, &self.blocks);
        let work = |(to, ancestors): (&mut [f64], &[u32])| {
            for (d, column) in to.chunks_mut(BLOCK).enumerate() {
                for (value, &ancestor) in column.iter_mut().zip(ancestors) {
                    let (block, lane) = (ancestor as usize / BLOCK, ancestor as usize % BLOCK);
                    *value = source[block * stride + d * BLOCK + lane];
                }
            }
        };
        if self.is_parallel() {
            next.par_chunks_mut(stride).zip(ancestors.par_chunks(BLOCK)).for_each(work);
        } else {
            next.chunks_mut(stride).zip(ancestors.chunks(BLOCK)).for_each(work);
        }
        self.scratch.blocks = std::mem::replace(&mut self.blocks, next);
    }

    /// Weighted mean, `(D,)`, and covariance, `(D, D)`.
    pub fn moments(&self) -> (DVector<f64>, DMatrix<f64>) {
        summary::moments(self)
    }

    /// Weighted 2.5 % and 97.5 % quantiles of one column: the particles at which the cumulative weight,
    /// in order of value, first reaches [`LOWER`] and [`UPPER`].
    pub fn interval(&self, column: usize) -> Interval {
        summary::interval(self, column)
    }

    /// Where the first `K` columns are densest, found along the direction in which they spread most.
    pub fn mode<const K: usize>(&self) -> nalgebra::SVector<f64, K> {
        summary::mode(self)
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
    fn evidence_is_the_weighted_mean_likelihood() {
        let mut set = ramp(4);
        let evidence = set.reweigh(&[1f64.ln(), 2f64.ln(), 3f64.ln(), 6f64.ln()]).unwrap();
        assert!((evidence - 3f64.ln()).abs() < 1e-14);
        assert!((set.ess() - 144.0 / 50.0).abs() < 1e-12);
        // Very small likelihoods do not underflow.
        let evidence = set.reweigh(&[-5000.0; 4]).unwrap();
        assert!((evidence + 5000.0).abs() < 1e-9);
    }

    #[test]
    fn no_weight_left_is_said_and_changes_nothing() {
        let mut set = ramp(3);
        let before = set.clone();
        assert_eq!(set.reweigh(&[f64::NEG_INFINITY; 3]), None);
        assert_eq!(set.reweigh(&[0.0, f64::NAN, 0.0]), None);
        assert_eq!(set, before);
    }
}
