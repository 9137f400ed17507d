//! The cues of the body, by name: what weighs particles and where smooth pulls trajectories. A cue is one file, and a line of
//! each list here:
//!
//! | file | weighs |
//! |---|---|
//! | [`outline`] | outlines of the parts against detected edges (Li & Kulić eq. 4) |
//! | [`blobs`] | head and hands against centres of skin (the paper's distance cue) |
//! | [`region`] | skin and foreground as regions |
//! | [`keypoints`] | joints against a detector's points in the picture |
//! | [`orientation`] | upper arms and forearms against inertial sensors |
//! | [`effort`] | upper arms against gravity |
//! | [`posture`] | arms against how people hold them |
//! | [`limits`] | angles against the limits of joints |
//! | [`penetration`] | elbows and hands against the torso (paper IV-C1) |

pub mod blobs;
pub mod effort;
pub mod keypoints;
pub mod limits;
pub mod orientation;
pub mod outline;
pub mod penetration;
pub mod posture;
mod posture_table;
pub mod region;

use self::blobs::{BlobDistance, BlobParameters, Scale};
use self::effort::{Effort, EffortParameters};
use self::keypoints::{KeypointDistance, KeypointParameters, Person};
use self::limits::Limits;
use self::orientation::{Orientation, OrientationDistance, OrientationParameters};
use self::outline::{Outline, OutlineParameters};
use self::penetration::Penetration;
use self::posture::{Posture, PostureParameters};
use self::region::{Region, RegionParameters, Regions};
use super::edges::EdgeImage;
use super::figure::Figure;
use super::joints::Group;
use super::skin::Blobs;
use super::smaller::Smaller;
use super::weighing::Cue;
use crate::error::{require_pixel, require_time};
use crate::parameters::Parameters;
use crate::projection::Projection;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// What a layer weighs by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CueName {
    /// [`outline`].
    Edges,
    /// [`blobs`].
    Blobs,
    /// [`region`].
    Regions,
    /// [`keypoints`].
    Keypoints,
    /// [`orientation`].
    Orientation,
    /// [`effort`].
    Effort,
    /// [`posture`].
    Posture,
    /// [`limits`].
    Limits,
    /// [`penetration`].
    Penetration,
}

impl CueName {
    /// In lower case.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        let known = "edges, blobs, regions, keypoints, orientation, effort, posture, limits, penetration";
        match name {
            "edges" => Ok(Self::Edges),
            "blobs" => Ok(Self::Blobs),
            "regions" => Ok(Self::Regions),
            "keypoints" => Ok(Self::Keypoints),
            "orientation" => Ok(Self::Orientation),
            "effort" => Ok(Self::Effort),
            "posture" => Ok(Self::Posture),
            "limits" => Ok(Self::Limits),
            "penetration" => Ok(Self::Penetration),
            _ => Err(Error::UnknownName { what: "cue", name: name.into(), known }),
        }
    }

    /// The same, of one that is smooth: it can be linearised.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn smooth_from_name(name: &str) -> Result<Self> {
        let known = "keypoints, orientation, effort, posture, limits";
        let cue = Self::from_name(name).ok();
        let smooth = [Self::Keypoints, Self::Orientation, Self::Effort, Self::Posture, Self::Limits];
        cue.filter(|cue| smooth.contains(cue)).ok_or_else(|| Error::UnknownName {
            what: "correction",
            name: name.into(),
            known,
        })
    }
}

/// What a body can do at all, whatever is seen.
pub(super) const BOUNDS: [CueName; 4] = [CueName::Effort, CueName::Posture, CueName::Limits, CueName::Penetration];

/// How much each of them counts, where a method chooses that.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CueParameters {
    /// Of [`outline`].
    pub outline: OutlineParameters,
    /// Of [`blobs`].
    pub blobs: BlobParameters,
    /// Of [`region`].
    pub regions: RegionParameters,
    /// Of [`keypoints`].
    pub keypoints: KeypointParameters,
    /// Of [`orientation`].
    pub orientation: OrientationParameters,
    /// Of [`effort`].
    pub effort: EffortParameters,
    /// Of [`posture`].
    pub posture: PostureParameters,
}

impl CueParameters {
    /// Of a method's parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming one that is missing.
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self {
            outline: OutlineParameters::read(from)?,
            blobs: BlobParameters::read(from)?,
            regions: RegionParameters::read(from)?,
            keypoints: KeypointParameters::read(from)?,
            orientation: OrientationParameters::read(from)?,
            effort: EffortParameters::read(from)?,
            posture: PostureParameters::read(from)?,
        })
    }

    /// Of a method's parameters, which has those of cues that are smooth; it has no others, whose parameters are nothing.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming one that is missing.
    pub fn of_smooth(from: &Parameters) -> Result<Self> {
        Ok(Self {
            outline: OutlineParameters { loss: 0.0 },
            blobs: BlobParameters { sd_m: 1.0, reach: 1.0, gate_m: 1.0 },
            regions: RegionParameters { skin_loss: 0.0, foreground_loss: 0.0, reach_m: 1.0 },
            keypoints: KeypointParameters::read(from)?,
            orientation: OrientationParameters::read(from)?,
            effort: EffortParameters::read(from)?,
            posture: PostureParameters::read(from)?,
        })
    }

    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        self.outline.check()?;
        self.blobs.check()?;
        self.regions.check()?;
        self.keypoints.check()?;
        self.orientation.check()?;
        self.effort.check()?;
        self.posture.check()
    }
}

