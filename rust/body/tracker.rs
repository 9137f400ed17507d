//! The online tracker of the body: an image's evidence in, a pose with error bars out.
//!
//! | method | layers |
//! |---|---|
//! | plain (Li & Kulić) | [zero-order, edges and skin rescaled over the set] |
//! | annealed | [diffusion, cues] k times: flat to sharp, the diffusion shrinking |
//! | partitioned | torso; left arm; right arm |

use super::cues::{FixedScale, Look, Rescaled, Scene};
use super::edges::EdgeImage;
use super::figure::{Figure, Group};
use super::island::{Island, Posterior, Sight, most_given};
use super::motion::{Anew, Walk};
use super::skin::Blobs;
use super::unseen::Unseen;
use crate::error::require;
use crate::filter::{Likelihood, Recorder, Resampling};
use crate::particles::{ParticleSet, Summary};
use crate::projection::Projection;
use crate::rng::branch;
use crate::skeleton::Channel;
use crate::{Error, Result};
use nalgebra::Vector3;
use rayon::prelude::*;
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
    /// What the estimate adds to the joints' depth.
    pub unseen: Unseen,
}

impl BodyMethod {
    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let zero_or_more = |x: f64| x >= 0.0 && x.is_finite();
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
                require(base > 1.0 && base.is_finite(), "sharpness", base, "above 1")?;
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

    pub(super) fn weighing<'a>(&'a self, layer: &BodyLayer, scene: Scene<'a>) -> Box<dyn Likelihood + 'a> {
        let Self { blob_sd_m, blob_reach, limits, penetration, .. } = *self;
        let look = Look { groups: layer.groups.clone(), blob_sd_m, blob_reach, limits, penetration };
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

/// What a frame shows.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyEvidence {
    /// Detected edges.
    pub edges: EdgeImage,
    /// Centres of skin-coloured blobs, px, in no order.
    pub blobs: Vec<[f64; 2]>,
}

/// What the tracker knows at one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyEstimate {
    /// Recording time, s.
    pub time_s: f64,
    /// The state, `(D,)`: m and rad.
    pub state: Summary,
    /// The key joints, `(8 * 3,)`: world, m.
    pub joints: Summary,
    /// The blob that each wearer was given, px.
    pub blobs: Blobs,
    /// Effective sample size.
    pub ess: f64,
    /// Log evidence, where the weights are likelihoods.
    pub log_evidence: Option<f64>,
}

/// Follows one body. Clone or [`BodyTracker::save`] it to resume later with the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyTracker {
    figure: Figure,
    projection: Projection,
    method: BodyMethod,
    islands: Vec<Island>,
    first_frame_s: Option<f64>,
    last_frame_s: Option<f64>,
    lost_at_s: Option<f64>,
}

