//! The online tracker of the body: an image's evidence in, a pose with error bars out.

use super::cues::keypoints::Person;
use super::cues::orientation::Orientation;
use super::cues::region::{Region, bareness};
use super::edges::EdgeImage;
use super::figure::Figure;
use super::island::{Island, Posterior, Sight, most_given};
use super::method::BodyMethod;
use super::skin::Blobs;
use crate::error::{require, require_time};
use crate::filter::Recorder;
use crate::particles::{ParticleSet, Summary};
use crate::projection::Projection;
use crate::rng::branch;
use crate::{Error, Result, saved};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// No picture is larger, px.
const MOST_PX: f64 = 1e6;
/// No angle is less known.
const MOST_RAD: f64 = 10.0;

/// What a frame shows.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyEvidence {
    /// Detected edges.
    pub edges: EdgeImage,
    /// Centres of skin-coloured blobs, px, in no order.
    pub blobs: Vec<[f64; 2]>,
    /// Skin as a region, where it is given.
    pub skin: Option<Region>,
    /// The person as a region, where it is given.
    pub foreground: Option<Region>,
    /// Keypoints of every person that a detector found.
    pub keypoints: Vec<Person>,
    /// What inertial sensors say of the segments that wear them.
    pub orientations: Vec<Orientation>,
}

impl BodyEvidence {
    /// Edges, and nothing else yet.
    pub fn new(edges: EdgeImage) -> Self {
        let (blobs, keypoints, orientations) = (Vec::new(), Vec::new(), Vec::new());
        Self { edges, blobs, skin: None, foreground: None, keypoints, orientations }
    }

    fn check(&self, time_s: f64) -> Result<()> {
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
        for worn in &self.orientations {
            if let Some(odd) = worn.q_world_segment.coords.iter().find(|x| !x.is_finite()) {
                return Err(Error::NotFinite { name: "orientation", time_s, value: *odd });
            }
            require(worn.sd > 0.0 && worn.sd <= MOST_RAD, "spread of an orientation", worn.sd, "a positive angle")?;
            require(worn.roll_sd > 0.0, "spread of a roll", worn.roll_sd, "a positive angle, or infinite")?;
        }
        Ok(())
    }
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
    /// How bare the forearms are, told at the first frame that shows skin.
    bare: Option<f64>,
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
        Ok(Self {
            figure,
            projection,
            method,
            islands,
            first_frame_s: None,
            last_frame_s: None,
            lost_at_s: None,
            bare: None,
        })
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
        require_time("frame time", time_s)?;
        evidence.check(time_s)?;
        if let Some(lost_at_s) = self.lost_at_s {
            return Err(Error::Lost { time_s, lost_at_s });
        }
        if let Some(latest_s) = self.last_frame_s.filter(|last| time_s <= *last) {
            return Err(Error::Late { what: "frame", time_s, latest_s });
        }
        let elapsed_s = self.last_frame_s.map_or(0.0, |last| time_s - last);
        if let (None, Some(skin)) = (self.bare, &evidence.skin) {
            self.bare = Some(bareness(skin, &self.figure.seen(&self.projection, &self.figure.model.start())));
        }
        let bare = self.bare.unwrap_or(1.0);
        let Self { figure, projection, method, islands, .. } = self;
        let sight = Sight { figure, projection, method, evidence, time_s, elapsed_s, bare };
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
        let mut joints = joints.summary(joints.dim());
        let since_s = self.first_frame_s.map_or(0.0, |first| time_s - first);
        self.method.unseen.add(&mut joints, &self.projection, since_s);
        BodyEstimate {
            time_s,
            state: together.summary(together.dim()),
            joints,
            blobs: most_given(posteriors),
            ess: together.ess(),
        }
    }

    /// The whole tracker as bytes, for [`BodyTracker::restore`] by the same version.
    ///
    /// # Errors
    /// [`Error::SavedState`] when memory runs out.
    pub fn save(&self) -> Result<Vec<u8>> {
        saved::to_bytes("body", self)
    }

    /// From [`BodyTracker::save`].
    ///
    /// # Errors
    /// [`Error::SavedState`], [`Error::Parameter`].
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        let tracker: Self = saved::from_bytes("body", bytes)?;
        tracker.method.check()?;
        Ok(tracker)
    }
}
