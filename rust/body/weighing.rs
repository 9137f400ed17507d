//! How particles of the body are weighed: posed once a layer, a chunk at a time, for all its cues ([`super::cues`]), each of which
//! says what every particle loses by it; then blended ([`Blend`]).

use super::figure::Figure;
use super::sloped::{Rows, Sloped};
use crate::filter::{Blend, Likelihood};
use crate::particles::{Block, ParticleSet};
use crate::projection::{Projected, Projection};
use rayon::prelude::*;

/// Particles that are posed together.
const CHUNK: usize = 32;

/// From this many particles on, chunks are shared between threads.
const PARALLEL: usize = 128;

/// How badly posed particles explain one observation, or what a body can do.
///
/// A cue that is smooth can be linearised besides, for filters over Gaussians.
pub trait Cue: Sync {
    /// Write what every particle loses, `(count,)`: a negative log-likelihood, or a distance that a blend rescales.
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]);

    /// What it measures of one state: as many rows as it has to say, none of a cue that is not smooth.
    fn linearise(&self, _at: &Sloped<'_>, _rows: &mut Rows) {}

    /// How many of the figure's points it reads, counted from the first.
    fn reads(&self, figure: &Figure) -> usize {
        figure.drawn
    }
}

/// Some particles, posed and seen: what every cue of a layer reads.
pub struct Posed<'a> {
    /// What is posed.
    pub figure: &'a Figure,
    /// How many particles.
    pub count: usize,
    points: &'a [f64],
    seen: &'a [Projected],
    block: Block<'a>,
    first: usize,
}

impl Posed<'_> {
    /// Where a point of the figure is for a particle: world, m.
    #[inline]
    pub fn at(&self, particle: usize, point: usize) -> [f64; 3] {
        [0, 1, 2].map(|d| self.points[(3 * point + d) * self.count + particle])
    }

    /// Where the camera sees the figure's points for a particle, `(P,)`.
    #[inline]
    pub fn seen(&self, particle: usize) -> &[Projected] {
        let points = self.seen.len() / self.count;
        &self.seen[particle * points..(particle + 1) * points]
    }

    /// A column of the state, `(count,)`.
    #[inline]
    pub fn column(&self, d: usize) -> &[f64] {
        &self.block.column(d)[self.first..self.first + self.count]
    }
}

/// The likelihood of a layer: some cues, blended.
pub struct Weighing<'a> {
    /// What is posed.
    pub figure: &'a Figure,
    /// The camera.
    pub projection: &'a Projection,
    /// What is seen.
    pub cues: Vec<Box<dyn Cue + 'a>>,
    /// What a body can do at all: never rescaled or flattened.
    pub bounds: Vec<Box<dyn Cue + 'a>>,
    /// How they are blended.
    pub blend: Blend,
}

impl Weighing<'_> {
    /// What every particle loses by each of the cues, and after them by the bounds: `(K, N)`.
    pub fn losses(&self, particles: &ParticleSet) -> Vec<Vec<f64>> {
        let cues: Vec<&dyn Cue> = self.cues.iter().chain(&self.bounds).map(AsRef::as_ref).collect();
        let points = cues.iter().map(|cue| cue.reads(self.figure)).max().unwrap_or(0);
        let blocks: Vec<_> = particles.blocks().collect();
        let mut rows = vec![0.0; particles.len() * cues.len()];
        let work = |(chunk, out): (usize, &mut [f64])| {
            let count = out.len() / cues.len();
            let first = chunk * CHUNK;
            let (block, first) = (blocks[first / crate::rng::BLOCK], first % crate::rng::BLOCK);
            let mut places = vec![0.0; points * 3 * count];
            self.figure.model.points(block, first, count, &mut places);
            let see = |k: usize| {
                let (particle, point) = (k / points, k % points);
                self.projection.see([0, 1, 2].map(|d| places[(3 * point + d) * count + particle]))
            };
            let seen: Vec<Projected> = (0..count * points).map(see).collect();
            let posed = Posed { figure: self.figure, count, points: &places, seen: &seen, block, first };
            for (cue, out) in cues.iter().zip(out.chunks_mut(count)) {
                cue.score(&posed, out);
            }
        };
        if cues.is_empty() {
            return Vec::new();
        }
        if particles.len() >= PARALLEL {
            rows.par_chunks_mut(CHUNK * cues.len()).enumerate().for_each(work);
        } else {
            rows.chunks_mut(CHUNK * cues.len()).enumerate().for_each(work);
        }
        let of_cue = |k: usize| {
            let chunks = rows.chunks(CHUNK * cues.len());
            let its = |chunk: &[f64]| chunk.chunks(chunk.len() / cues.len()).nth(k).unwrap_or(&[]).to_vec();
            chunks.flat_map(its).collect()
        };
        (0..cues.len()).map(of_cue).collect()
    }
}

impl Likelihood for Weighing<'_> {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        let losses = self.losses(particles);
        let (cues, bounds) = losses.split_at(self.cues.len());
        self.blend.log_weights(cues, out);
        for (i, out) in out.iter_mut().enumerate() {
            *out -= bounds.iter().map(|loss| loss[i]).sum::<f64>();
        }
    }

    /// Losses are not normalised: an image without an edge or a blob would seem better explained than a perfect one.
    fn has_evidence(&self) -> bool {
        false
    }
}
