//! The one online tracker: observations in, estimates out, for an arm as for a body.
//!
//! Whatever the subject, it is done the same way here: what comes late is put in order within the stated delay and refused
//! beyond it, a frame that is not later than the last is refused, a track that was lost stays lost, and all of it is saved
//! and restored.

use crate::arm::cues::upper_arm::Direction;
use crate::arm::{self, ArmFilter};
use crate::body::cues::orientation::Segment;
use crate::body::{BodyFilter, KEY_JOINTS};
use crate::error::{require, require_time};
use crate::estimate::Estimate;
use crate::filter::Recorder;
use crate::observation::{Observation, What};
use crate::particles::ParticleSet;
use crate::smoothing::Smoothing;
use crate::{Error, Result, saved};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Nobody waits longer for a late observation, s.
const MOST_DELAY_S: f64 = 3600.0;

/// A time that is a day ahead of all before is none, s: what comes after it would be late for ever.
const MOST_AHEAD_S: f64 = 86_400.0;
/// In a stream whose observations come out of order one that is farther ahead waits for another that says the same.
const LEAP_S: f64 = 10.0;

/// Who is followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Subject {
    /// By an IMU and a colour patch.
    Arm(Box<ArmFilter>),
    /// By a camera.
    Body(Box<BodyFilter>),
}

impl Subject {
    /// Check that it observes such a thing, and the numbers of a frame; those of a sample are checked as it is taken.
    fn check(&self, time_s: f64, what: &What) -> Result<()> {
        match (self, what) {
            (Self::Arm(arm), What::Patch(pixels)) => arm.check(time_s, pixels),
            (Self::Body(_), What::Picture(picture)) => picture.check(time_s),
            (Self::Arm(arm), What::Landmark(landmark)) => landmark.check(time_s, arm.cameras()),
            (Self::Arm(_), What::Inertial(_)) | (_, What::Orientation(_)) => Ok(()),
            _ => Err(Error::Foreign { what: what.name() }),
        }
    }
}

/// What [`Tracker::run`] made of a stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// One a frame, up to where it stopped.
    pub estimates: Vec<Estimate>,
    /// Why it stopped early, if it did.
    pub stopped: Option<Error>,
}

/// Follows one arm or one body. Clone or [`Tracker::save`] it to resume later with the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tracker {
    subject: Subject,
    /// Of an arm, where it is known which: its upper arm.
    upper_arm: Option<Segment>,
    delay_s: f64,
    /// Time of the latest observation that was not refused, s.
    newest_s: f64,
    last_frame_s: Option<f64>,
    lost_at_s: Option<f64>,
    /// Time of the last observation, refused, that was far ahead, s.
    #[serde(skip)]
    leapt_s: Option<f64>,
    /// Observations that an earlier one may still come before, in order of time.
    #[serde(skip)]
    waiting: Vec<Observation>,
    /// Estimates that are still to be handed out.
    #[serde(skip)]
    ready: VecDeque<Estimate>,
}

impl From<ArmFilter> for Tracker {
    fn from(filter: ArmFilter) -> Self {
        Self::new(Subject::Arm(Box::new(filter)))
    }
}

impl From<BodyFilter> for Tracker {
    fn from(filter: BodyFilter) -> Self {
        Self::new(Subject::Body(Box::new(filter)))
    }
}

impl Tracker {
    /// Ready for its first observation; nothing is waited for.
    pub fn new(subject: Subject) -> Self {
        let (waiting, ready) = (Vec::new(), VecDeque::new());
        let (delay_s, newest_s) = (0.0, f64::NEG_INFINITY);
        let (last_frame_s, lost_at_s, leapt_s) = (None, None, None);
        Self { subject, upper_arm: None, delay_s, newest_s, last_frame_s, lost_at_s, leapt_s, waiting, ready }
    }

    /// The same, of an arm with this upper arm: orientations of another's are refused.
    #[must_use]
    pub fn with_upper_arm(self, segment: Segment) -> Self {
        Self { upper_arm: Some(segment), ..self }
    }

