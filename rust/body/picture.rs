//! What a frame shows of a body: the evidence that the cues read.

use super::cues::keypoints::Person;
use super::cues::region::Region;
use super::edges::EdgeImage;
use crate::error::{require, require_time};
use crate::{Error, Result};

/// No picture is larger, px.
const MOST_PX: f64 = 1e6;

/// What a camera shows of a body at one frame, and what a detector found in it.
#[derive(Debug, Clone, PartialEq)]
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
        Self { edges: Some(edges), blobs: Vec::new(), skin: None, foreground: None, keypoints: Vec::new() }
    }

    /// A picture of nothing.
    pub fn empty() -> Self {
        Self { edges: None, blobs: Vec::new(), skin: None, foreground: None, keypoints: Vec::new() }
    }

    /// Check every number.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Parameter`].
    pub fn check(&self, time_s: f64) -> Result<()> {
        require_time("frame time", time_s)?;
        let odd = |x: &f64| x.is_nan() || x.abs() > MOST_PX;
        if let Some(odd) = self.blobs.iter().flatten().find(|x| odd(x)) {
            return Err(Error::NotFinite { name: "blob", time_s, value: *odd });
        }
        for keypoint in self.keypoints.iter().flatten().flatten() {
            if let Some(odd) = keypoint.pixel.iter().find(|x| odd(x)) {
                return Err(Error::NotFinite { name: "keypoint", time_s, value: *odd });
            }
            let sd_px = keypoint.sd_px;
            require((0.0..=MOST_PX).contains(&sd_px), "spread of a keypoint", sd_px, "0 px or more")?;
        }
        Ok(())
    }
}
