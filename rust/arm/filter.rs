//! The arm as a tracker's subject: the motion of every IMU sample is composed, every camera frame updates one of the filters.

use super::alike::{Alike, Taken, UNLIKE};
use super::cues::landmark::{Landmark, SAME_FRAME_S};
use super::cues::upper_arm::{Direction, direction_at};
use super::ekf::ArmGaussian;
use super::frame::Frame;
use super::incoming::Incoming;
use super::memory::{Kept, Memory};
use super::method::Method;
use super::mixture::ArmMixture;
use super::particle::ArmParticles;
use super::pause::{BLIND_S, NO_FRAME_S, Stretch as Reachable};
use super::plausible::{Judged, PATIENCE_S, Plausibility, UNKNOWN};
use super::posed::sightings;
use super::setup::Setup;
use super::smooth::Recorded;
use super::state::{Arm, Layout, Noise, POSITION, View, WRIST, require_finite};
use super::timeline::Timeline;
use crate::error::{require, require_time};
use crate::estimate::Estimate;
use crate::filter::{Gaussian, Recorder};
use crate::observation::Sample;
use crate::particles::ParticleSet;
use crate::quaternion::Quaternion;
use crate::smoothing::Windowed;
use crate::{Error, Result};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// One of the filters, over the state of one arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmFilter {
    arm: Arm,
    noise: Noise,
    views: Vec<View>,
    timeline: Timeline,
    filter: Filter,
    last_world_sensor: Option<Quaternion>,
    plausibility: Plausibility,
    alike: Alike,
    /// For how long since the last sighting the IMU has said nothing, s.
    blind_s: f64,
    /// Nothing is known until the patch is seen again.
    is_unknown: bool,
    restarts: u64,
    /// Joints seen since the last frame: when, and where.
    landmarks: Vec<(f64, Landmark)>,
    /// Where the upper arm points: by the last two samples of its sensor, or by all of them where frames are kept.
    directions: Vec<Direction>,
    incoming: Incoming,
    /// What every frame brought, where it is kept.
    kept: Option<Memory>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Filter {
    Particles(Box<ArmParticles>),
    Gaussian(ArmGaussian),
    Mixture(ArmMixture),
}

impl ArmFilter {
    /// Ready for its first sample.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Size`] for what is out of range.
    pub fn new(arm: Arm, views: Vec<View>, noise: Noise, method: Method, seed: u64) -> Result<Self> {
        arm.check()?;
        noise.check()?;
        let kept = match &method {
            Method::Smoother { setup, .. } => {
                let setup = setup.map(|setup| Setup { cameras: views.len(), ..setup });
                setup.iter().try_for_each(Setup::check)?;
                Some(Memory { setup, ..Memory::default() })
            }
            _ => None,
        };
        let filter = match method {
            Method::Particles { layers, particles, resampling } => {
                let filter = ArmParticles::new(&arm, &noise, layers, particles, resampling, seed)?;
                Filter::Particles(Box::new(filter))
            }
            Method::Gaussian { corrections } => Filter::Gaussian(ArmGaussian::new(&arm, &noise, corrections)?),
            Method::Mixture { corrections, components } | Method::Smoother { corrections, components, .. } => {
                require((1..=100).contains(&components), "components", components as f64, "1 to 100")?;
                // Its motion mixes both (`worn::CORE`).
                require(noise.bias.is_some(), "bias", f64::NAN, "estimated, by a mixture")?;
                require(noise.tilt.is_some(), "tilt", f64::NAN, "estimated, by a mixture")?;
                Filter::Mixture(ArmMixture::new(&arm, &noise, &corrections, components))
            }
        };
        let is_worn = matches!(filter, Filter::Mixture(_));
        Ok(Self {
            arm,
            noise,
            views,
            timeline: Timeline::new(is_worn),
            filter,
            last_world_sensor: None,
            plausibility: Plausibility::new(),
            alike: Alike::default(),
            blind_s: 0.0,
            is_unknown: false,
            restarts: 0,
            landmarks: Vec::new(),
            directions: Vec::new(),
            incoming: Incoming::new(),
            kept,
        })
    }

    /// How many cameras.
    pub fn cameras(&self) -> usize {
        self.views.len()
    }

