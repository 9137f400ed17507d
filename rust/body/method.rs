//! A method of tracking the body: its layers, how particles move and how they are weighed.
//!
//! | method | layers |
//! |---|---|
//! | plain (Li & Kulić) | [zero-order, edges and skin rescaled over the set] |
//! | annealed | [diffusion, cues] k times: flat to sharp, the diffusion shrinking |
//! | partitioned | torso; left arm; right arm |

use super::cues::{FixedScale, Look, Rescaled, Scene};
use super::figure::{Figure, Group};
use super::motion::{Anew, Walk};
use super::region::RegionLook;
use super::unseen::Unseen;
use crate::error::require;
use crate::filter::{Likelihood, Resampling};
use crate::skeleton::Channel;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// One layer: what it moves and what it looks at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyLayer {
    /// Groups of columns that diffuse and of parts and blobs that weigh.
    pub groups: Vec<Group>,
    /// Share of the diffusion's standard deviation.
    pub spread: f64,
    /// Share of the likelihood's sharpness.
    pub sharpness: f64,
}

/// How uncertain motion is: zero-order dynamics, per √s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Diffusion {
    /// The root's place, m/√s.
    pub base: f64,
    /// The root's turns, rad/√s.
    pub base_turn: f64,
    /// Turns of back and neck, where they are free, rad/√s.
    pub trunk: f64,
    /// Turns of shoulders and elbows, rad/√s.
    pub joint: f64,
}

/// How particles are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Weighing {
    /// As the paper does.
    Rescaled {
        /// `A`.
        base: f64,
        /// Weight of the edge cue, 0 to 2.
        alpha: f64,
        /// How far alpha follows what each cue tells apart, 0 to 1.
        adapt: f64,
    },
    /// On a fixed scale.
    Fixed {
        /// Log-likelihood lost by a part that misses every edge.
        edge_loss: f64,
    },
}

/// How much skin and foreground count as regions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Regions {
    /// Log-likelihood lost by hands and forearms off the skin, and by skin that nobody wears.
    pub skin_loss: f64,
    /// The same of limbs and the foreground.
    pub foreground_loss: f64,
    /// As bad as any, m.
    pub reach_m: f64,
}

/// A method of tracking the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyMethod {
    /// How many particles.
    pub len: usize,
    /// Into how many shares they are divided that are filtered on their own.
    pub islands: usize,
    /// Applied in order at every frame.
    pub layers: Vec<BodyLayer>,
    /// After each layer.
    pub resampling: Resampling,
    /// How the body moves.
    pub diffusion: Diffusion,
    /// Share of the particles whose arm is drawn anew from all that its joints allow.
    pub anew_share: f64,
    /// How particles are weighed.
    pub weighing: Weighing,
    /// Standard deviation of a blob's centre, m.
    pub blob_sd_m: f64,
    /// Standard deviations beyond which a blob says nothing more.
    pub blob_reach: f64,
    /// How far from where it was expected a blob may be, m.
    pub gate_m: f64,
    /// Whether limits of joints count.
    pub limits: bool,
    /// Whether hands in the torso count.
    pub penetration: bool,
    /// How much regions count.
    pub regions: Regions,
    /// What the estimate adds to the joints' depth.
    pub unseen: Unseen,
}

/// No parameter is larger, in any unit.
const MOST: f64 = 1e6;

