//! What weighs particles of the body: the edge cue and the distance cue, and what a body can do at all.
//!
//! [`Rescaled`] is the paper: distances stretched over [0, 1] within the set, `A^-d`, a weighted product. An empty image then
//! weighs as sharply as a perfect one, so that its spread says little. [`FixedScale`] keeps the scale of each cue.

use super::edges::{EdgeImage, rectangle};
use super::figure::{Figure, Group};
use super::region::{Region, RegionLook, loss};
use super::skin::Blobs;
use crate::filter::Likelihood;
use crate::particles::ParticleSet;
use crate::projection::{Projection, Seen};
use rayon::prelude::*;

/// Particles that are looked at together.
const CHUNK: usize = 32;

/// From this many particles on, chunks are shared between threads.
const PARALLEL: usize = 128;

/// How far beyond a limit a joint may be, rad.
const LIMIT_SD: f64 = 0.1;

/// How deep a hand may be in the torso, m; and how much of the torso's half-width is surely torso.
const PENETRATION_SD: f64 = 0.02;
const TORSO_DEPTH: f64 = 0.6;

/// All that a frame shows, and the figure that it may show.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The figure.
    pub figure: &'a Figure,
    /// The camera.
    pub projection: &'a Projection,
    /// Detected edges.
    pub edges: &'a EdgeImage,
    /// Blobs by wearer.
    pub blobs: Blobs,
    /// Skin and foreground as regions, where they are given.
    pub regions: (Option<&'a Region>, Option<&'a Region>),
}

/// How badly a particle explains a scene.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Distances {
    /// Eq. (4): sum over the parts of the share of missed pixels.
    pub edge: f64,
    /// Sum over the blobs of the distance, px.
    pub blob: f64,
    /// Half the sum of squares of distances in standard deviations, each at most half of `reach²`.
    pub blob_loss: f64,
    /// What regions are lost by ([`super::region::loss`]).
    pub region_loss: f64,
    /// The same of what a body cannot do: limits and penetration.
    pub body_loss: f64,
}

/// What is looked at, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Groups whose parts and blobs count.
    pub groups: Vec<Group>,
    /// Standard deviation of a blob's centre, m.
    pub blob_sd_m: f64,
    /// Beyond this many standard deviations a blob says nothing more: it may be something else.
    pub blob_reach: f64,
    /// How much regions count, where they do.
    pub regions: Option<RegionLook>,
    /// Whether limits of joints count.
    pub limits: bool,
    /// Whether hands in the torso count.
    pub penetration: bool,
}

impl Scene<'_> {
    /// Of every particle, `(N,)`.
    pub fn distances(&self, particles: &ParticleSet, look: &Look) -> Vec<Distances> {
        let mut out = vec![Distances::default(); particles.len()];
        let blocks: Vec<_> = particles.blocks().collect();
        let work = |(chunk, out): (usize, &mut [Distances])| {
            let first = chunk * CHUNK;
            let block = blocks[first / crate::rng::BLOCK];
            let within = first % crate::rng::BLOCK;
            let mut points = vec![0.0; self.figure.model.len() * 3 * out.len()];
            self.figure.model.points(block, within, out.len(), &mut points);
            let mut seen = vec![Seen { u: 0.0, v: 0.0, px_per_m: 0.0 }; self.figure.model.len()];
            let count = out.len();
            for (i, distances) in out.iter_mut().enumerate() {
                let at = |p: usize| [0, 1, 2].map(|d| points[(3 * p + d) * count + i]);
                for (p, seen) in seen.iter_mut().enumerate() {
                    *seen = self.projection.see(at(p));
                }
                *distances = self.outline_and_blobs(&seen, look);
                if let Some(regions) = &look.regions {
                    distances.region_loss = loss(self.figure, &seen, &look.groups, self.regions, regions);
                }
                if look.limits {
                    for (d, [low, high]) in self.figure.limits.iter().enumerate() {
                        let value = block.column(d)[within + i];
                        let beyond = ((low - value).max(value - high)).max(0.0) / LIMIT_SD;
                        distances.body_loss += 0.5 * beyond * beyond;
                    }
                }
                if look.penetration {
                    distances.body_loss += self.penetration(at);
                }
            }
        };
        if particles.len() >= PARALLEL {
            out.par_chunks_mut(CHUNK).enumerate().for_each(work);
        } else {
            out.chunks_mut(CHUNK).enumerate().for_each(work);
        }
        out
    }

    fn outline_and_blobs(&self, seen: &[Seen], look: &Look) -> Distances {
        let mut distances = Distances::default();
        for limb in self.figure.limbs.iter().filter(|limb| look.groups.contains(&limb.group)) {
            distances.edge += self.edges.missed(&rectangle(seen[limb.start], seen[limb.end], limb.half_width_m));
        }
        for group in &look.groups {
            let Some([u, v]) = self.blobs[group.wearer()] else { continue };
            let [a, b] = [0, 1].map(|end| seen[super::figure::KEY_JOINTS.len() + 2 * group.wearer() + end]);
            let (du, dv) = (0.5 * (a.u + b.u) - u, 0.5 * (a.v + b.v) - v);
            let distance = (du * du + dv * dv).sqrt();
            // A point behind the camera is as far off as any.
            let distance = if distance.is_finite() { distance } else { 1e4 };
            let in_sd = (distance / (look.blob_sd_m * a.px_per_m)).min(look.blob_reach);
            distances.blob += distance;
            distances.blob_loss += 0.5 * in_sd * in_sd;
        }
        distances
    }

    /// Elbows, wrists and hands inside the torso's core (paper IV-C1: "limb penetration").
    fn penetration(&self, at: impl Fn(usize) -> [f64; 3]) -> f64 {
        let Some(torso) = self.figure.limbs.iter().find(|limb| limb.group == Group::Torso) else { return 0.0 };
        let (a, b) = (at(torso.start), at(torso.end));
        let axis = [0, 1, 2].map(|d| b[d] - a[d]);
        let length2 = axis.iter().map(|x| x * x).sum::<f64>().max(1e-12);
        let radius = TORSO_DEPTH * torso.half_width_m[0].min(torso.half_width_m[1]);
        let mut loss = 0.0;
        for p in [4, 5, 6, 7, 10, 12] {
            let q = at(p);
            let along = ((0..3).map(|d| (q[d] - a[d]) * axis[d]).sum::<f64>() / length2).clamp(0.0, 1.0);
            let apart = (0..3).map(|d| (q[d] - a[d] - along * axis[d]).powi(2)).sum::<f64>().sqrt();
            let deep = ((radius - apart) / PENETRATION_SD).max(0.0);
            loss += 0.5 * deep * deep;
        }
        loss
    }
}