impl BodyTracker {
    /// All particles at the figure's own pose (paper IV-C1).
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::Size`].
    pub fn new(figure: Figure, projection: Projection, method: BodyMethod, seed: u64) -> Result<Self> {
        method.check()?;
        let (count, len) = (method.islands, method.len);
        let share = |k: usize| len / count + usize::from(k < len % count);
        let islands = (0..count).map(|k| Island::new(&figure, &method, share(k), branch(seed, k as u64)));
        let islands = islands.collect::<Result<_>>()?;
        Ok(Self { figure, projection, method, islands, first_frame_s: None, last_frame_s: None, lost_at_s: None })
    }

    /// The figure.
    pub fn figure(&self) -> &Figure {
        &self.figure
    }

    /// The particles as they stand, of all islands.
    pub fn particles(&self) -> ParticleSet {
        ParticleSet::together(&self.islands.iter().map(Island::particles).collect::<Vec<_>>())
    }

    /// Take a frame. The first moves nothing: the figure's pose is the pose there.
    ///
    /// # Errors
    /// [`Error::Late`], [`Error::NotFinite`]; [`Error::AllWeightsZero`] and [`Error::RanAway`], after which it is
    /// [`Error::Lost`].
    pub fn update(&mut self, time_s: f64, evidence: &BodyEvidence) -> Result<BodyEstimate> {
        self.update_recorded(time_s, evidence, None)
    }

    /// The same, showing `recorder` every layer, island by island.
    ///
    /// # Errors
    /// As [`BodyTracker::update`].
    pub fn update_recorded(
        &mut self,
        time_s: f64,
        evidence: &BodyEvidence,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<BodyEstimate> {
        if !time_s.is_finite() {
            return Err(Error::NotFinite { name: "frame time", time_s, value: time_s });
        }
        if let Some(lost_at_s) = self.lost_at_s {
            return Err(Error::Lost { time_s, lost_at_s });
        }
        if let Some(latest_s) = self.last_frame_s.filter(|last| time_s <= *last) {
            return Err(Error::Late { what: "frame", time_s, latest_s });
        }
        let elapsed_s = self.last_frame_s.map_or(0.0, |last| time_s - last);
        let Self { figure, projection, method, islands, .. } = self;
        let sight = Sight { figure, projection, method, evidence, time_s, elapsed_s };
        // Until it is known that all went well: a filter that failed half-way must not be used again.
        self.lost_at_s = Some(time_s);
        let posteriors: Vec<Posterior> = if let Some(recorder) = recorder {
            islands.iter_mut().map(|island| island.update(&sight, Some(&mut *recorder))).collect::<Result<_>>()?
        } else if islands.len() == 1 {
            vec![islands[0].update(&sight, None)?]
        } else {
            let each: Vec<_> = islands.par_iter_mut().map(|island| island.update(&sight, None)).collect();
            // Of several errors the first island's, for any number of threads.
            each.into_iter().collect::<Result<_>>()?
        };
        let estimate = self.look_at(time_s, &posteriors);
        let found = [&estimate.state.mean, &estimate.joints.mean];
        if !found.into_iter().chain([&estimate.joints.mode]).all(|v| v.iter().all(|x| x.is_finite())) {
            return Err(Error::RanAway { time_s });
        }
        self.lost_at_s = None;
        self.first_frame_s.get_or_insert(time_s);
        self.last_frame_s = Some(time_s);
        Ok(estimate)
    }

    /// All islands together.
    fn look_at(&self, time_s: f64, posteriors: &[Posterior]) -> BodyEstimate {
        let sets: Vec<&ParticleSet> = posteriors.iter().map(|posterior| &posterior.particles).collect();
        let together = ParticleSet::together(&sets);
        let joints = self.figure.key_joints(&together);
        let root = Vector3::from_column_slice(&joints.moments().0.as_slice()[..3]);
        let since_s = self.first_frame_s.map_or(0.0, |first| time_s - first);
        let joints = self.method.unseen.added(joints, &self.projection, root, since_s);
        BodyEstimate {
            time_s,
            state: together.summary(together.dim()),
            joints: joints.summary(joints.dim()),
            blobs: most_given(posteriors),
            ess: together.ess(),
            log_evidence: evidence(posteriors),
        }
    }

    /// The whole tracker as bytes, for [`BodyTracker::restore`] by the same version.
    ///
    /// # Errors
    /// [`Error::SavedState`] when memory runs out.
    pub fn save(&self) -> Result<Vec<u8>> {
        postcard::to_stdvec(self).map_err(|e| Error::SavedState { reason: e.to_string() })
    }

    /// From [`BodyTracker::save`].
    ///
    /// # Errors
    /// [`Error::SavedState`].
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        postcard::from_bytes(bytes).map_err(|e| Error::SavedState { reason: e.to_string() })
    }
}

/// Log of the mean of the islands' evidence of this frame, each by its share of the particles. Of one frame only: what
/// the frames before said of an island has not moved its share.
fn evidence(posteriors: &[Posterior]) -> Option<f64> {
    let of_each = posteriors.iter().map(|p| Some((p.particles.len() as f64, p.log_evidence?)));
    let of_each = of_each.collect::<Option<Vec<_>>>()?;
    let largest = of_each.iter().map(|(_, log)| *log).fold(f64::MIN, f64::max);
    let sum: f64 = of_each.iter().map(|(len, log)| len * (log - largest).exp()).sum();
    Some(largest + (sum / of_each.iter().map(|(len, _)| len).sum::<f64>()).ln())
}
