//! The online tracker: predict at every IMU sample, update at every camera frame.

use super::colour::sightings;
use super::ekf::{ArmGaussian, Correction};
use super::mixture::ArmMixture;
use super::particle::{ArmLayer, ArmParticles, Frame};
use super::pause::{BLIND_S, NO_FRAME_S, Stretch as Reachable};
use super::plausible::{Judged, PATIENCE_S, Plausibility, UNKNOWN};
use super::setup::Setup;
use super::smooth::{Kept, Memory, Recorded};
use super::state::{Arm, Estimate, Noise, View, require_finite};
use super::timeline::Timeline;
use crate::error::require;
use crate::filter::{Gaussian, Recorder, Resampling};
use crate::particles::ParticleSet;
use crate::quaternion::Quaternion;
use crate::{Error, Result, saved};
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// One IMU sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Recording time, s.
    pub time_s: f64,
    /// Specific force in the sensor frame, m/s²; at rest, z up, `(0, 0, 9.81)`.
    pub acceleration: Vector3<f64>,
    /// Sensor to world.
    pub world_sensor: Quaternion,
    /// Turn rate in the sensor frame, rad/s, where there is a gyroscope.
    pub turn_rate: Option<Vector3<f64>>,
}

/// How the arm is tracked.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// A list of layers on a particle set.
    Particles {
        /// Applied in order at every frame.
        layers: Vec<ArmLayer>,
        /// How many particles.
        len: usize,
        /// After each layer.
        resampling: Resampling,
    },
    /// A Gaussian and a list of corrections; none of them is inertial only.
    Gaussian {
        /// Applied in order at every frame.
        corrections: Vec<Correction>,
    },
    /// A mixture of Gaussians over the state of a worn sensor, corrected by the patch and by what is named besides.
    Mixture {
        /// `ArmLength`, `Rest`.
        corrections: Vec<Correction>,
        /// Components that are kept.
        components: usize,
    },
    /// The same, its frames kept, so that they can be smoothed ([`ArmTracker::smoothed`]).
    Smoother {
        /// As those of the mixture.
        corrections: Vec<Correction>,
        /// As those of the mixture.
        components: usize,
        /// How well lengths and cameras are known; of as many cameras as there are.
        setup: Option<Setup>,
    },
}

/// What [`ArmTracker::run`] made of a stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// One a frame, up to where it stopped.
    pub estimates: Vec<Estimate>,
    /// How many samples were used.
    pub used: usize,
    /// Why it stopped early, if it did: [`Error::AtFrame`] around what `predict` or `update` said.
    pub stopped: Option<Error>,
}

/// Follows one arm. Clone or [`ArmTracker::save`] it to resume later with the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmTracker {
    arm: Arm,
    noise: Noise,
    views: Vec<View>,
    timeline: Timeline,
    filter: Filter,
    last_world_sensor: Option<Quaternion>,
    last_frame_s: Option<f64>,
    lost_at_s: Option<f64>,
    plausibility: Plausibility,
    /// For how long since the last sighting the IMU has said nothing, s.
    blind_s: f64,
    /// Nothing is known until the patch is seen again.
    is_unknown: bool,
    restarts: u64,
    /// What every frame brought, where it is kept.
    kept: Option<Memory>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Filter {
    Particles(ArmParticles),
    Gaussian(ArmGaussian),
    Mixture(ArmMixture),
}