    /// The particles as they stand; none for a Gaussian method.
    pub fn particles(&self) -> Option<&ParticleSet> {
        match &self.filter {
            Filter::Particles(filter) => Some(filter.particles()),
            Filter::Gaussian(_) | Filter::Mixture(_) => None,
        }
    }

    /// Take an IMU sample.
    ///
    /// # Errors
    /// [`Error::Late`], [`Error::NotFinite`], [`Error::QuaternionNorm`]; the filter is then as before.
    pub fn take(&mut self, sample: &Sample) -> Result<()> {
        self.timeline.take(sample, &self.noise)?;
        self.incoming.take(sample);
        if let Some(kept) = &mut self.kept {
            kept.samples.push(*sample);
        }
        Ok(())
    }

    /// An IMU sample was refused.
    pub fn miss(&mut self, time_s: f64) {
        self.incoming.miss(time_s);
    }

    /// Take where a camera saw a joint, of the frame that comes next.
    ///
    /// # Errors
    /// [`Error::Late`]; the filter is then as before.
    pub fn take_landmark(&mut self, time_s: f64, landmark: Landmark) -> Result<()> {
        require_time("time of a landmark", time_s)?;
        let latest_s = self.landmarks.last().map_or(self.timeline.now_s(), |last| last.0);
        if time_s < latest_s {
            return Err(Error::Late { what: "landmark", time_s, latest_s });
        }
        // Twice in a frame is once.
        let is_same = |seen: &Landmark| (seen.joint, seen.camera) == (landmark.joint, landmark.camera);
        self.landmarks.retain(|(seen_s, seen)| time_s - seen_s > SAME_FRAME_S || !is_same(seen));
        self.landmarks.push((time_s, landmark));
        Ok(())
    }

    /// Take where the upper arm points, by its sensor.
    ///
    /// # Errors
    /// [`Error::Late`], [`Error::NotFinite`], [`Error::Parameter`]; the filter is then as before.
    pub fn take_direction(&mut self, direction: Direction) -> Result<()> {
        let time_s = direction.time_s;
        require_time("time of an orientation", time_s)?;
        require_finite("orientation", time_s, direction.to_shoulder.as_slice())?;
        require(
            direction.sd > 0.0 && direction.sd <= 1e3,
            "spread of an orientation",
            direction.sd,
            "a positive angle",
        )?;
        if let Some(last) = self.directions.last().filter(|last| time_s <= last.time_s) {
            return Err(Error::Late { what: "orientation", time_s, latest_s: last.time_s });
        }
        if self.kept.is_none() && self.directions.len() > 1 {
            self.directions.remove(0);
        }
        self.directions.push(direction);
        Ok(())
    }

    /// Check where each camera saw the patch.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of pixels than cameras, [`Error::NotFinite`].
    pub fn check(&self, time_s: f64, pixels: &[Option<Vector2<f64>>]) -> Result<()> {
        if pixels.len() != self.views.len() {
            return Err(Error::Size { name: "pixels", got: pixels.len(), unit: "cameras", expected: self.views.len() });
        }
        pixels.iter().flatten().try_for_each(|pixel| require_finite("pixel", time_s, pixel.as_slice()))
    }

