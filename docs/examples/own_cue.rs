//! A cue of your own: a camera tells the direction of a wrist, and a rangefinder beside it how far off it is.
//!
//! `cargo run --release --example own_cue` follows a simulated wrist with the camera's cue alone, and with both.
//! What is yours is `Range`: a likelihood, which weighs all particles at once. A tracker is a list of layers.

use nalgebra::{Matrix3, Vector2, Vector3};
use pytracker::camera::Camera;
use pytracker::filter::{Blend, Layer, LayeredFilter, Likelihood, Resampling, Transition};
use pytracker::particles::{BlockMut, ParticleSet};
use pytracker::resample::Scheme;
use pytracker::rng::{Stream, Streams};
use rand::RngExt;
use rand_distr::StandardNormal;

const FRAME_S: f64 = 0.04;
const FRAMES: u32 = 250;
const PIXEL_SD: f64 = 3.0;
const RANGE_SD_M: f64 = 0.03;
/// Columns of the state: where the wrist is, m, and how fast it goes, m/s.
const COLUMNS: usize = 6;

/// The wrist goes on and slows down, its velocity walks.
struct Motion;

impl Transition for Motion {
    fn propagate(&self, mut block: BlockMut<'_>, rng: &mut Stream) {
        let columns: [&mut [f64]; COLUMNS] = block.columns_mut([0, 1, 2, 3, 4, 5]);
        let [x, y, z, vx, vy, vz] = columns;
        for (place, velocity) in [(x, vx), (y, vy), (z, vz)] {
            for (place, velocity) in place.iter_mut().zip(velocity) {
                *velocity = 0.9 * *velocity + 0.1 * rng.sample::<f64, _>(StandardNormal);
                *place += FRAME_S * *velocity;
            }
        }
    }

    /// Only smoothing asks for it, which this does not.
    fn log_densities(&self, _from: &[f64], _to: &[f64], out: &mut [f64]) {
        out.fill(f64::NEG_INFINITY);
    }
}

/// The camera's cue: the wrist is seen at a pixel.
struct Seen<'a> {
    camera: &'a Camera,
    pixel: Vector2<f64>,
}

impl Likelihood for Seen<'_> {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        particles.map_blocks(out, |block, out| {
            self.camera.squared_distances(block.columns::<3>(0), Vector3::zeros(), self.pixel, out);
            for of in out {
                *of *= -0.5 / (PIXEL_SD * PIXEL_SD);
            }
        });
    }
}

/// Your own: how far the wrist is from where the rangefinder stands, m.
struct Range {
    from: Vector3<f64>,
    measured_m: f64,
}

impl Likelihood for Range {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        particles.map_blocks(out, |block, out| {
            let [x, y, z] = block.columns::<3>(0);
            for (k, of) in out.iter_mut().enumerate() {
                let far = (Vector3::new(x[k], y[k], z[k]) - self.from).norm();
                *of = -0.5 * ((far - self.measured_m) / RANGE_SD_M).powi(2);
            }
        });
    }
}

/// A wrist that draws circles towards the camera and away from it.
fn wrist(frame: u32) -> Vector3<f64> {
    let angle = 1.5 * FRAME_S * f64::from(frame);
    Vector3::new(0.15 * angle.cos(), 0.05 * (2.0 * angle).sin(), 0.2 * angle.sin())
}

/// Where the wrist may be at first: within a hand's breadth.
fn prior(seed: u64) -> pytracker::Result<ParticleSet> {
    let (mut set, streams, start) = (ParticleSet::new(2000, COLUMNS)?, Streams::new(seed, u64::MAX, 0), wrist(0));
    set.for_each_block(|number, mut block| {
        let mut rng = streams.block(number);
        for column in 0..COLUMNS {
            let (middle, sd) = if column < 3 { (start[column], 0.05) } else { (0.0, 0.3) };
            block.column_mut(column).fill_with(|| middle + sd * rng.sample::<f64, _>(StandardNormal));
        }
    });
    Ok(set)
}

/// RMS error of the wrist, m, followed with the rangefinder or without.
fn follow(has_range: bool, seed: u64) -> pytracker::Result<f64> {
    let matrix = Matrix3::new(600.0, 0.0, 320.0, 0.0, 600.0, 240.0, 0.0, 0.0, 1.0);
    let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.5))?;
    let mut filter = LayeredFilter::new(prior(seed)?, Resampling::new(Scheme::Systematic, 0.5)?, seed);
    let mut noise = Streams::new(seed, u64::MAX - 1, 0).resampling();
    let mut squares = 0.0;
    for frame in 1..=FRAMES {
        let truth = wrist(frame);
        let mut off = |sd: f64| sd * noise.sample::<f64, _>(StandardNormal);
        let pixel = camera.project(truth).expect("before the camera") + Vector2::new(off(PIXEL_SD), off(PIXEL_SD));
        let seen = Seen { camera: &camera, pixel };
        let range = Range { from: camera.centre(), measured_m: (truth - camera.centre()).norm() + off(RANGE_SD_M) };
        let mut likelihoods: Vec<&dyn Likelihood> = vec![&seen];
        if has_range {
            likelihoods.push(&range);
        }
        let layer = Layer { transition: &Motion, likelihoods, blend: Blend::PRODUCT };
        let time_s = FRAME_S * f64::from(frame);
        let mean = filter.cycle(time_s, &[layer], None, |particles, _| particles.moments().0)?;
        squares += (mean.fixed_rows::<3>(0) - truth).norm_squared();
    }
    Ok((squares / f64::from(FRAMES)).sqrt())
}

fn main() -> pytracker::Result<()> {
    println!("the camera's cue alone: {:.1} cm", 100.0 * follow(false, 7)?);
    println!("with a rangefinder's:   {:.1} cm", 100.0 * follow(true, 7)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::follow;

    #[test]
    fn a_cue_of_ones_own_tells_what_the_camera_does_not() {
        for seed in 1..=5 {
            let (alone, both) = (follow(false, seed).unwrap(), follow(true, seed).unwrap());
            assert!(both < 0.03 && alone > 2.0 * both, "{alone} {both}");
        }
    }
}
