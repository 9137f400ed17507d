//! The colour patch as a measurement: eqs (7), (9), (11).
//!
//! The patch sits at `wrist + R_world_sensor * offset`. With an outlier share the density is a mixture with a
//! uniform over the image, so that a sighting of something else moves nothing far.

use super::Cue;
use crate::Result;
use crate::arm::posed::{Posed, Sighting};
use crate::arm::state::{Layout, Noise, POSITION};
use crate::filter::{Likelihood, Linear};
use crate::particles::{Block, ParticleSet};
use crate::rng::BLOCK;
use nalgebra::{DMatrix, DVector, Matrix3};
use std::f64::consts::TAU;

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
        match self.layout.patch_offset {
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

/// The patch's pixel in one camera, linear about a state.
impl Cue for Sighting<'_> {
    fn linearise(&self, posed: &Posed<'_>, state: &DVector<f64>, _: Option<&DMatrix<f64>>) -> Result<Option<Linear>> {
        let mut offset = self.view.patch_offset;
        if let Some(column) = posed.layout.patch_offset {
            offset += state.fixed_rows::<3>(column);
        }
        let (glued, by_tilt) = posed.turned(state, posed.world_sensor * offset);
        let (wrist, by_state) = posed.wrist(state);
        let (pixel, by_patch, mut slope) = posed.pixel(self, state, wrist + glued, &by_state)?;
        if let Some((column, by_tilt)) = by_tilt {
            slope.fixed_view_mut::<2, 3>(0, column).copy_from(&(by_patch * by_tilt));
        }
        if let Some(column) = posed.layout.patch_offset {
            slope.fixed_view_mut::<2, 3>(0, column).copy_from(&(by_patch * posed.turn(state) * posed.world_sensor));
        }
        let residual = DVector::from_column_slice((self.pixel - pixel).as_slice());
        let noise = DMatrix::from_diagonal_element(2, 2, posed.noise.pixel_sd * posed.noise.pixel_sd);
        Ok(Some((residual, slope, noise)))
    }
}