/// The paper's weights (IV-C2).
#[derive(Debug, Clone)]
pub struct Rescaled<'a> {
    /// What is seen.
    pub scene: Scene<'a>,
    /// What is looked at.
    pub look: Look,
    /// `A`: how much more a particle at distance 0 weighs than one at 1.
    pub base: f64,
    /// Weight of the edge cue, 0 to 2; the distance cue has the rest.
    pub alpha: f64,
    /// How far alpha is moved towards what each cue tells apart in this frame, 0 (the paper) to 1.
    pub adapt: f64,
}

/// Linearly to [0, 1] over the set; zero where all are equal.
fn rescaled(distances: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let low = distances.clone().fold(f64::INFINITY, f64::min);
    let span = distances.clone().fold(f64::NEG_INFINITY, f64::max) - low;
    distances.map(|d| if span > 0.0 { (d - low) / span } else { 0.0 }).collect()
}

impl Rescaled<'_> {
    /// How much a cue tells particles apart: one less its effective share of the set.
    fn discrimination(&self, distances: &[f64]) -> f64 {
        let weights: Vec<f64> = distances.iter().map(|d| (-self.base.ln() * d).exp()).collect();
        let (sum, squares) = weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        1.0 - sum * sum / (squares * weights.len() as f64)
    }

    /// The weight of the edge cue in this frame.
    fn weight(&self, edge: &[f64], blob: &[f64]) -> f64 {
        if self.adapt == 0.0 {
            return self.alpha;
        }
        let (e, b) = (self.discrimination(edge), self.discrimination(blob));
        let told = if e + b > 0.0 { 2.0 * e / (e + b) } else { self.alpha };
        self.alpha + self.adapt * (told - self.alpha)
    }
}

impl Likelihood for Rescaled<'_> {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        let distances = self.scene.distances(particles, &self.look);
        let edge = rescaled(distances.iter().map(|d| d.edge));
        let blob = rescaled(distances.iter().map(|d| d.blob));
        let (alpha, sharpness) = (self.weight(&edge, &blob), self.base.ln());
        for (i, out) in out.iter_mut().enumerate() {
            *out = -sharpness * (alpha * edge[i] + (2.0 - alpha) * blob[i]) - distances[i].body_loss;
        }
    }

    fn has_evidence(&self) -> bool {
        false
    }
}

/// Cues on their own scale.
#[derive(Debug, Clone)]
pub struct FixedScale<'a> {
    /// What is seen.
    pub scene: Scene<'a>,
    /// What is looked at.
    pub look: Look,
    /// Log-likelihood lost by a part whose outline misses every edge.
    pub edge_loss: f64,
    /// Share of the whole sharpness: below 1 in the flat layers of annealing.
    pub sharpness: f64,
    /// Whether the layer weighs by the likelihood itself, once.
    pub is_evidence: bool,
}

impl Likelihood for FixedScale<'_> {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        for (out, d) in out.iter_mut().zip(self.scene.distances(particles, &self.look)) {
            *out = -self.sharpness * (self.edge_loss * d.edge + d.blob_loss + d.region_loss) - d.body_loss;
        }
    }

    fn has_evidence(&self) -> bool {
        self.is_evidence
    }
}