/// Shape and values of an array of three axes, row by row.
pub type Table = ([usize; 3], Vec<f64>);

/// Arrays by name, as whoever saw a picture holds them; none where it holds none of that name.
pub trait Given {
    /// Of what cannot be read.
    type Error: From<Error>;

    /// Bytes of a picture `(H, W)`, as `made` makes something of its width, height and rows.
    ///
    /// # Errors
    /// What is no such array, and those of `made`.
    fn bytes<T>(
        &self,
        name: &'static str,
        made: impl FnOnce(usize, usize, &[u8]) -> Result<T>,
    ) -> std::result::Result<Option<T>, Self::Error>;

    /// Points `(P, 2)`, px.
    ///
    /// # Errors
    /// What is no such array.
    fn points(&self, name: &'static str) -> std::result::Result<Vec<[f64; 2]>, Self::Error>;

    /// A mask: distance of every pixel `(H, W)` and some points `(P, 2)`, px.
    ///
    /// # Errors
    /// What is no such pair of arrays.
    fn region(&self, name: &'static str) -> std::result::Result<Option<Region>, Self::Error>;

    /// A table of three axes and its shape.
    ///
    /// # Errors
    /// What is no such array.
    fn table(&self, name: &'static str) -> std::result::Result<Option<Table>, Self::Error>;

    /// By how much smaller than the frame the picture was made in which edges, blobs and masks were found.
    ///
    /// # Errors
    /// What is no such number.
    fn smaller(&self, name: &'static str) -> std::result::Result<Smaller, Self::Error>;
}

/// What a camera shows of a body at one frame, and what a detector found in it: the evidence that the cues read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// Detected edges, where there is an image.
    pub edges: Option<EdgeImage>,
    /// Centres of skin-coloured blobs, px, in no order.
    pub blobs: Vec<[f64; 2]>,
    /// Skin as a region, where it is given.
    pub skin: Option<Region>,
    /// The person as a region, where it is given.
    pub foreground: Option<Region>,
    /// Keypoints of every person that a detector found.
    pub keypoints: Vec<Person>,
}

impl Picture {
    /// Edges, and nothing else yet.
    pub fn new(edges: EdgeImage) -> Self {
        Self { edges: Some(edges), ..Self::default() }
    }

    /// Of arrays by name.
    ///
    /// # Errors
    /// What cannot be read, or is no such thing.
    pub fn read<G: Given>(given: &G) -> std::result::Result<Self, G::Error> {
        let smaller = given.smaller("shrunk")?;
        Ok(Self {
            edges: given.bytes("edges", EdgeImage::new)?.map(|edges| edges.of_smaller(smaller)),
            blobs: given.points("blobs")?.into_iter().map(|blob| smaller.in_frame(blob)).collect(),
            skin: given.region("skin_region")?.map(|skin| skin.of_smaller(smaller)),
            foreground: given.region("foreground_region")?.map(|person| person.of_smaller(smaller)),
            keypoints: given.table("keypoints")?.map_or(Ok(Vec::new()), |(shape, of)| keypoints::people(shape, &of))?,
        })
    }

    /// Check every number.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Parameter`].
    pub fn check(&self, time_s: f64) -> Result<()> {
        require_time("frame time", time_s)?;
        self.blobs.iter().try_for_each(|blob| require_pixel("blob", time_s, *blob))?;
        keypoints::check(&self.keypoints, time_s)
    }
}

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

impl<'a> Frame<'a> {
    /// The cue of that name for some groups, where the frame has what it needs; `is_rescaled` asks for distances that a
    /// blend rescales.
    pub fn cue(
        &self,
        name: CueName,
        cue_parameters: &CueParameters,
        groups: &'a [Group],
        is_rescaled: bool,
    ) -> Option<Box<dyn Cue + 'a>> {
        let picture = self.picture;
        Some(match name {
            CueName::Edges => {
                let loss = if is_rescaled { 1.0 } else { cue_parameters.outline.loss };
                Box::new(Outline { edges: picture.edges.as_ref()?, groups, loss })
            }
            CueName::Blobs => {
                let BlobParameters { sd_m, reach, .. } = cue_parameters.blobs;
                let scale = if is_rescaled { Scale::Pixels } else { Scale::Spread { sd_m, reach } };
                Box::new(BlobDistance { blobs: self.blobs, groups, scale })
            }
            CueName::Regions => {
                let (skin, foreground) = (picture.skin.as_ref(), picture.foreground.as_ref());
                Box::new(Regions { skin, foreground, groups, parameters: cue_parameters.regions, bare: self.bare })
            }
            CueName::Keypoints => {
                Box::new(KeypointDistance { person: self.person?, groups, parameters: cue_parameters.keypoints })
            }
            CueName::Orientation if self.orientations.is_empty() => return None,
            CueName::Orientation => Box::new(OrientationDistance {
                orientations: self.orientations,
                groups,
                parameters: cue_parameters.orientation,
            }),
            CueName::Effort => Box::new(Effort { groups, parameters: cue_parameters.effort }),
            CueName::Posture => Box::new(Posture { groups, parameters: cue_parameters.posture }),
            CueName::Limits => Box::new(Limits),
            CueName::Penetration => Box::new(Penetration),
        })
    }
}