    /// Take a camera frame that was checked, `elapsed_s` after the last: where each camera saw the patch, `None` where it
    /// did not. `recorder` sees every layer of a particle method.
    ///
    /// # Errors
    /// [`Error::NoInertialSample`], [`Error::Late`], after which it is as before; [`Error::AllWeightsZero`],
    /// [`Error::Singular`], [`Error::RanAway`], [`Error::Implausible`], after which it must not be used again.
    pub fn update(
        &mut self,
        time_s: f64,
        elapsed_s: f64,
        pixels: &[Option<Vector2<f64>>],
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Estimate> {
        self.timeline.reach_frame(time_s, &self.noise)?;
        if self.last_world_sensor.is_none() {
            // The start is the wrist at the first frame: what the IMU did before moves nothing.
            self.timeline.clear_pending();
        }
        let world_sensor = self.timeline.world_sensor(&self.noise);
        self.notice_pause(elapsed_s, world_sensor, pixels);
        let is_of = |seen_s: f64| (time_s - seen_s).abs() <= SAME_FRAME_S;
        let landmarks: Vec<Landmark> =
            self.landmarks.iter().filter(|(seen_s, _)| is_of(*seen_s)).map(|(_, landmark)| *landmark).collect();
        self.landmarks.retain(|(seen_s, _)| *seen_s > time_s && !is_of(*seen_s));
        let frame = Frame {
            time_s,
            motion: self.timeline.pending().clone(),
            worn: self.timeline.worn().cloned(),
            last_world_sensor: self.last_world_sensor.unwrap_or(world_sensor),
            world_sensor,
            acceleration: self.timeline.acceleration(&self.noise),
            stale_s: self.timeline.stale_s(&self.noise),
            rest: self.timeline.is_rest(&self.noise).then_some(0.0),
            sightings: sightings(&self.views, pixels),
            landmarks: landmarks.iter().map(|landmark| landmark.seen_by(&self.views)).collect(),
            upper_arm: direction_at(&self.directions, time_s),
        };
        let start = self.start_to_keep();
        let estimate = match &mut self.filter {
            Filter::Particles(filter) => filter.update(&self.arm, &self.noise, &frame, recorder),
            Filter::Gaussian(filter) => filter.update(&self.arm, &self.noise, &frame),
            Filter::Mixture(filter) => filter.update(&self.arm, &self.noise, &frame),
        }?;
        let mut estimate = estimate.checked()?;
        let judged = Judged { arm: &self.arm, noise: &self.noise, sightings: &frame.sightings, world_sensor };
        estimate.doubt = self.plausibility.doubt(&estimate, &judged);
        let lasted_s = self.plausibility.beyond_s();
        if let Some(why) = estimate.doubt.filter(|_| lasted_s > PATIENCE_S && self.is_held_by_arm()) {
            return Err(Error::Implausible { time_s, why, lasted_s });
        }
        if self.is_unknown {
            estimate.doubt = Some(UNKNOWN);
        }
        if let (Some(kept), Filter::Mixture(filter)) = (&mut self.kept, &self.filter) {
            let (pixels, is_unknown, means) = (pixels.to_vec(), self.is_unknown, filter.means());
            let filtered = estimate.doubt.is_none().then(|| estimate.places.clone());
            kept.frames.push(Kept { time_s, world_sensor, pixels, landmarks, is_unknown, start, means, filtered });
        }
        // What is kept was judged by the arm and the picture alone: a smoother sees what comes later.
        self.incoming.look(time_s, elapsed_s, !frame.sightings.is_empty());
        self.alike.take(&Taken {
            time_s,
            motion: &frame.motion,
            gap_s: self.timeline.pending_gap_s(),
            acceleration: frame.acceleration,
            world_sensor,
            sightings: &frame.sightings,
            wrist: estimate.places[WRIST].mean,
        });
        let unlike = (self.sees_patch() && self.alike.is_otherwise()).then_some(UNLIKE);
        estimate.doubt = estimate.doubt.or(self.incoming.doubt(self.sees_patch())).or(unlike);
        self.last_world_sensor = Some(world_sensor);
        self.timeline.clear_pending();
        Ok(estimate)
    }

    /// What is known before the frame that the track starts at, where frames are kept.
    fn start_to_keep(&self) -> Option<Gaussian> {
        match &self.filter {
            Filter::Mixture(filter) if self.kept.is_some() && self.last_world_sensor.is_none() => {
                Some(filter.as_gaussian())
            }
            _ => None,
        }
    }

    /// Frames so far, from number `first` on, each given those about it: as many as are smoothed together; none beyond the
    /// last, or where frames are not kept.
    ///
    /// # Errors
    /// [`Error::Singular`], [`Error::RanAway`] where no trajectory is found.
    pub(crate) fn smoothed(&self, first: usize) -> Result<Windowed> {
        match (&self.kept, &self.filter) {
            (Some(Memory { frames, samples, setup }), Filter::Mixture(filter)) => {
                let Self { arm, noise, views, directions, .. } = self;
                let setup = *setup;
                Recorded { arm, noise, views, filter, frames, samples, directions, setup }.window(first)
            }
            _ => Ok(Windowed::default()),
        }
    }

    /// After a pause the state is not known: start again where the patch is seen, as far as the arm reaches.
    fn notice_pause(&mut self, elapsed_s: f64, world_sensor: Quaternion, pixels: &[Option<Vector2<f64>>]) {
        self.blind_s += self.timeline.pending_gap_s();
        self.is_unknown |= self.blind_s > BLIND_S || elapsed_s > NO_FRAME_S;
        let Some(sighting) = sightings(&self.views, pixels).into_iter().next() else { return };
        self.blind_s = 0.0;
        if !std::mem::take(&mut self.is_unknown) || !self.sees_patch() {
            return;
        }
        self.restarts += 1;
        let glued = world_sensor.rotate(sighting.view.patch_offset);
        let stretch = Reachable::within_reach(&self.arm, &self.noise, &sighting, glued);
        match &mut self.filter {
            Filter::Particles(filter) => filter.start_again(&self.arm, &self.noise, &stretch, self.restarts),
            Filter::Gaussian(filter) => filter.start_again(&self.arm, &self.noise, &stretch),
            Filter::Mixture(filter) => filter.start_again(&self.arm, &self.noise, &stretch),
        }
        self.plausibility = Plausibility::new();
        self.alike = Alike::default();
        self.last_world_sensor = None;
        self.timeline.clear_pending();
    }

    /// Whether the patch says anything to it.
    fn sees_patch(&self) -> bool {
        match &self.filter {
            Filter::Particles(filter) => filter.sees_patch(),
            Filter::Gaussian(filter) => filter.sees_patch(),
            Filter::Mixture(_) => true,
        }
    }

    /// Whether the arm's length holds the estimate: only then is one beyond its reach a track that was lost.
    fn is_held_by_arm(&self) -> bool {
        match &self.filter {
            Filter::Particles(filter) => filter.is_held_by_arm(),
            Filter::Gaussian(filter) => filter.is_held_by_arm(),
            Filter::Mixture(filter) => filter.is_held_by_arm(),
        }
    }

    /// What is known at `time_s`, between frames; draws nothing and changes nothing.
    ///
    /// # Errors
    /// [`Error::NoInertialSample`], [`Error::Late`], [`Error::RanAway`].
    pub fn estimate(&self, time_s: f64) -> Result<Estimate> {
        let mut timeline = self.timeline.clone();
        timeline.reach_frame(time_s, &self.noise)?;
        if self.last_world_sensor.is_none() {
            timeline.clear_pending();
        }
        let (motion, world_sensor) = (timeline.pending(), timeline.world_sensor(&self.noise));
        let estimate = match &self.filter {
            Filter::Particles(filter) => filter.estimate(&self.arm, &self.noise, time_s, motion, world_sensor),
            Filter::Gaussian(filter) => filter.estimate(&self.arm, &self.noise, time_s, motion, world_sensor),
            Filter::Mixture(filter) => {
                let acceleration = timeline.acceleration(&self.noise);
                let frame = Frame { acceleration, ..Frame::empty(time_s, world_sensor) };
                filter.estimate(&self.arm, &self.noise, timeline.worn(), &frame)
            }
        };
        estimate.checked()
    }

    /// Wrist and elbow `(N, 6)` of states `(N, D)`, the forearm as at the last frame.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of columns than its state has.
    pub fn pose(&self, states: &ParticleSet) -> Result<ParticleSet> {
        let (got, expected) = (states.dim(), Layout::new(&self.noise).dim);
        if got != expected {
            return Err(Error::Size { name: "states", got, unit: "columns", expected });
        }
        let last = self.last_world_sensor.unwrap_or_else(Quaternion::identity);
        let forearm = last.rotate(self.arm.elbow_in_sensor());
        Ok(states.mapped(6, |block, out| {
            for d in 0..3 {
                out.column_mut(d).copy_from_slice(block.column(POSITION + d));
                for (elbow, wrist) in out.column_mut(3 + d).iter_mut().zip(block.column(POSITION + d)) {
                    *elbow = wrist + forearm[d];
                }
            }
        }))
    }

    /// Check what was read back.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check_parameters(&self) -> Result<()> {
        self.arm.check()?;
        self.noise.check()
    }
}
