//! The colour patch as a measurement: eqs (7), (9), (11).
//!
//! The patch sits at `wrist + R_world_sensor * offset`. With an outlier share the density is a mixture with a
//! uniform over the image, so that a sighting of something else moves nothing far.

use super::state::{Layout, Noise, POSITION, View};
use crate::filter::Likelihood;
use crate::particles::{Block, ParticleSet};
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};
use std::f64::consts::TAU;

/// One patch centre in one camera.
#[derive(Debug, Clone, Copy)]
pub struct Sighting<'a> {
    /// Where it was seen from.
    pub view: &'a View,
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

    /// `ln p(z | patch)` of one sighting as a function of the squared pixel distance.
    fn log_density(&self, sighting: &Sighting<'_>) -> impl Fn(Option<f64>) -> f64 + use<> {
        let variance = self.pixel_sd * self.pixel_sd;
        let (peak, scale) = (-(TAU * variance).ln(), -0.5 / variance);
        let k = sighting.view.camera.matrix();
        // The image is taken to be twice its principal point in width and height.
        let area = (4.0 * k[(0, 2)] * k[(1, 2)]).abs().max(1.0);
        let (outlier, inlier) = (self.outlier_fraction / area, (1.0 - self.outlier_fraction).ln());
        move |distance2| match distance2 {
            None if outlier > 0.0 => outlier.ln(),
            None => f64::NEG_INFINITY,
            Some(d2) if outlier > 0.0 => ((inlier + peak + scale * d2).exp() + outlier).ln(),
            Some(d2) => peak + scale * d2,
        }
    }

    fn add_sighting(&self, sighting: &Sighting<'_>, block: Block<'_>, out: &mut [f64]) {
        let density = self.log_density(sighting);
        let [x, y, z] = block.columns(POSITION);
        let glued = self.world_sensor * sighting.view.patch_offset;
        let estimated = self.layout.offset.map(|column| block.columns::<3>(column));
        for i in 0..out.len() {
            let mut patch = Vector3::new(x[i], y[i], z[i]) + glued;
            if let Some([ox, oy, oz]) = estimated {
                patch += self.world_sensor * Vector3::new(ox[i], oy[i], oz[i]);
            }
            out[i] += density(sighting.view.camera.project(patch).map(|p| (p - sighting.pixel).norm_squared()));
        }
    }

    /// Residual `(2M,)`, slope `(2M, D)` and noise variance of the sightings about one state, for a linear
    /// filter; a sighting that the state puts behind its camera is left out.
    pub fn linearise(&self, state: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>, DMatrix<f64>)> {
        let mut rows: Vec<(f64, DVector<f64>)> = Vec::new();
        for sighting in &self.sightings {
            let mut offset = sighting.view.patch_offset;
            if let Some(column) = self.layout.offset {
                offset += state.fixed_rows::<3>(column);
            }
            let patch = state.fixed_rows::<3>(POSITION) + self.world_sensor * offset;
            let Some((pixel, by_patch)) = sighting.view.camera.project_with_jacobian(patch) else { continue };
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
            return None;
        }
        let residual = DVector::from_iterator(rows.len(), rows.iter().map(|r| r.0));
        let jacobian = DMatrix::from_fn(rows.len(), state.len(), |r, c| rows[r].1[c]);
        let noise = DMatrix::from_diagonal_element(rows.len(), rows.len(), self.pixel_sd * self.pixel_sd);
        Some((residual, jacobian, noise))
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
