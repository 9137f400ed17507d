//! Angles against the limits of joints, softly: real motion breaks the hard ones of Acclaim files.

use super::{Cue, Posed};

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
}
