//! The edge cue (Li & Kulić eq. 4): outlines of the parts against detected edges.

use super::super::edges::{EdgeImage, rectangle};
use super::super::joints::Group;
use super::super::weighing::{Cue, Posed};
use crate::Result;
use crate::parameters::{Parameters, require_not_negative};
use serde::{Deserialize, Serialize};

/// How much outlines count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutlineParameters {
    /// Log-likelihood lost by a part that misses every edge.
    pub loss: f64,
}

impl OutlineParameters {
    /// Of a method's `edge_loss`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self { loss: from.get("edge_loss")? })
    }

    /// Check its range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_not_negative("edge_loss", self.loss, "0 or more")
    }
}

/// Sum over the parts of the share of outline pixels that lie on no edge.
pub struct Outline<'a> {
    /// Detected edges.
    pub edges: &'a EdgeImage,
    /// Groups whose parts count.
    pub groups: &'a [Group],
    /// Log-likelihood lost by a part that misses every edge; 1 where distances are rescaled.
    pub loss: f64,
}

impl Cue for Outline<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let seen = posed.seen(i);
            let limbs = posed.figure.limbs.iter().filter(|limb| self.groups.contains(&limb.group));
            let outline = limbs.map(|limb| rectangle(seen[limb.start], seen[limb.end], limb.half_width_m));
            *out = self.loss * outline.map(|outline| self.edges.missed(&outline)).sum::<f64>();
        }
    }
}
