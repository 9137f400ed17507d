//! Angles against the limits of joints, softly: real motion breaks the hard ones of Acclaim files.

use super::super::sloped::{Rows, Sloped};
use super::super::weighing::{Cue, Posed};
use nalgebra::DVector;

/// How far beyond a limit a joint may be, rad.
const LIMIT_SD: f64 = 0.1;

/// Half the sum of squares of how far each angle is beyond its limits, in standard deviations.
pub struct Limits;

impl Cue for Limits {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        out.fill(0.0);
        for (d, [low, high]) in posed.figure.limits.iter().enumerate() {
            for (out, value) in out.iter_mut().zip(posed.column(d)) {
                let beyond = ((low - value).max(value - high)).max(0.0) / LIMIT_SD;
                *out += 0.5 * beyond * beyond;
            }
        }
    }

    fn linearise(&self, at: &Sloped<'_>, rows: &mut Rows) {
        for (d, ([low, high], value)) in at.figure.limits.iter().zip(at.state).enumerate() {
            let within = value.clamp(*low, *high);
            if within != *value {
                let mut slope = DVector::zeros(at.dim());
                slope[d] = 1.0 / LIMIT_SD;
                rows.push_bound((within - value) / LIMIT_SD, slope);
            }
        }
    }
}
