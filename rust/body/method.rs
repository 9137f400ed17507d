//! A method of tracking the body: its layers, how particles move and how they are weighed.
//!
//! | method | layers |
//! |---|---|
//! | plain (Li & Kulić) | [zero-order, edges and skin rescaled over the set] |
//! | annealed | [diffusion, cues] k times: flat to sharp, the diffusion shrinking |
//! | partitioned | torso; left arm; right arm |
//! | mixture | [velocities, all that is smooth] on Gaussians |

use super::cues::{BOUNDS, CueName, CueParameters, Frame};
use super::figure::Figure;
use super::joints::Group;
use super::momentum::Momentum;
use super::motion::{Anew, Walk};
use super::unseen::Unseen;
use super::weighing::{Cue, Weighing};
use crate::error::require;
use crate::filter::{Blend, Resampling};
use crate::parameters::require_not_negative;
use crate::skeleton::Channel;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// What a layer moves, by diffusion where there are particles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mover {
    /// Groups of columns that diffuse; of these the parts, blobs and points weigh.
    pub groups: Vec<Group>,
    /// Share of the diffusion's standard deviation.
    pub spread: f64,
}

/// One layer: what it moves, what it weighs by, and how what the cues say is blended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyLayer {
    /// Applied first.
    pub mover: Mover,
    /// Where a frame has what they need.
    pub cues: Vec<CueName>,
    /// How they are blended.
    pub blend: Blend,
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

/// A method of tracking the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyMethod {
    /// Which filter.
    pub filter: FilterMethod,
    /// Applied in order at every frame; by a mixture all at once, of their cues those that are smooth.
    pub layers: Vec<BodyLayer>,
    /// How much each cue counts.
    pub cue_parameters: CueParameters,
    /// Of how far arms reach towards the camera, so much the trunk gives way.
    pub balance: f64,
    /// What the estimate adds to the joints' depth.
    pub unseen: Unseen,
}

/// Which filter, and what it alone needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum FilterMethod {
    /// Layers on a particle set.
    Particles(ParticleMethod),
    /// Gaussians over channels and their velocities.
    Mixture(MixtureMethod),
}

/// What particles need.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParticleMethod {
    /// How many.
    pub particles: usize,
    /// Into how many shares they are divided that are filtered on their own.
    pub islands: usize,
    /// After each layer.
    pub resampling: Resampling,
    /// How the body moves.
    pub diffusion: Diffusion,
    /// Share of the particles whose arm is drawn anew from all that its joints allow.
    pub anew_share: f64,
    /// Where the whole recording is smoothed in the end: how the body moves there.
    pub smoothing: Option<Momentum>,
}

/// What a mixture of Gaussians needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MixtureMethod {
    /// Components that are kept.
    pub components: usize,
    /// How the body moves.
    pub momentum: Momentum,
}

/// No spread is larger.
const MOST: f64 = 1e6;
/// Particles forget within it how an arm was held, s (chosen on clips of people and on simulated ones, of 60 and 30 frames/s).
const FORGOTTEN_S: f64 = 1.0 / 15.0;

impl BodyLayer {
    /// All groups by these cues.
    pub fn whole(cues: Vec<CueName>) -> Self {
        let mover = Mover { groups: vec![Group::Torso, Group::LeftArm, Group::RightArm], spread: 1.0 };
        Self { mover, cues, blend: Blend::Sum { sharpness: 1.0 } }
    }

