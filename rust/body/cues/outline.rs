//! The edge cue (Li & Kulić eq. 4): outlines of the parts against detected edges.

use super::super::edges::{EdgeImage, rectangle};
use super::super::joints::Group;
use super::{Cue, Posed};

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
