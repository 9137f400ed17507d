//! A method of tracking the arm: which filter, and what corrects it.

use super::cues::CueName;
use super::ekf::Correction;
use super::particle::ArmLayer;
use super::setup::Setup;
use crate::filter::Resampling;

/// How the arm is tracked.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// A list of layers on a particle set.
    Particles {
        /// Applied in order at every frame.
        layers: Vec<ArmLayer>,
        /// How many particles.
        particles: usize,
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
        /// In this order, after the patch.
        corrections: Vec<CueName>,
        /// Components that are kept.
        components: usize,
    },
    /// The same, its frames kept, so that they can be smoothed ([`crate::Tracker::smoothed`]).
    Smoother {
        /// As those of the mixture.
        corrections: Vec<CueName>,
        /// As those of the mixture.
        components: usize,
        /// How well lengths and cameras are known; of as many cameras as there are.
        setup: Option<Setup>,
    },
}
