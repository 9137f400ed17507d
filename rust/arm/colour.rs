//! The colour patch as a measurement: eqs (7), (9), (11).
//!
//! The patch sits at `wrist + R_world_sensor * offset`. With an outlier share the density is a mixture with a
//! uniform over the image, so that a sighting of something else moves nothing far.

use super::state::{Layout, Noise, POSITION, View};
use crate::filter::{Likelihood, Linear};
use crate::particles::{Block, ParticleSet};
use crate::rng::BLOCK;
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, Matrix3, Vector2};
use std::f64::consts::TAU;

/// One patch centre in one camera.
#[derive(Debug, Clone, Copy)]
pub struct Sighting<'a> {
    /// Where it was seen from.
    pub view: &'a View,
    /// Which of the cameras that is.
    pub camera: usize,
    /// Patch centre, px.
    pub pixel: Vector2<f64>,
}

/// All sightings of one frame, weighed together.
#[derive(Debug, Clone)]
pub struct Colour<'a> {
    sightings: Vec<Sighting<'a>>,
    world_sensor: Matrix3<f64>,
    layout: Layout,
    pixel_sd: f64,
    outlier_fraction: f64,
}

impl<'a> Colour<'a> {
    /// Of `sightings`, the sensor being oriented as `world_sensor` says.
    pub fn new(sightings: Vec<Sighting<'a>>, world_sensor: Matrix3<f64>, layout: Layout, noise: &Noise) -> Self {
        Self { sightings, world_sensor, layout, pixel_sd: noise.pixel_sd, outlier_fraction: noise.outlier_fraction }
    }

    /// Add `ln p(z | patch)` of one sighting to `out`.
    fn add_sighting(&self, sighting: &Sighting<'_>, block: Block<'_>, out: &mut [f64]) {
        let mut buffer = [0.0; BLOCK];
        let distance2 = &mut buffer[..out.len()];
        let camera = &sighting.view.camera;
        let glued = self.world_sensor * sighting.view.patch_offset;
        let wrist = block.columns::<3>(POSITION);
        match self.layout.offset {
            None => camera.squared_distances(wrist, glued, sighting.pixel, distance2),
            Some(column) => {
                let [x, y, z] = &self.patches(wrist, block.columns::<3>(column));
                camera.squared_distances([x, y, z], glued, sighting.pixel, distance2);
            }
        }
        let variance = self.pixel_sd * self.pixel_sd;
        let (peak, scale) = (-(TAU * variance).ln(), -0.5 / variance);
        if self.outlier_fraction > 0.0 {
            let k = camera.matrix();
            // The image is taken to be twice its principal point in width and height.
            let outlier = self.outlier_fraction / (4.0 * k[(0, 2)] * k[(1, 2)]).abs().max(1.0);
            let inlier = (1.0 - self.outlier_fraction).ln() + peak;
            for (o, d2) in out.iter_mut().zip(distance2) {
                let density = if d2.is_nan() { 0.0 } else { (inlier + scale * *d2).exp() };
                *o += (density + outlier).ln();
            }
        } else {
            for (o, d2) in out.iter_mut().zip(distance2) {
                *o += if d2.is_nan() { f64::NEG_INFINITY } else { peak + scale * *d2 };
            }
        }
    }

    /// Columns of `wrist + R_world_sensor * offset`, both particle by particle.
    fn patches(&self, wrist: [&[f64]; 3], offset: [&[f64]; 3]) -> [[f64; BLOCK]; 3] {
        let (r, [x, y, z]) = (&self.world_sensor, offset);
        let mut patch = [[0.0; BLOCK]; 3];
        for d in 0..3 {
            for i in 0..wrist[d].len() {
                patch[d][i] = wrist[d][i] + r[(d, 0)] * x[i] + r[(d, 1)] * y[i] + r[(d, 2)] * z[i];
            }
        }
        patch
    }

    /// Residual `(2M,)`, slope `(2M, D)` and noise variance of the sightings about one state, for a linear
    /// filter; `None` without sightings.
    ///
    /// # Errors
    /// [`Error::RanAway`], at the time given, where the state puts a patch that was seen behind its camera.
    pub fn linearise(&self, time_s: f64, state: &DVector<f64>) -> Result<Option<Linear>> {
        let mut rows: Vec<(f64, DVector<f64>)> = Vec::new();
        for sighting in &self.sightings {
            let mut offset = sighting.view.patch_offset;
            if let Some(column) = self.layout.offset {
                offset += state.fixed_rows::<3>(column);
            }
            let patch = state.fixed_rows::<3>(POSITION) + self.world_sensor * offset;
            let seen = sighting.view.camera.project_with_jacobian(patch);
            let (pixel, by_patch) = seen.ok_or(Error::RanAway { time_s })?;
            let by_offset = by_patch * self.world_sensor;
            for r in 0..2 {
                let mut slope = DVector::zeros(state.len());
                for d in 0..3 {
                    slope[POSITION + d] = by_patch[(r, d)];
                    if let Some(column) = self.layout.offset {
                        slope[column + d] = by_offset[(r, d)];
                    }
                }
                rows.push((sighting.pixel[r] - pixel[r], slope));
            }
        }
        if rows.is_empty() {
            return Ok(None);
        }
        let residual = DVector::from_iterator(rows.len(), rows.iter().map(|r| r.0));
        let jacobian = DMatrix::from_fn(rows.len(), state.len(), |r, c| rows[r].1[c]);
        let noise = DMatrix::from_diagonal_element(rows.len(), rows.len(), self.pixel_sd * self.pixel_sd);
        Ok(Some((residual, jacobian, noise)))
    }
}

impl Likelihood for Colour<'_> {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        particles.map_blocks(out, |block, out| {
            out.fill(0.0);
            for sighting in &self.sightings {
                self.add_sighting(sighting, block, out);
            }
        });
    }
}
/// Where each camera saw the patch, of those that did.
pub(super) fn sightings<'a>(views: &'a [View], pixels: &[Option<Vector2<f64>>]) -> Vec<Sighting<'a>> {
    let each = views.iter().zip(pixels).enumerate();
    each.filter_map(|(camera, (view, pixel))| Some(Sighting { view, camera, pixel: (*pixel)? })).collect()
}
