//! A method of tracking the body: its layers, how particles move and how they are weighed.
//!
//! | method | layers |
//! |---|---|
//! | plain (Li & Kulić) | [zero-order, edges and skin rescaled over the set] |
//! | annealed | [diffusion, cues] k times: flat to sharp, the diffusion shrinking |
//! | partitioned | torso; left arm; right arm |

use super::cues::blobs::{BlobDistance, Scale};
use super::cues::effort::Effort;
use super::cues::keypoints::{KeypointDistance, KeypointLook, Person};
use super::cues::limits::Limits;
use super::cues::orientation::{Orientation, OrientationDistance};
use super::cues::outline::Outline;
use super::cues::penetration::Penetration;
use super::cues::region::{RegionLook, Regions};
use super::cues::{Blend, Cue, Weighing};
use super::figure::Figure;
use super::joints::Group;
use super::momentum::Momentum;
use super::motion::{Anew, Walk};
use super::picture::Picture;
use super::skin::Blobs;
use super::unseen::Unseen;
use crate::error::require;
use crate::filter::Resampling;
use crate::projection::Projection;
use crate::skeleton::Channel;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// What a layer moves, by diffusion.
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

/// What a layer weighs by; see [`super::cues`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CueName {
    /// [`super::cues::outline`].
    Edges,
    /// [`super::cues::blobs`].
    Blobs,
    /// [`super::cues::region`].
    Regions,
    /// [`super::cues::keypoints`].
    Keypoints,
    /// [`super::cues::orientation`].
    Orientation,
    /// [`super::cues::effort`].
    Effort,
    /// [`super::cues::limits`].
    Limits,
    /// [`super::cues::penetration`].
    Penetration,
}

impl CueName {
    /// In lower case.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        let known = "edges, blobs, regions, keypoints, orientation, effort, limits, penetration";
        match name {
            "edges" => Ok(Self::Edges),
            "blobs" => Ok(Self::Blobs),
            "regions" => Ok(Self::Regions),
            "keypoints" => Ok(Self::Keypoints),
            "orientation" => Ok(Self::Orientation),
            "effort" => Ok(Self::Effort),
            "limits" => Ok(Self::Limits),
            "penetration" => Ok(Self::Penetration),
            _ => Err(Error::UnknownName { what: "cue", name: name.into(), known }),
        }
    }
}

/// A method of tracking the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyMethod {
    /// How many particles.
    pub particles: usize,
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
    /// Log-likelihood lost by a part that misses every edge.
    pub edge_loss: f64,
    /// Standard deviation of a blob's centre, m.
    pub blob_sd_m: f64,
    /// Standard deviations beyond which a blob says nothing more.
    pub blob_reach: f64,
    /// How far from where it was expected a blob may be, m.
    pub gate_m: f64,
    /// Log-likelihood lost by hands and forearms off the skin, and by skin that nobody wears.
    pub skin_loss: f64,
    /// The same of limbs and the foreground.
    pub foreground_loss: f64,
    /// Farther off a region than this is as bad as any, m.
    pub region_reach_m: f64,
    /// How much keypoints count.
    pub keypoints: KeypointLook,
    /// How many times the spread that it says an orientation has.
    pub orientation_inflation: f64,
    /// Log-likelihood lost by an upper arm that is held out level.
    pub effort_loss: f64,
    /// Of how far arms reach towards the camera, so much the trunk gives way.
    pub balance: f64,
    /// What the estimate adds to the joints' depth.
    pub unseen: Unseen,
    /// Where the whole recording is smoothed: how the body moves.
    pub smoothing: Option<Momentum>,
}

/// What a body can do at all, whatever is seen.
const BOUNDS: [CueName; 3] = [CueName::Effort, CueName::Limits, CueName::Penetration];

/// What a frame shows to one filter.
pub(super) struct Frame<'a> {
    pub figure: &'a Figure,
    pub projection: &'a Projection,
    pub picture: &'a Picture,
    /// Of segments that wear a sensor.
    pub orientations: &'a [Orientation],
    /// By wearer.
    pub blobs: Blobs,
    /// Of all whose keypoints were found, the one who is followed.
    pub person: Option<&'a Person>,
    /// How bare the forearms are, 0 to 1.
    pub bare: f64,
}

/// No parameter is larger, in any unit.
const MOST: f64 = 1e6;

impl BodyLayer {
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
        match self.blend {
            Blend::Sum { sharpness } => {
                require(sharpness > 0.0 && sharpness <= MOST, "sharpness of a layer", sharpness, "positive")
            }
            Blend::Rescaled { base, alpha, adapt } => {
                require(base > 1.0 && base <= 1e100, "sharpness", base, "above 1")?;
                require((0.0..=2.0).contains(&alpha), "alpha", alpha, "0 to 2")?;
                require((0.0..=1.0).contains(&adapt), "adapt", adapt, "0 to 1")?;
                if self.cues.iter().filter(|cue| !BOUNDS.contains(cue)).eq(&[CueName::Edges, CueName::Blobs]) {
                    return Ok(());
                }
                Err(Error::UnknownName {
                    what: "list of cues that are rescaled",
                    name: format!("{:?}", self.cues).to_lowercase(),
                    known: "edges, blobs, and of effort, limits and penetration what is wanted",
                })
            }
        }
    }
}