    /// The same, putting in order what comes up to `delay_s` after a later observation: estimates come so much later.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn with_delay(self, delay_s: f64) -> Result<Self> {
        require((0.0..=MOST_DELAY_S).contains(&delay_s), "delay_s", delay_s, "0 to 3600 s")?;
        Ok(Self { delay_s, ..self })
    }

    /// Who is followed.
    pub fn subject(&self) -> &Subject {
        &self.subject
    }

    /// Names of the places in every estimate, in order.
    pub fn places(&self) -> Vec<&'static str> {
        match &self.subject {
            Subject::Arm(_) => arm::PLACES.to_vec(),
            Subject::Body(_) => KEY_JOINTS.iter().map(|(name, _, _)| *name).collect(),
        }
    }

    /// Take an observation; the estimate of a frame, none between frames. Where late ones are waited for it is that of a frame
    /// that is due by now, the oldest that was not handed out.
    ///
    /// # Errors
    /// [`Error::At`] with the number of an observation that has one, around: [`Error::TooLate`] for what comes later than
    /// the delay, [`Error::Ahead`] for a time a day ahead of all before, [`Error::Late`] for what is not later than the last
    /// of its kind, [`Error::Foreign`] for what another subject observes, and what the subject refuses, after all of which
    /// the tracker is as before, but that an arm counts the samples that it had to do without; a loss of the track
    /// ([`Error::is_loss_of_track`]), after which every frame is [`Error::Lost`]. With a delay an error may be of an earlier
    /// observation, which its number tells; this one is kept.
    pub fn observe(&mut self, observation: Observation) -> Result<Option<Estimate>> {
        self.observe_recorded(observation, None)
    }

    /// The same, showing `recorder` every layer of a particle method.
    ///
    /// # Errors
    /// As [`Tracker::observe`].
    pub fn observe_recorded(
        &mut self,
        observation: Observation,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Option<Estimate>> {
        let (time_s, is_sample) = (observation.time_s, matches!(observation.what, What::Inertial(_)));
        let found = self.accept(observation, recorder);
        match (&found, &mut self.subject) {
            (Ok(_), _) => self.newest_s = self.newest_s.max(time_s),
            (Err(error), Subject::Arm(arm)) if is_sample && !error.is_loss_of_track() && !error.is_repetition() => {
                arm.miss(time_s);
            }
            _ => {}
        }
        found
    }

    /// Take an observation now, or let it wait.
    fn accept(&mut self, observation: Observation, recorder: Option<&mut dyn Recorder>) -> Result<Option<Estimate>> {
        let time_s = observation.time_s;
        self.subject.check(time_s, &observation.what).map_err(|error| numbered(error, &observation))?;
        let latest_s = self.newest_s;
        if latest_s.is_finite() && time_s > latest_s + self.most_ahead_s(time_s) {
            let most_s = self.most_ahead_s(time_s);
            self.leapt_s = Some(time_s);
            return Err(numbered(
                Error::Ahead { what: observation.what.name(), time_s, latest_s, most_s },
                &observation,
            ));
        }
        if self.delay_s == 0.0 {
            return self.take(&observation, recorder);
        }
        require_time("time of an observation", time_s)?;
        if time_s < self.newest_s - self.delay_s {
            let (late_s, delay_s) = (self.newest_s - time_s, self.delay_s);
            let error = Error::TooLate { what: observation.what.name(), time_s, late_s, delay_s };
            return Err(numbered(error, &observation));
        }
        // Told of the one that comes again, not of another when both are due; of landmarks there may be several at a time.
        let is_twin = |other: &Observation| {
            let of = |one: &Observation| (one.time_s, one.source, one.what.name());
            of(other) == of(&observation) && !matches!(observation.what, What::Landmark(_))
        };
        if self.waiting.iter().any(is_twin) {
            let error = Error::Late { what: observation.what.name(), time_s, latest_s: time_s };
            return Err(numbered(error, &observation));
        }
        self.newest_s = self.newest_s.max(time_s);
        // Of the same time a sample comes before a frame.
        let key = |o: &Observation| (o.time_s, o.what.is_frame());
        let at = self.waiting.partition_point(|waits| key(waits) <= key(&observation));
        self.waiting.insert(at, observation);
        self.release(self.newest_s - self.delay_s, recorder)?;
        Ok(self.ready.pop_front())
    }

    /// How far ahead of all others an observation may be: one wrong time must not make all that follow come too late.
    fn most_ahead_s(&self, time_s: f64) -> f64 {
        let is_alone = self.leapt_s.is_none_or(|leapt_s| (time_s - leapt_s).abs() > LEAP_S);
        if self.delay_s > 0.0 && is_alone { LEAP_S } else { MOST_AHEAD_S }
    }

    /// Wait no longer: estimates of all frames that are left.
    ///
    /// # Errors
    /// As [`Tracker::observe`]; what came before the error is handed out by the next call.
    pub fn finish(&mut self) -> Result<Vec<Estimate>> {
        self.release(f64::INFINITY, None)?;
        Ok(std::mem::take(&mut self.ready).into())
    }

    /// Take what waits up to `until_s`.
    fn release(&mut self, until_s: f64, mut recorder: Option<&mut dyn Recorder>) -> Result<()> {
        while self.waiting.first().is_some_and(|first| first.time_s <= until_s) {
            let due = self.waiting.remove(0);
            let estimate = match &mut recorder {
                Some(recorder) => self.take(&due, Some(&mut **recorder)),
                None => self.take(&due, None),
            };
            if estimate.as_ref().is_err_and(Error::is_loss_of_track) {
                // Nothing comes of them any more.
                self.waiting.clear();
            }
            self.ready.extend(estimate?);
        }
        Ok(())
    }

    /// A stretch of observations, until an error stops it.
    pub fn run(&mut self, observations: impl IntoIterator<Item = Observation>) -> Stretch {
        let mut estimates = Vec::new();
        for observation in observations {
            let found = self.observe(observation);
            let stopped = found.map(|found| estimates.extend(found)).err();
            estimates.extend(self.ready.drain(..));
            if stopped.is_some() {
                return Stretch { estimates, stopped };
            }
        }
        Stretch { estimates, stopped: None }
    }

    fn take(&mut self, observation: &Observation, recorder: Option<&mut dyn Recorder>) -> Result<Option<Estimate>> {
        let time_s = observation.time_s;
        let taken = match (&mut self.subject, &observation.what) {
            (Subject::Arm(arm), What::Inertial(sample)) => arm.take(sample).map(|()| None),
            (Subject::Arm(arm), What::Landmark(landmark)) => match self.last_frame_s.filter(|last| time_s <= *last) {
                Some(latest_s) => Err(Error::Late { what: "landmark", time_s, latest_s }),
                None => arm.take_landmark(time_s, *landmark).map(|()| None),
            },
            (Subject::Arm(arm), What::Orientation(orientation)) => match orientation.to_shoulder() {
                Some(_) if self.upper_arm.is_some_and(|own| own != orientation.segment) => {
                    Err(Error::Foreign { what: "orientation of the other arm" })
                }
                Some(to_shoulder) => {
                    arm.take_direction(Direction { time_s, to_shoulder, sd: orientation.sd }).map(|()| None)
                }
                None => Err(Error::Foreign { what: "orientation of a forearm" }),
            },
            (Subject::Body(body), What::Orientation(orientation)) => body.take(time_s, orientation).map(|()| None),
            (_, what) if what.is_frame() => self.take_frame(time_s, what, recorder).map(Some),
            (_, what) => Err(Error::Foreign { what: what.name() }),
        };
        taken.map_err(|error| numbered(error, observation))
    }

    fn take_frame(&mut self, time_s: f64, what: &What, recorder: Option<&mut dyn Recorder>) -> Result<Estimate> {
        if let Some(lost_at_s) = self.lost_at_s {
            return Err(Error::Lost { time_s, lost_at_s });
        }
        if let Some(latest_s) = self.last_frame_s.filter(|last| time_s <= *last) {
            return Err(Error::Late { what: "frame", time_s, latest_s });
        }
        let elapsed_s = self.last_frame_s.map_or(0.0, |last| time_s - last);
        // Until it is known that all went well: a filter that failed half-way, or in a panic, must not be used again.
        self.lost_at_s = Some(time_s);
        let estimate = match (&mut self.subject, what) {
            (Subject::Arm(arm), What::Patch(pixels)) => arm.update(time_s, elapsed_s, pixels, recorder),
            (Subject::Body(body), What::Picture(picture)) => body.update(time_s, elapsed_s, picture, recorder),
            _ => Err(Error::Foreign { what: what.name() }),
        };
        match &estimate {
            Ok(_) => (self.lost_at_s, self.last_frame_s) = (None, Some(time_s)),
            Err(error) if !error.is_loss_of_track() => self.lost_at_s = None,
            Err(_) => {}
        }
        estimate
    }

    /// What is known at `time_s`, between frames; draws nothing and changes nothing. Of an arm.
    ///
    /// # Errors
    /// [`Error::NoInertialSample`], [`Error::Late`], [`Error::RanAway`], [`Error::Lost`]; [`Error::Foreign`] of a body.
    pub fn estimate(&self, time_s: f64) -> Result<Estimate> {
        match &self.subject {
            Subject::Arm(arm) => match self.lost_at_s {
                Some(lost_at_s) => Err(Error::Lost { time_s, lost_at_s }),
                None => arm.estimate(time_s),
            },
            Subject::Body(_) => Err(Error::Foreign { what: "time between frames" }),
        }
    }

    /// The next of the frames so far, each given those about it: as many as are smoothed together; none after the last, or of a
    /// method that does not smooth. What was given before is in `smoothing`, which is of this tracker.
    ///
    /// # Errors
    /// [`Error::Singular`], [`Error::RanAway`] where no trajectory is found.
    pub fn smoothed(&self, smoothing: &mut Smoothing) -> Result<Vec<Estimate>> {
        let first = smoothing.next();
        let stretch = match &self.subject {
            Subject::Arm(arm) => arm.smoothed(first),
            Subject::Body(body) => body.smoothed(first),
        };
        Ok(smoothing.joined(stretch?))
    }

    /// The particles as they stand, with their weights; none of a Gaussian method. A body's may have columns for what the camera
    /// does not see, see [`BodyFilter::particles`].
    pub fn particles(&self) -> Option<ParticleSet> {
        match &self.subject {
            Subject::Arm(arm) => arm.particles().cloned(),
            Subject::Body(body) => body.particles(),
        }
    }

    /// Where states `(N, D)` put the places, `(N, 3 P)`: world, m; a body's with what is not seen or without it.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of columns than the state, or the particles, have.
    pub fn pose(&self, states: &ParticleSet) -> Result<ParticleSet> {
        match &self.subject {
            Subject::Arm(arm) => arm.pose(states),
            Subject::Body(body) => body.pose(states),
        }
    }

    /// The whole tracker as bytes, for [`Tracker::restore`] by the same version.
    ///
    /// # Errors
    /// [`Error::SavedState`] when memory runs out; [`Error::Waiting`] while observations or estimates wait that
    /// [`Tracker::finish`] would hand out.
    pub fn save(&self) -> Result<Vec<u8>> {
        let count = self.waiting.len() + self.ready.len();
        if count > 0 {
            return Err(Error::Waiting { count });
        }
        saved::to_bytes("tracker", self)
    }

    /// From [`Tracker::save`].
    ///
    /// # Errors
    /// [`Error::SavedState`], [`Error::Parameter`].
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        let tracker: Self = saved::from_bytes("tracker", bytes)?;
        match &tracker.subject {
            Subject::Arm(arm) => arm.check_parameters()?,
            Subject::Body(body) => body.check_parameters()?,
        }
        Ok(tracker)
    }
}

/// With the number of the observation, where it has one, and its source, where several may number such things.
fn numbered(error: Error, observation: &Observation) -> Error {
    let of = match (observation.source, &observation.what) {
        (source, What::Orientation(_) | What::Landmark(_)) => format!(" of {source}"),
        _ => String::new(),
    };
    match observation.index {
        Some(index) => Error::At { what: observation.what.name(), index, of, source: Box::new(error) },
        None => error,
    }
}
