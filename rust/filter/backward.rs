//! Particle smoothing by backward simulation (Godsill, Doucet & West, JASA 99, 2004): trajectories given all observations.
//!
//! What a filter's history holds of a time is given what came before it. Backwards, a state is drawn from each recorded cloud
//! in proportion to its weight and to how likely the layer after it moves there. Every layer is a step of its own, so that any
//! list of layers will do.

use super::{LayerRecord, Transition};
use crate::rng::Streams;
use crate::{Error, Result};
use rand::RngExt;

/// States drawn given all observations.
#[derive(Debug, Clone, PartialEq)]
pub struct Backward {
    /// Trajectories, each one state `(D,)` a record, in the order of the records: `(K * D,)`.
    pub trajectories: Vec<Vec<f64>>,
    /// Share of the draws that had no choice, for only one state leads to the next: 1 where the motion has no noise in some
    /// direction (Tao & Hu's with one IMU sample a frame), and the trajectories are then the filter's own ancestries.
    pub forced: f64,
}

/// Draw `count` trajectories through `records` of one island, in order; `transitions` moved each from the one before, that of
/// the first is not used.
///
/// # Errors
/// [`Error::Size`] for no records, another number of transitions, or records of several islands; [`Error::AllWeightsZero`]
/// where no state of a record leads to one that was drawn, or a density is no number: the transitions are not those of the
/// history.
pub fn backward(records: &[LayerRecord], transitions: &[&dyn Transition], count: usize, seed: u64) -> Result<Backward> {
    let (Some(last), expected) = (records.last(), records.len()) else {
        return Err(Error::Size { name: "records", got: 0, unit: "layers", expected: 1 });
    };
    if transitions.len() != expected {
        return Err(Error::Size { name: "transitions", got: transitions.len(), unit: "layers", expected });
    }
    if let Some(other) = records.iter().find(|record| record.island != last.island) {
        return Err(Error::Size { name: "records", got: other.island, unit: "as an island", expected: last.island });
    }
    let (mut trajectories, mut forced) = (Vec::with_capacity(count), 0);
    for trajectory in 0..count {
        let mut rng = Streams::new(seed, trajectory as u64, 0).resampling();
        let mut states = vec![state(last, draw(&last.weights, rng.random()))];
        for k in (1..expected).rev() {
            let (before, to) = (&records[k - 1], states[states.len() - 1]);
            let mut weights = vec![0.0; before.weights.len()];
            transitions[k].log_densities(&before.predicted, to, &mut weights);
            // Of those that the filter left any weight.
            for (weight, filtered) in weights.iter_mut().zip(&before.weights) {
                *weight += filtered.ln();
            }
            let most = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if !most.is_finite() || weights.iter().any(|weight| weight.is_nan()) {
                let LayerRecord { time_s, layer, .. } = *before;
                return Err(Error::AllWeightsZero { time_s, layer, particles: before.weights.len() });
            }
            for weight in &mut weights {
                *weight = (*weight - most).exp();
            }
            forced += usize::from(weights.iter().filter(|weight| **weight > 0.0).count() == 1);
            states.push(state(before, draw(&weights, rng.random())));
        }
        trajectories.push(states.into_iter().rev().flatten().copied().collect());
    }
    let draws = (count * (expected - 1)).max(1);
    Ok(Backward { trajectories, forced: forced as f64 / draws as f64 })
}

/// A row of a recorded cloud.
fn state(record: &LayerRecord, particle: usize) -> &[f64] {
    let dim = record.predicted.len() / record.weights.len();
    &record.predicted[particle * dim..(particle + 1) * dim]
}

/// An index in proportion to weights, by a number from 0 to 1.
fn draw(weights: &[f64], at: f64) -> usize {
    let target = at * weights.iter().sum::<f64>();
    let mut sum = 0.0;
    let reached = weights.iter().position(|weight| {
        sum += weight;
        sum > target
    });
    // Rounding may leave the sum a little short of the target: the last that has any weight.
    reached.or_else(|| weights.iter().rposition(|weight| *weight > 0.0)).unwrap_or(0)
}