impl BodyMethod {
    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        let positive = |x: f64| x > 0.0 && x <= MOST;
        let zero_or_more = |x: f64| (0.0..=MOST).contains(&x);
        let Diffusion { base, base_turn, trunk, joint } = self.diffusion;
        require(zero_or_more(base), "base_density", base, "0 m/√s or more")?;
        require(zero_or_more(base_turn), "base_turn_density", base_turn, "0 rad/√s or more")?;
        require(zero_or_more(trunk), "trunk_density", trunk, "0 rad/√s or more")?;
        require(zero_or_more(joint), "joint_density", joint, "0 rad/√s or more")?;
        require((0.0..1.0).contains(&self.anew_share), "anew_share", self.anew_share, "a share from 0 to below 1")?;
        require(zero_or_more(self.edge_loss), "edge_loss", self.edge_loss, "0 or more")?;
        require(positive(self.blob_sd_m), "blob_sd_m", self.blob_sd_m, "a positive length in metres")?;
        require(positive(self.blob_reach), "blob_reach", self.blob_reach, "a positive number")?;
        require(positive(self.gate_m), "gate_m", self.gate_m, "a positive length in metres")?;
        require(zero_or_more(self.skin_loss), "skin_loss", self.skin_loss, "0 or more")?;
        require(zero_or_more(self.foreground_loss), "foreground_loss", self.foreground_loss, "0 or more")?;
        require(zero_or_more(self.effort_loss), "effort_loss", self.effort_loss, "0 or more")?;
        require(positive(self.region_reach_m), "region_reach_m", self.region_reach_m, "a positive length in metres")?;
        let KeypointLook { inflation, reach } = self.keypoints;
        require(positive(inflation), "keypoint_inflation", inflation, "a positive number")?;
        require(positive(reach), "keypoint_reach", reach, "a positive number")?;
        let inflation = self.orientation_inflation;
        require(positive(inflation), "orientation_inflation", inflation, "a positive number")?;
        require((0.0..=1.0).contains(&self.balance), "balance", self.balance, "a share from 0 to 1")?;
        self.unseen.check()?;
        self.smoothing.iter().try_for_each(Momentum::check)?;
        if self.layers.is_empty() {
            return Err(Error::Size { name: "layers", got: 0, unit: "layers", expected: 1 });
        }
        self.layers.iter().try_for_each(BodyLayer::check)
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

    /// What a layer weighs particles by, of what a frame shows.
    pub(super) fn weighing<'a>(&'a self, layer: &'a BodyLayer, frame: &Frame<'a>) -> Weighing<'a> {
        let (bounds, cues): (Vec<_>, Vec<_>) = layer.cues.iter().partition(|cue| BOUNDS.contains(cue));
        let boxed = |names: Vec<&CueName>| names.into_iter().filter_map(|cue| self.cue(*cue, layer, frame)).collect();
        let (figure, projection, blend) = (frame.figure, frame.projection, layer.blend);
        Weighing { figure, projection, cues: boxed(cues), bounds: boxed(bounds), blend }
    }

    /// Its cues for a layer, where a frame has what they need.
    pub(super) fn cues_of<'a>(
        &'a self,
        layer: &'a BodyLayer,
        frame: &Frame<'a>,
    ) -> impl Iterator<Item = Box<dyn Cue + 'a>> {
        layer.cues.iter().filter_map(|cue| self.cue(*cue, layer, frame))
    }

    /// A cue of that name, where the frame has what it needs.
    fn cue<'a>(&'a self, name: CueName, layer: &'a BodyLayer, frame: &Frame<'a>) -> Option<Box<dyn Cue + 'a>> {
        let (groups, picture) = (layer.mover.groups.as_slice(), frame.picture);
        let is_rescaled = matches!(layer.blend, Blend::Rescaled { .. });
        Some(match name {
            CueName::Edges => {
                let loss = if is_rescaled { 1.0 } else { self.edge_loss };
                Box::new(Outline { edges: picture.edges.as_ref()?, groups, loss })
            }
            CueName::Blobs => {
                let spread = Scale::Spread { sd_m: self.blob_sd_m, reach: self.blob_reach };
                let scale = if is_rescaled { Scale::Pixels } else { spread };
                Box::new(BlobDistance { blobs: frame.blobs, groups, scale })
            }
            CueName::Regions => {
                let Self { skin_loss, foreground_loss, region_reach_m: reach_m, .. } = *self;
                let (skin, foreground) = (picture.skin.as_ref(), picture.foreground.as_ref());
                let look = RegionLook { skin_loss, foreground_loss, reach_m, bare: frame.bare };
                Box::new(Regions { skin, foreground, groups, look })
            }
            CueName::Keypoints => {
                let look = self.keypoints;
                Box::new(KeypointDistance { person: frame.person?, groups, look })
            }
            CueName::Orientation if frame.orientations.is_empty() => return None,
            CueName::Orientation => {
                let (orientations, inflation) = (frame.orientations, self.orientation_inflation);
                Box::new(OrientationDistance { orientations, groups, inflation })
            }
            CueName::Effort => Box::new(Effort { groups, loss: self.effort_loss }),
            CueName::Limits => Box::new(Limits),
            CueName::Penetration => Box::new(Penetration),
        })
    }
}