impl ArmTracker {
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
            Method::Particles { layers, len, resampling } => {
                Filter::Particles(ArmParticles::new(&arm, &noise, layers, len, resampling, seed)?)
            }
            Method::Gaussian { corrections } => Filter::Gaussian(ArmGaussian::new(&arm, &noise, corrections)?),
            Method::Mixture { corrections, components } | Method::Smoother { corrections, components, .. } => {
                require((1..=100).contains(&components), "components", components as f64, "1 to 100")?;
                // Its motion mixes both (`worn::CORE`).
                require(noise.bias.is_some(), "bias", f64::NAN, "estimated, by a mixture")?;
                require(noise.tilt.is_some(), "tilt", f64::NAN, "estimated, by a mixture")?;
                let by = |correction| corrections.contains(&correction);
                let (is_held, is_rested) = (by(Correction::ArmLength), by(Correction::Rest));
                Filter::Mixture(ArmMixture::new(&arm, &noise, is_held, is_rested, components))
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
            last_frame_s: None,
            lost_at_s: None,
            plausibility: Plausibility::new(),
            blind_s: 0.0,
            is_unknown: false,
            restarts: 0,
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
    /// [`Error::Late`], [`Error::NotFinite`], [`Error::QuaternionNorm`]; the tracker is then as before.
    pub fn predict(&mut self, sample: &Sample) -> Result<()> {
        self.timeline.take(sample, &self.noise)?;
        if let Some(kept) = &mut self.kept {
            kept.samples.push(*sample);
        }
        Ok(())
    }

    /// Take a camera frame: where each camera saw the patch, `None` where it did not.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of pixels than cameras, [`Error::NoInertialSample`], [`Error::Late`],
    /// [`Error::NotFinite`], [`Error::AllWeightsZero`], [`Error::Singular`], [`Error::RanAway`], [`Error::Implausible`]; after
    /// one of these four the tracker is lost, and every further update says so ([`Error::Lost`]).
    pub fn update(&mut self, time_s: f64, pixels: &[Option<Vector2<f64>>]) -> Result<Estimate> {
        self.update_recorded(time_s, pixels, None)
    }

    /// The same, showing `recorder` every layer (particle methods only).
    ///
    /// # Errors
    /// As [`ArmTracker::update`].
    pub fn update_recorded(
        &mut self,
        time_s: f64,
        pixels: &[Option<Vector2<f64>>],
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Estimate> {
        if pixels.len() != self.views.len() {
            return Err(Error::Size { name: "pixels", got: pixels.len(), unit: "cameras", expected: self.views.len() });
        }
        for pixel in pixels.iter().flatten() {
            require_finite("pixel", time_s, pixel.as_slice())?;
        }
        if let Some(lost_at_s) = self.lost_at_s {
            return Err(Error::Lost { time_s, lost_at_s });
        }
        if let Some(latest_s) = self.last_frame_s.filter(|last| time_s <= *last) {
            return Err(Error::Late { what: "frame", time_s, latest_s });
        }
        self.timeline.reach_frame(time_s, &self.noise)?;
        if self.last_world_sensor.is_none() {
            // The start is the wrist at the first frame: what the IMU did before moves nothing.
            self.timeline.clear_pending();
        }
        let world_sensor = self.timeline.world_sensor(&self.noise);
        self.notice_pause(time_s, world_sensor, pixels);
        let frame = Frame {
            time_s,
            motion: self.timeline.pending().clone(),
            worn: self.timeline.worn().cloned(),
            last_world_sensor: self.last_world_sensor.unwrap_or(world_sensor),
            world_sensor,
            acceleration: self.timeline.acceleration(&self.noise),
            stale_s: self.timeline.stale_s(&self.noise),
            is_rest: self.timeline.is_rest(&self.noise),
            sightings: sightings(&self.views, pixels),
        };
        let start = self.start_to_keep();
        // Until it is known that all went well: a filter that failed half-way must not be used again.
        self.lost_at_s = Some(time_s);
        let mut estimate = match &mut self.filter {
            Filter::Particles(filter) => filter.update(&self.arm, &self.noise, &frame, recorder),
            Filter::Gaussian(filter) => filter.update(&self.arm, &self.noise, &frame),
            Filter::Mixture(filter) => filter.update(&self.arm, &self.noise, &frame),
        }?;
        if !estimate.is_finite() {
            return Err(Error::RanAway { time_s });
        }
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
            kept.frames.push(Kept { time_s, world_sensor, pixels, is_unknown, start, means });
        }
        self.lost_at_s = None;
        self.last_world_sensor = Some(world_sensor);
        self.last_frame_s = Some(time_s);
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
    pub fn smoothed(&self, first: usize) -> Result<Vec<Estimate>> {
        match (&self.kept, &self.filter) {
            (Some(Memory { frames, samples, setup }), Filter::Mixture(filter)) => {
                let Self { arm, noise, views, .. } = self;
                Recorded { arm, noise, views, filter, frames, samples, setup: *setup }.estimates(first)
            }
            _ => Ok(Vec::new()),
        }
    }

    /// After a pause the state is not known: start again where the patch is seen, as far as the arm reaches.
    fn notice_pause(&mut self, time_s: f64, world_sensor: Quaternion, pixels: &[Option<Vector2<f64>>]) {
        self.blind_s += self.timeline.pending_gap_s();
        let waited_s = self.last_frame_s.map_or(0.0, |last| time_s - last);
        self.is_unknown |= self.blind_s > BLIND_S || waited_s > NO_FRAME_S;
        let Some(sighting) = sightings(&self.views, pixels).into_iter().next() else { return };
        self.blind_s = 0.0;
        let sees_patch = match &self.filter {
            Filter::Particles(filter) => filter.sees_patch(),
            Filter::Gaussian(filter) => filter.sees_patch(),
            Filter::Mixture(_) => true,
        };
        if !std::mem::take(&mut self.is_unknown) || !sees_patch {
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
        self.last_world_sensor = None;
        self.timeline.clear_pending();
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
        if estimate.is_finite() { Ok(estimate) } else { Err(Error::RanAway { time_s }) }
    }

    /// A stretch of a recording: samples and frames, each in order of time, merged; a sample at a frame's own
    /// time counts for it, samples after the last frame are left for the next stretch. `first_frame` numbers
    /// the frames of messages.
    pub fn run(
        &mut self,
        samples: &[Sample],
        frames: &[(f64, Vec<Option<Vector2<f64>>>)],
        first_frame: usize,
    ) -> Stretch {
        let mut stretch = Stretch { estimates: Vec::with_capacity(frames.len()), used: 0, stopped: None };
        for (index, (time_s, pixels)) in frames.iter().enumerate() {
            let estimate = self.take_until(&samples[stretch.used..], *time_s).and_then(|taken| {
                stretch.used += taken;
                self.update(*time_s, pixels)
            });
            match estimate {
                Ok(estimate) => stretch.estimates.push(estimate),
                Err(error) => {
                    stretch.stopped = Some(Error::AtFrame { frame: first_frame + index, source: Box::new(error) });
                    break;
                }
            }
        }
        stretch
    }

    /// Take the samples up to `time_s`; how many those are.
    fn take_until(&mut self, samples: &[Sample], time_s: f64) -> Result<usize> {
        // A time that is no number, or jumps ahead of its successor, must be met, not waited for.
        let is_due = |i: usize| {
            let next = samples.get(i + 1).map_or(f64::INFINITY, |next| next.time_s);
            samples[i].time_s <= time_s || samples[i].time_s.is_nan() || samples[i].time_s >= next
        };
        let due = (0..samples.len()).take_while(|i| is_due(*i)).count();
        samples[..due].iter().try_for_each(|sample| self.predict(sample))?;
        Ok(due)
    }

    /// The whole tracker as bytes, for [`ArmTracker::restore`] by the same version.
    ///
    /// # Errors
    /// [`Error::SavedState`] when memory runs out.
    pub fn save(&self) -> Result<Vec<u8>> {
        saved::to_bytes("arm", self)
    }

    /// From [`ArmTracker::save`].
    ///
    /// # Errors
    /// [`Error::SavedState`], [`Error::Parameter`].
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        let tracker: Self = saved::from_bytes("arm", bytes)?;
        tracker.arm.check()?;
        tracker.noise.check()?;
        Ok(tracker)
    }
}