impl BodyMethod {
    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        let positive = |x: f64| x > 0.0 && x <= MOST;
        let zero_or_more = |x: f64| (0.0..=MOST).contains(&x);
        let Diffusion { base, base_turn, trunk, joint } = self.diffusion;
        require(
            (1..=self.len.max(1)).contains(&self.islands),
            "islands",
            self.islands as f64,
            "1 to the number of particles",
        )?;
        require(zero_or_more(base), "base_density", base, "0 m/√s or more")?;
        require(zero_or_more(base_turn), "base_turn_density", base_turn, "0 rad/√s or more")?;
        require(zero_or_more(trunk), "trunk_density", trunk, "0 rad/√s or more")?;
        require(zero_or_more(joint), "joint_density", joint, "0 rad/√s or more")?;
        require((0.0..1.0).contains(&self.anew_share), "anew_share", self.anew_share, "a share from 0 to below 1")?;
        match self.weighing {
            Weighing::Rescaled { base, alpha, adapt } => {
                require(base > 1.0 && base <= 1e100, "sharpness", base, "above 1")?;
                require((0.0..=2.0).contains(&alpha), "alpha", alpha, "0 to 2")?;
                require((0.0..=1.0).contains(&adapt), "adapt", adapt, "0 to 1")?;
            }
            Weighing::Fixed { edge_loss } => {
                require(zero_or_more(edge_loss), "edge_loss", edge_loss, "0 or more")?;
            }
        }
        require(positive(self.blob_sd_m), "blob_sd_m", self.blob_sd_m, "a positive length in metres")?;
        require(positive(self.blob_reach), "blob_reach", self.blob_reach, "a positive number")?;
        require(positive(self.gate_m), "gate_m", self.gate_m, "a positive length in metres")?;
        let Regions { skin_loss, foreground_loss, reach_m } = self.regions;
        require(zero_or_more(skin_loss), "skin_loss", skin_loss, "0 or more")?;
        require(zero_or_more(foreground_loss), "foreground_loss", foreground_loss, "0 or more")?;
        require(positive(reach_m), "region_reach_m", reach_m, "a positive length in metres")?;
        self.unseen.check()?;
        if self.layers.is_empty() {
            return Err(Error::Size { name: "layers", got: 0, unit: "layers", expected: 1 });
        }
        for layer in &self.layers {
            require(zero_or_more(layer.spread), "spread of a layer", layer.spread, "0 or more")?;
            require(positive(layer.sharpness), "sharpness of a layer", layer.sharpness, "positive")?;
        }
        Ok(())
    }

    pub(super) fn walk(&self, figure: &Figure, layer: &BodyLayer, elapsed_s: f64) -> Walk {
        let Diffusion { base, base_turn, trunk, joint } = self.diffusion;
        let density = |(bone, channel): (usize, Channel), group: Group| match (bone, channel, group) {
            (_, Channel::Translation(_), _) => base,
            (0, Channel::Rotation(_), _) => base_turn,
            (_, _, Group::Torso) => trunk,
            _ => joint,
        };
        let columns = figure.channels.iter().zip(&figure.groups);
        let sd = columns.map(|(channel, group)| {
            let moves = layer.groups.contains(group);
            if moves { density(*channel, *group) * layer.spread * elapsed_s.sqrt() } else { 0.0 }
        });
        let sd: Vec<f64> = sd.collect();
        let anew = if elapsed_s > 0.0 { Anew::arms(figure, &layer.groups) } else { Vec::new() };
        Walk { sd, anew, share: self.anew_share * layer.spread }
    }

    pub(super) fn weighing<'a>(&'a self, layer: &BodyLayer, scene: Scene<'a>, bare: f64) -> Box<dyn Likelihood + 'a> {
        let Self { blob_sd_m, blob_reach, limits, penetration, .. } = *self;
        let Regions { skin_loss, foreground_loss, reach_m } = self.regions;
        let regions =
            (skin_loss + foreground_loss > 0.0).then_some(RegionLook { skin_loss, foreground_loss, reach_m, bare });
        let look = Look { groups: layer.groups.clone(), blob_sd_m, blob_reach, regions, limits, penetration };
        match self.weighing {
            Weighing::Rescaled { base, alpha, adapt } => {
                let base = base.powf(layer.sharpness);
                Box::new(Rescaled { scene, look, base, alpha, adapt })
            }
            Weighing::Fixed { edge_loss } => {
                // A cue that is weighed by in several layers is a likelihood in none of them.
                let looks = |group: &Group| self.layers.iter().filter(|l| l.groups.contains(group)).count();
                let is_evidence = layer.sharpness == 1.0 && layer.groups.iter().all(|group| looks(group) == 1);
                Box::new(FixedScale { scene, look, edge_loss, sharpness: layer.sharpness, is_evidence })
            }
        }
    }
}
