//! The engine: three filters over the same states, which know no arm and no body.
//!
//! | filter | what it carries |
//! |---|---|
//! | [`LayeredFilter`] | particles, and a list of layers applied to all of them; [`Islands`]: shares of them on their own |
//! | [`Mixture`] | weighted Gaussians that split where a measurement bends over them, and merge again; one of them is the (iterated) extended Kalman filter |
//! | [`backward`] | trajectories through the particles that a [`Recorder`] kept, given what came after them |
//! | [`settle`], [`smooth`] | a whole recording's trajectory, by Gauss-Newton from another filter's track |
//!
//! A *layer* is a transition, the likelihoods that weigh its result and how they are blended; it is applied to the whole set at
//! once, and after each layer the set may be resampled. Bootstrap filter: one layer. Tao & Hu's layered
//! sampling (III-E): two. Annealing: several of the same, from flat to sharp. Nothing else differs.

mod backward;
mod blend;
mod chain;
mod islands;
mod kalman;
mod layered;
mod linear_transition;
mod mixture;
mod passes;
mod recorder;
mod smoother;
mod spread;

pub use backward::{Backward, backward};
pub use blend::Blend;
pub use chain::Chain;
pub use islands::Islands;
pub use kalman::{Gaussian, Innovation, Linear};
pub use layered::{LayeredFilter, Resampling};
pub use linear_transition::LinearTransition;
pub use mixture::{Component, Mixture, Reduction};
pub use recorder::{History, LayerRecord, Recorder};
pub use smoother::{Settled, Smoothed, cost_of, settle, smooth};
pub use spread::Spread;

use crate::particles::{BlockMut, ParticleSet};
use crate::rng::Stream;

/// How the state moves: `p(x_k | x_{k-1})`.
pub trait Transition: Sync {
    /// Draw every particle of one block from the density, in place.
    fn propagate(&self, block: BlockMut<'_>, rng: &mut Stream);

    /// Write `ln p(to | from)` of every state `(D,)` of `from`, rows `(N, D)`, to one `(D,)`; minus infinity where it cannot be
    /// reached. Where the noise has less than full rank this is the density within the directions that it reaches (the
    /// pseudo-inverse of Tao & Hu eq. 10).
    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]);
}

/// How well particles explain an observation: `p(z_k | x_k)`.
///
/// A likelihood weighs the *set*, not one particle: some rescale over all of them, and a batch is what
/// vector instructions and threads want.
pub trait Likelihood: Sync {
    /// Write the log-likelihood of every particle, `(N,)`; minus infinity where it cannot be.
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]);

    /// Whether the values are likelihoods, so that their mean is the evidence; not so where they are rescaled.
    fn has_evidence(&self) -> bool {
        true
    }
}

/// A transition, the likelihoods that weigh its result together (none: the layer only moves), and how they are blended.
pub struct Layer<'a> {
    /// Applied first, to the whole set.
    pub transition: &'a dyn Transition,
    /// Cue by cue, or one that has blended its cues itself.
    pub likelihoods: Vec<&'a dyn Likelihood>,
    /// How what they say becomes one weight.
    pub blend: Blend,
}
