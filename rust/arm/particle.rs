//! The arm's particle methods: lists of layers over the inertial motion, the random walk and the two cues.
//!
//! | method | layers |
//! |---|---|
//! | plain PF (III-C) | [inertial, colour] |
//! | layered (III-E, the paper's seven steps) | [inertial, colour] [walk, arm length] |
//! | the same cycle as IV-B tells it | [walk, arm length at the last frame] [inertial, colour] |
//! | joint | [inertial, colour and arm length] |

use super::cues::CueName;
use super::cues::colour::Colour;
use super::cues::length::ArmLength;
use super::cues::rest::Rest;
use super::frame::Frame;
use super::motion::{InertialMotion, Motion, RandomWalk};
use super::pause::Stretch;
use super::state::{Arm, Layout, Noise, POSITION, estimate_of_particles};
use crate::estimate::Estimate;
use crate::filter::{Blend, Layer, LayeredFilter, Likelihood, Recorder, Resampling, Transition};
use crate::particles::ParticleSet;
use crate::quaternion::Quaternion;
use crate::rng::Streams;
use crate::{Error, Result};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// What moves the particles of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mover {
    /// Eqs (6), (12).
    Inertial,
    /// Eq. (17).
    Walk,
}

/// One layer by name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmLayer {
    /// What moves.
    pub mover: Mover,
    /// What weighs, together.
    pub cues: Vec<CueName>,
    /// How they are blended.
    pub blend: Blend,
}

impl Mover {
    /// `inertial` or `walk`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "inertial" => Ok(Self::Inertial),
            "walk" => Ok(Self::Walk),
            _ => Err(Error::UnknownName { what: "motion", name: name.into(), known: "inertial, walk" }),
        }
    }
}

/// A layered particle filter of the arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmParticles {
    layers: Vec<ArmLayer>,
    layout: Layout,
    filter: LayeredFilter,
}

impl ArmParticles {
    /// `len` particles about the arm's start.
    ///
    /// # Errors
    /// [`Error::Parameter`] for no particles or a blend that is out of range; [`Error::Size`] for no layers or not exactly one inertial layer.
    pub fn new(
        arm: &Arm,
        noise: &Noise,
        layers: Vec<ArmLayer>,
        len: usize,
        resampling: Resampling,
        seed: u64,
    ) -> Result<Self> {
        let inertial = layers.iter().filter(|layer| layer.mover == Mover::Inertial).count();
        if inertial != 1 {
            return Err(Error::Size { name: "layers", got: inertial, unit: "inertial motions", expected: 1 });
        }
        layers.iter().try_for_each(|layer| layer.blend.check())?;
        let layout = Layout::new(noise);
        let (mean, sd) = layout.start(arm, noise);
        let mut particles = ParticleSet::new(len, layout.dim)?;
        // The start draws from a step of its own, before step 0.
        let streams = Streams::new(seed, u64::MAX, 0);
        particles.for_each_block(|b, mut block| {
            let mut rng = streams.block(b);
            for d in 0..layout.dim {
                for x in block.column_mut(d) {
                    let z: f64 = rng.sample(StandardNormal);
                    *x = mean[d] + sd[d] * z;
                }
            }
        });
        Ok(Self { layers, layout, filter: LayeredFilter::new(particles, resampling, seed) })
    }

    /// Start again, evenly along a stretch, after what came before has been of no use; `restarts` times so far.
    pub fn start_again(&mut self, arm: &Arm, noise: &Noise, stretch: &Stretch, restarts: u64) {
        let (layout, sd) = (self.layout, stretch.sd(self.layout, arm, noise));
        // As the start draws from a step of its own.
        let streams = Streams::new(self.filter.seed(), u64::MAX, restarts);
        self.filter.start_again(|b, mut block| {
            let mut rng = streams.block(b);
            for d in 0..layout.dim {
                for x in block.column_mut(d) {
                    let z: f64 = rng.sample(StandardNormal);
                    *x = sd[d] * z;
                }
            }
            for i in 0..block.len() {
                let along: f64 = rng.random_range(-1.0..1.0);
                for d in 0..3 {
                    block.column_mut(POSITION + d)[i] += stretch.middle[d] + along * stretch.half[d];
                }
            }
        });
    }

    /// Whether the patch is among what weighs.
    pub fn sees_patch(&self) -> bool {
        self.layers.iter().any(|layer| layer.cues.contains(&CueName::Colour))
    }

    /// Whether a layer is weighed by the arm's length.
    pub fn is_held_by_arm(&self) -> bool {
        self.layers.iter().any(|layer| layer.cues.contains(&CueName::ArmLength))
    }

    /// The set as it stands.
    pub fn particles(&self) -> &ParticleSet {
        self.filter.particles()
    }

    /// One cycle: every layer in order.
    ///
    /// # Errors
    /// [`Error::AllWeightsZero`].
    pub fn update(
        &mut self,
        arm: &Arm,
        noise: &Noise,
        frame: &Frame<'_>,
        recorder: Option<&mut dyn Recorder>,
    ) -> Result<Estimate> {
        let inertial = InertialMotion::new(frame.motion.clone(), self.layout, noise);
        let walk = RandomWalk { sd: noise.walk_density * frame.motion.elapsed_s.sqrt() };
        let colour = Colour::new(frame.sightings.clone(), frame.world_sensor.to_matrix(), self.layout, noise);
        let forearm = |q: Quaternion| q.rotate(arm.elbow_in_sensor());
        let length_before = ArmLength::new(arm, forearm(frame.last_world_sensor), noise, frame.stale_s);
        let length_now = ArmLength::new(arm, forearm(frame.world_sensor), noise, frame.stale_s);
        let rest = frame.rest.map(|tremor| Rest::new(tremor, noise));
        let mut moved = false;
        let mut layers = Vec::with_capacity(self.layers.len());
        for layer in &self.layers {
            let transition: &dyn Transition = match layer.mover {
                Mover::Inertial => &inertial,
                Mover::Walk => &walk,
            };
            moved |= layer.mover == Mover::Inertial;
            // A layer before the inertial motion still stands at the last frame, and is weighed by it.
            let length: &dyn Likelihood = if moved { &length_now } else { &length_before };
            let mut likelihoods: Vec<&dyn Likelihood> = Vec::with_capacity(layer.cues.len());
            for cue in &layer.cues {
                match cue {
                    CueName::ArmLength => likelihoods.push(length),
                    CueName::Colour if !frame.sightings.is_empty() => likelihoods.push(&colour),
                    CueName::Colour => {}
                    CueName::Rest => likelihoods.extend(rest.iter().map(|rest| rest as &dyn Likelihood)),
                }
            }
            layers.push(Layer { transition, likelihoods, blend: layer.blend });
        }
        let forearm = forearm(frame.world_sensor);
        self.filter.cycle(frame.time_s, &layers, recorder, |particles, evidence| {
            estimate_of_particles(frame.time_s, particles, forearm, evidence)
        })
    }

    /// The estimate after `motion`, drawing nothing: moved by its mean, widened by its noise.
    pub fn estimate(
        &self,
        arm: &Arm,
        noise: &Noise,
        time_s: f64,
        motion: &Motion,
        world_sensor: Quaternion,
    ) -> Estimate {
        let inertial = InertialMotion::new(motion.clone(), self.layout, noise);
        let mut particles = self.particles().clone();
        particles.for_each_block(|_, block| inertial.move_mean(block));
        let (_, _, spread) = inertial.matrices();
        estimate_of_particles(time_s, &particles, world_sensor.rotate(arm.elbow_in_sensor()), None).widened(&spread)
    }
}
