//! The distance cue (Li & Kulić IV-C2): head and hands against the centres of skin that they were given.

use super::super::joints::{Group, KEY_JOINTS};
use super::super::skin::Blobs;
use super::super::weighing::{Cue, Posed};
use crate::Result;
use crate::parameters::{Parameters, require_positive};
use serde::{Deserialize, Serialize};

/// A point behind the camera is as far off as any, px.
const FAR_PX: f64 = 1e4;

/// How far off a blob may be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BlobParameters {
    /// Standard deviation of a blob's centre, m.
    pub sd_m: f64,
    /// Standard deviations beyond which a blob says nothing more.
    pub reach: f64,
    /// How far from where it was expected a blob may be, m.
    pub gate_m: f64,
}

impl BlobParameters {
    /// Of a method's `blob_sd_m`, `blob_reach` and `gate_m`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self { sd_m: from.get("blob_sd_m")?, reach: from.get("blob_reach")?, gate_m: from.get("gate_m")? })
    }

    /// Check every range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_positive("blob_sd_m", self.sd_m, "a positive length in metres")?;
        require_positive("blob_reach", self.reach, "a positive number")?;
        require_positive("gate_m", self.gate_m, "a positive length in metres")
    }
}

/// What a distance counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Itself, px: a blend rescales it.
    Pixels,
    /// Half its square in standard deviations.
    Spread {
        /// Standard deviation of a blob's centre, m.
        sd_m: f64,
        /// Beyond this many standard deviations a blob says nothing more: it may be something else.
        reach: f64,
    },
}

/// Distances of head and hands from their blobs, added up.
pub struct BlobDistance<'a> {
    /// Blobs by wearer.
    pub blobs: Blobs,
    /// Groups whose wearers count.
    pub groups: &'a [Group],
    /// What a distance counts.
    pub scale: Scale,
}

impl Cue for BlobDistance<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let seen = posed.seen(i);
            *out = 0.0;
            for group in self.groups {
                let Some([u, v]) = self.blobs[group.wearer()] else { continue };
                let [a, b] = [0, 1].map(|end| seen[KEY_JOINTS.len() + 2 * group.wearer() + end]);
                let (du, dv) = (0.5 * (a.u + b.u) - u, 0.5 * (a.v + b.v) - v);
                let distance = (du * du + dv * dv).sqrt();
                let distance = if distance.is_finite() { distance } else { FAR_PX };
                *out += match self.scale {
                    Scale::Pixels => distance,
                    Scale::Spread { sd_m, reach } => {
                        let in_sd = (distance / (sd_m * a.px_per_m)).min(reach);
                        0.5 * in_sd * in_sd
                    }
                };
            }
        }
    }
}
