//! The body as a tracker's subject: an image's evidence in, a pose with error bars out.

use super::cues::Picture;
use super::cues::orientation::Orientation;
use super::cues::region::bareness;
use super::figure::Figure;
use super::method::{BodyMethod, FilterMethod};
use super::mixture::BodyMixture;
use super::moment::Moment;
use super::particles::BodyParticles;
use super::unseen::{Known, UNSEEN, Unseen};
use crate::error::{require, require_time};
use crate::estimate::Estimate;
use crate::filter::Recorder;
use crate::particles::ParticleSet;
use crate::projection::Projection;
use crate::smoothing::Windowed;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// No angle is less known.
const MOST_RAD: f64 = 10.0;
/// An orientation older than this says nothing of a frame, s.
const STALE_S: f64 = 0.1;

/// The latest orientation of a segment that wears a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Worn {
    time_s: f64,
    orientation: Orientation,
}

/// One of the filters, over the poses of one body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyFilter {
    figure: Figure,
    projection: Projection,
    method: BodyMethod,
    filter: Filter,
    /// Segment by segment.
    worn: Vec<Worn>,
    /// Times of the first and the last.
    frames_s: Option<[f64; 2]>,
    /// How bare the forearms are, told at the first frame that shows skin.
    bare: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Filter {
    Particles(BodyParticles),
    Mixture(BodyMixture),
}

impl BodyFilter {
    /// At the figure's own pose (paper IV-C1).
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::Size`].
    pub fn new(figure: Figure, projection: Projection, method: BodyMethod, seed: u64) -> Result<Self> {
        method.check()?;
        let figure = figure.balanced(&projection, method.balance);
        let filter = match &method.filter {
            FilterMethod::Particles(particles) => {
                let gate_m = method.cue_parameters.blobs.gate_m;
                Filter::Particles(BodyParticles::new(&figure, particles.clone(), gate_m, seed)?)
            }
            FilterMethod::Mixture(mixture) => Filter::Mixture(BodyMixture::new(&figure, mixture)),
        };
        Ok(Self { figure, projection, method, filter, worn: Vec::new(), frames_s: None, bare: None })
    }

    /// The figure.
    pub fn figure(&self) -> &Figure {
        &self.figure
    }

    /// The particles as they stand, of all islands: the free channels; then, where the method has it, what the camera does
    /// not see: distance, m, lean and turn, rad, places beside and above, m. None of a mixture.
    pub fn particles(&self) -> Option<ParticleSet> {
        let Filter::Particles(filter) = &self.filter else { return None };
        let particles = filter.particles();
        if self.method.unseen.is_none() {
            return Some(particles);
        }
        let [first_s, last_s] = self.frames_s.unwrap_or_default();
        let (since_s, by_outlines) = (last_s - first_s, filter.by_outlines());
        let known = Known { since_s, by_outlines, root_m: self.figure.root_height_m() };
        let joints = self.figure.in_balance(self.figure.key_joints(&particles)).moments().0;
        Some(self.method.unseen.drawn(&particles, known, joints.as_slice()))
    }

    /// Where states put the key joints, `(N, 8 * 3)`, m: of the free channels, or with columns of what is not seen besides.
    ///
    /// # Errors
    /// [`Error::Size`] for another number of columns.
    pub fn pose(&self, states: &ParticleSet) -> Result<ParticleSet> {
        let dim = self.figure.model.dim();
        if states.dim() != dim + UNSEEN || self.method.unseen.is_none() {
            return self.figure.joints_of(states);
        }
        let seen = states.mapped(dim, |block, out| {
            (0..dim).for_each(|d| out.column_mut(d).copy_from_slice(block.column(d)));
        });
        let (joints, states) = (self.figure.joints_of(&seen)?, states.rows());
        let each = joints
            .rows()
            .chunks(joints.dim())
            .zip(states.chunks(dim + UNSEEN))
            .flat_map(|(joints, state)| {
                Unseen::moved(joints, std::array::from_fn(|k| state[dim + k]), &self.projection)
            })
            .collect::<Vec<_>>();
        ParticleSet::from_rows(joints.dim(), &each)
    }

    /// Take what a sensor says of the segment that wears it; it holds for a tenth of a second.
    ///
    /// # Errors
    /// [`Error::Late`], [`Error::NotFinite`], [`Error::Parameter`]; the filter is then as before.
    pub fn take(&mut self, time_s: f64, orientation: &Orientation) -> Result<()> {
        require_time("orientation time", time_s)?;
        if let Some(odd) = orientation.q_world_segment.coords.iter().find(|x| !x.is_finite()) {
            return Err(Error::NotFinite { name: "orientation", time_s, value: *odd });
        }
        let Orientation { sd, roll_sd, segment, .. } = *orientation;
        require(sd > 0.0 && sd <= MOST_RAD, "spread of an orientation", sd, "a positive angle")?;
        require(roll_sd > 0.0, "spread of a roll", roll_sd, "a positive angle, or infinite")?;
        let orientation = *orientation;
        match self.worn.iter_mut().find(|worn| worn.orientation.segment == segment) {
            Some(worn) if time_s <= worn.time_s => {
                return Err(Error::Late { what: "orientation", time_s, latest_s: worn.time_s });
            }
            Some(worn) => *worn = Worn { time_s, orientation },
            None => self.worn.push(Worn { time_s, orientation }),
        }
        Ok(())
    }

    /// Take a frame that was checked, `elapsed_s` after the last. The first moves nothing: the figure's pose is the pose
    /// there. `recorder` sees every layer, island by island.
    ///
    /// # Errors
    /// [`Error::AllWeightsZero`] and [`Error::RanAway`], after which it must not be used again.
    pub fn update(
        &mut self,
        time_s: f64,
        elapsed_s: f64,
        picture: &Picture,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Estimate> {
        if let (None, Some(skin)) = (self.bare, &picture.skin) {
            self.bare = Some(bareness(skin, &self.figure.seen(&self.projection, &self.figure.model.start())));
        }
        let bare = self.bare.unwrap_or(1.0);
        let fresh = self.worn.iter().filter(|worn| time_s - worn.time_s <= STALE_S);
        let orientations: Vec<Orientation> = fresh.map(|worn| worn.orientation).collect();
        let orientations = orientations.as_slice();
        let first_s = self.frames_s.map_or(time_s, |[first_s, _]| first_s);
        self.frames_s = Some([first_s, time_s]);
        let (Self { figure, projection, method, filter, .. }, since_s) = (self, time_s - first_s);
        let (figure, projection, method) = (&*figure, &*projection, &*method);
        let moment = Moment { figure, projection, method, picture, orientations, time_s, elapsed_s, since_s, bare };
        let estimate = match filter {
            Filter::Particles(particles) => particles.update(&moment, recorder),
            Filter::Mixture(mixture) => mixture.update(&moment),
        };
        estimate?.checked()
    }

    /// Frames so far, from number `first` on, each given those about it: as many as are smoothed together; none beyond the
    /// last, or of a method that does not smooth.
    ///
    /// # Errors
    /// [`Error::Singular`], [`Error::RanAway`] where no trajectory is found.
    pub(crate) fn smoothed(&self, first: usize) -> Result<Windowed> {
        match &self.filter {
            Filter::Particles(particles) => particles.smoothed((&self.figure, &self.projection, &self.method), first),
            Filter::Mixture(_) => Ok(Windowed::default()),
        }
    }

    /// Check what was read back.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check_parameters(&self) -> Result<()> {
        self.method.check()
    }
}