    /// Check every range, and that cues and blend go together.
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::UnknownName`].
    pub fn check(&self) -> Result<()> {
        let spread = self.mover.spread;
        require((0.0..=MOST).contains(&spread), "spread of a layer", spread, "0 or more")?;
        if let Some(twice) = (1..self.cues.len()).find(|k| self.cues[..*k].contains(&self.cues[*k])) {
            let name = format!("{:?}", self.cues[twice]).to_lowercase();
            return Err(Error::UnknownName { what: "second cue", name, known: "each at most once" });
        }
        self.blend.check()?;
        let is_papers = self.cues.iter().filter(|cue| !BOUNDS.contains(cue)).eq(&[CueName::Edges, CueName::Blobs]);
        if is_papers || matches!(self.blend, Blend::Sum { .. }) {
            return Ok(());
        }
        Err(Error::UnknownName {
            what: "list of cues that are rescaled",
            name: format!("{:?}", self.cues).to_lowercase(),
            known: "edges, blobs, and of effort, posture, limits and penetration what is wanted",
        })
    }
}

impl ParticleMethod {
    fn check(&self) -> Result<()> {
        let Diffusion { base, base_turn, trunk, joint } = self.diffusion;
        require_not_negative("base_density", base, "0 m/√s or more")?;
        require_not_negative("base_turn_density", base_turn, "0 rad/√s or more")?;
        require_not_negative("trunk_density", trunk, "0 rad/√s or more")?;
        require_not_negative("joint_density", joint, "0 rad/√s or more")?;
        require((0.0..1.0).contains(&self.anew_share), "anew_share", self.anew_share, "a share from 0 to below 1")?;
        self.smoothing.iter().try_for_each(Momentum::check)
    }

    pub(super) fn walk(&self, figure: &Figure, mover: &Mover, elapsed_s: f64) -> Walk {
        let Diffusion { base, base_turn, trunk, joint } = self.diffusion;
        let density = |(bone, channel): (usize, Channel), group: Group| match (bone, channel, group) {
            (_, Channel::Translation(_), _) => base,
            (0, Channel::Rotation(_), _) => base_turn,
            (_, _, Group::Torso) => trunk,
            _ => joint,
        };
        let columns = figure.channels.iter().zip(&figure.groups);
        let sd = columns.map(|(channel, group)| {
            let moves = mover.groups.contains(group);
            if moves { density(*channel, *group) * mover.spread * elapsed_s.sqrt() } else { 0.0 }
        });
        let sd: Vec<f64> = sd.collect();
        let anew = if elapsed_s > 0.0 { Anew::arms(figure, &mover.groups) } else { Vec::new() };
        Walk { sd, anew, share: self.anew_share * mover.spread }
    }
}

impl MixtureMethod {
    fn check(&self) -> Result<()> {
        require((1..=100).contains(&self.components), "components", self.components as f64, "1 to 100")?;
        self.momentum.check()
    }
}

impl BodyMethod {
    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        match &self.filter {
            FilterMethod::Particles(particles) => particles.check()?,
            FilterMethod::Mixture(mixture) => mixture.check()?,
        }
        self.cue_parameters.check()?;
        require((0.0..=1.0).contains(&self.balance), "balance", self.balance, "a share from 0 to 1")?;
        self.unseen.check()?;
        if self.layers.is_empty() {
            return Err(Error::Size { name: "layers", got: 0, unit: "layers", expected: 1 });
        }
        self.layers.iter().try_for_each(BodyLayer::check)
    }

    /// The same, for frames `every_s` apart, of which those within `lasts_s` together say once what speaks against a posture.
    pub(super) fn for_postures(&self, every_s: f64, lasts_s: f64) -> Self {
        let mut method = self.clone();
        let share = (every_s / lasts_s).min(1.0);
        method.cue_parameters.effort.loss *= share;
        method.cue_parameters.posture.weight *= share;
        method
    }

    /// The same, for particles `elapsed_s` after the last frame, which forget soon what a posture is worth: it is said again.
    pub(super) fn for_particles(&self, elapsed_s: f64) -> Self {
        let mut method = self.clone();
        method.cue_parameters.posture.weight *= (elapsed_s / FORGOTTEN_S).min(1.0);
        method
    }

    /// What a layer weighs particles by, of what a frame shows.
    pub(super) fn weighing<'a>(&self, layer: &'a BodyLayer, frame: &Frame<'a>) -> Weighing<'a> {
        let (bounds, cues): (Vec<_>, Vec<_>) = layer.cues.iter().partition(|cue| BOUNDS.contains(cue));
        let boxed = |names: Vec<&CueName>| names.into_iter().filter_map(|cue| self.cue(*cue, layer, frame)).collect();
        let (figure, projection, blend) = (frame.figure, frame.projection, layer.blend);
        Weighing { figure, projection, cues: boxed(cues), bounds: boxed(bounds), blend }
    }

    /// Its cues for a layer, where a frame has what they need.
    pub(super) fn cues_of<'a>(
        &self,
        layer: &'a BodyLayer,
        frame: &Frame<'a>,
    ) -> impl Iterator<Item = Box<dyn Cue + 'a>> {
        layer.cues.iter().filter_map(|cue| self.cue(*cue, layer, frame))
    }

    fn cue<'a>(&self, name: CueName, layer: &'a BodyLayer, frame: &Frame<'a>) -> Option<Box<dyn Cue + 'a>> {
        let is_rescaled = matches!(layer.blend, Blend::Rescaled { .. });
        frame.cue(name, &self.cue_parameters, &layer.mover.groups, is_rescaled)
    }
}
