//! The whole recording at once: Gauss-Newton over all its states, by Kalman passes forward and back.
//!
//! For a chain of states one Gauss-Newton step is a Kalman filter and a smoother's way back (`passes`), linearised about the
//! last trajectory (Bell, "The iterated Kalman smoother as a Gauss-Newton method", SIAM J. Optimization 4(3), 1994): the
//! same normal equations, block-tridiagonal, in time and memory that grow with the length. What is constant is a column that
//! does not walk: its border is carried along. Covariances are those of each state given the whole recording.

use super::chain::Chain;
use super::passes::{covariances, filter, means};
use super::spread::Spread;
use super::{Gaussian, Linear};
use crate::{Error, Result};
use nalgebra::DVector;

/// A step is halved so often before it is given up.
const HALVINGS: i32 = 8;

/// A smoothed recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// One a step.
    pub states: Vec<Gaussian>,
    /// Log evidence of what was measured at every step given the steps before, linearised about them.
    pub log_evidence: Vec<f64>,
}

/// A trajectory without its spread.
#[derive(Debug, Clone, PartialEq)]
pub struct Settled {
    /// One state a step.
    pub at: Vec<DVector<f64>>,
    /// Minus twice the log posterior of the trajectory, but for a constant.
    pub cost: f64,
    /// Log evidence of what was measured, by the last linearisation; zero where there was none.
    pub log_evidence: f64,
    /// Whether the trajectory had settled before the last turn.
    pub is_settled: bool,
}

/// The likeliest trajectory of `chain`, starting from one: at most `turns` steps, each shortened until it explains more than the
/// last, until no state moves by more than `settled` of its own standard deviations.
///
/// # Errors
/// [`Error::Size`] for a trajectory of another length, [`Error::Singular`], [`Error::RanAway`], what the chain gives.
pub fn settle(chain: &impl Chain, mut at: Vec<DVector<f64>>, turns: usize, settled: f64) -> Result<Settled> {
    let expected = chain.len();
    if at.len() != expected || expected == 0 {
        return Err(Error::Size { name: "trajectory", got: at.len(), unit: "states", expected: expected.max(1) });
    }
    let mut measured = measured(chain, &at)?;
    let mut cost = cost(chain, &at, &measured)?;
    let mut log_evidence = 0.0;
    for _ in 0..turns {
        let forward = filter(chain, &at, measured)?;
        log_evidence = forward.log_evidence().iter().sum();
        let to = means(chain, &forward)?;
        let Some(lower) = shorten(chain, &at, &to, cost) else {
            // No step explains more: this is where it ends.
            return Ok(Settled { at, cost, log_evidence, is_settled: true });
        };
        let moved =
            forward.filtered.iter().zip(at.iter().zip(&lower.at)).map(|(state, (from, to))| in_sd(state, from, to));
        let is_settled = moved.fold(0.0, f64::max) <= settled;
        (at, cost, measured) = (lower.at, lower.cost, lower.measured);
        if is_settled {
            return Ok(Settled { at, cost, log_evidence, is_settled });
        }
    }
    Ok(Settled { at, cost, log_evidence, is_settled: false })
}

/// A trajectory that has settled with the spread about it, given the whole recording.
///
/// # Errors
/// As [`settle`].
pub fn smooth(chain: &impl Chain, at: Vec<DVector<f64>>) -> Result<Smoothed> {
    let mut forward = filter(chain, &at, measured(chain, &at)?)?;
    covariances(chain, &mut forward);
    let log_evidence = forward.log_evidence();
    let mut states = forward.filtered;
    states.iter_mut().zip(at).for_each(|(state, mean)| state.mean = mean);
    Ok(Smoothed { states, log_evidence })
}

/// A trajectory that explains more than the last, and what is measured about it.
struct Lower {
    at: Vec<DVector<f64>>,
    measured: Vec<Vec<Linear>>,
    cost: f64,
}

/// As much of a step as explains more than the trajectory that it starts from; none where nothing of it does.
fn shorten(chain: &impl Chain, at: &[DVector<f64>], to: &[DVector<f64>], before: f64) -> Option<Lower> {
    (0..HALVINGS).find_map(|halvings| {
        let share = 0.5f64.powi(halvings);
        let at: Vec<DVector<f64>> = at.iter().zip(to).map(|(from, to)| from.lerp(to, share)).collect();
        let measured = measured(chain, &at).ok()?;
        let cost = cost(chain, &at, &measured).ok()?;
        (cost < before).then_some(Lower { at, measured, cost })
    })
}

/// What is measured at every step, linearised about a trajectory.
fn measured(chain: &impl Chain, at: &[DVector<f64>]) -> Result<Vec<Vec<Linear>>> {
    at.iter().enumerate().map(|(step, state)| chain.measure(step, state)).collect()
}

/// Minus twice the log posterior of a trajectory, but for a constant.
///
/// # Errors
/// [`Error::Singular`] where noise has no spread, what the chain gives.
pub fn cost_of(chain: &impl Chain, at: &[DVector<f64>]) -> Result<f64> {
    cost(chain, at, &measured(chain, at)?)
}

fn cost(chain: &impl Chain, at: &[DVector<f64>], measured: &[Vec<Linear>]) -> Result<f64> {
    let mut cost = 0.0;
    for (step, (state, measured)) in at.iter().zip(measured).enumerate() {
        cost += match (chain.start(step), step.checked_sub(1)) {
            (None, Some(before)) => chain.surprise(step, &at[before], state),
            (Some(start), _) => Spread::new(&start.covariance).surprise(&(state - &start.mean)),
            (None, None) => 0.0,
        };
        for (residual, _, noise) in measured {
            let factor = noise.clone().cholesky().ok_or(Error::Singular { time_s: chain.time_s(step) })?;
            let log_determinant: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
            cost += residual.dot(&factor.solve(residual)) + log_determinant;
        }
    }
    Ok(cost)
}

/// How far a state has moved, in its standard deviations.
fn in_sd(state: &Gaussian, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
    let sd = |d: usize| state.covariance[(d, d)].max(f64::MIN_POSITIVE).sqrt();
    (0..from.len()).map(|d| (to[d] - from[d]).abs() / sd(d)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::LinearTransition;
    use nalgebra::DMatrix;

    /// A place and a speed, walking; the place is measured, by a distance from the origin or as it is.
    struct Walk {
        start: Gaussian,
        measured: Vec<Option<f64>>,
        is_distance: bool,
        anew: Option<usize>,
    }

    const DT: f64 = 0.1;
    const NOISE: f64 = 0.04;

    fn transition() -> DMatrix<f64> {
        DMatrix::from_row_slice(2, 2, &[1.0, DT, 0.0, 1.0])
    }

    fn process() -> DMatrix<f64> {
        DMatrix::from_row_slice(2, 2, &[DT * DT * DT / 3.0, DT * DT / 2.0, DT * DT / 2.0, DT])
    }

    impl Chain for Walk {
        fn len(&self) -> usize {
            self.measured.len()
        }

        fn time_s(&self, step: usize) -> f64 {
            DT * step as f64
        }

        fn start(&self, step: usize) -> Option<Gaussian> {
            (step == 0 || Some(step) == self.anew).then(|| self.start.clone())
        }

        fn predict(&self, _: usize, state: &mut Gaussian) {
            state.predict(&transition(), &DVector::zeros(2), &process());
        }

        fn transition(&self, _: usize) -> LinearTransition {
            LinearTransition::of(transition())
        }

        fn surprise(&self, _: usize, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
            Spread::new(&process()).surprise(&(to - transition() * from))
        }

        fn measure(&self, step: usize, at: &DVector<f64>) -> Result<Vec<Linear>> {
            let Some(measured) = self.measured[step] else { return Ok(Vec::new()) };
            let (seen, slope) = if self.is_distance { (at[0].abs(), at[0].signum()) } else { (at[0], 1.0) };
            let one = |value| DMatrix::from_element(1, 1, value);
            let slope = DMatrix::from_row_slice(1, 2, &[slope, 0.0]);
            Ok(vec![(DVector::from_element(1, measured - seen), slope, one(NOISE))])
        }
    }

    /// Until it has settled, then its spread.
    fn smoothed_walk(chain: &Walk, at: Vec<DVector<f64>>, turns: usize, settled: f64) -> Smoothed {
        let found = settle(chain, at, turns, settled).unwrap();
        assert!(found.is_settled);
        let smoothed = smooth(chain, found.at).unwrap();
        assert!((found.log_evidence - smoothed.log_evidence.iter().sum::<f64>()).abs() < 1e-6);
        smoothed
    }

    fn walk(is_distance: bool, anew: Option<usize>) -> Walk {
        let start = Gaussian {
            mean: DVector::from_column_slice(&[1.0, 0.2]),
            covariance: DMatrix::from_row_slice(2, 2, &[0.5, 0.1, 0.1, 0.3]),
        };
        let measured = (0..12).map(|k| (k % 4 != 3).then(|| 1.0 + 0.3 * (f64::from(k) * 0.7).sin())).collect();
        Walk { start, measured, is_distance, anew }
    }

    /// All states at once as one Gaussian, conditioned in one go.
    #[test]
    fn it_is_the_posterior_of_the_whole_linear_chain() {
        let chain = walk(false, None);
        let (n, dim) = (chain.len(), 2 * chain.len());
        let (mut mean, mut joint) = (DVector::zeros(dim), DMatrix::zeros(dim, dim));
        mean.rows_mut(0, 2).copy_from(&chain.start.mean);
        joint.view_mut((0, 0), (2, 2)).copy_from(&chain.start.covariance);
        for k in 1..n {
            let before = mean.rows(2 * k - 2, 2).into_owned();
            mean.rows_mut(2 * k, 2).copy_from(&(transition() * before));
            let cross = transition() * joint.view((2 * k - 2, 0), (2, 2 * k)).into_owned();
            joint.view_mut((2 * k, 0), (2, 2 * k)).copy_from(&cross);
            joint.view_mut((0, 2 * k), (2 * k, 2)).copy_from(&cross.transpose());
            let own = transition() * joint.view((2 * k - 2, 2 * k - 2), (2, 2)) * transition().transpose() + process();
            joint.view_mut((2 * k, 2 * k), (2, 2)).copy_from(&own);
        }
        let mut whole = Gaussian { mean, covariance: joint };
        let mut evidence = 0.0;
        for (k, measured) in chain.measured.iter().enumerate() {
            let Some(measured) = measured else { continue };
            let slope = DMatrix::from_fn(1, dim, |_, c| f64::from(u8::from(c == 2 * k)));
            let residual = DVector::from_element(1, measured - whole.mean[2 * k]);
            let seen = (residual, slope, DMatrix::from_element(1, 1, NOISE));
            evidence += whole.correct(0.0, 1, |_, _| Ok(Some(seen.clone()))).unwrap().unwrap();
        }
        let found = smoothed_walk(&chain, vec![DVector::zeros(2); n], 5, 1e-9);
        assert!((found.log_evidence.iter().sum::<f64>() - evidence).abs() < 1e-10);
        for (k, state) in found.states.iter().enumerate() {
            assert!((&state.mean - whole.mean.rows(2 * k, 2)).amax() < 1e-11, "step {k}");
            assert!((&state.covariance - whole.covariance.view((2 * k, 2 * k), (2, 2))).amax() < 1e-12, "step {k}");
        }
    }

    /// From either side of the origin it settles on its own branch, and both explain the distances as well.
    #[test]
    fn a_bent_measurement_settles_where_it_started() {
        let mut chain = walk(true, None);
        chain.start.mean.fill(0.0);
        let side = |sign: f64| smoothed_walk(&chain, vec![DVector::from_element(2, sign); chain.len()], 30, 1e-9);
        let (left, right) = (side(-1.0), side(1.0));
        assert!(left.states.iter().all(|s| s.mean[0] < -0.5) && right.states.iter().all(|s| s.mean[0] > 0.5));
        assert!(left.log_evidence.iter().zip(&right.log_evidence).all(|(l, r)| (l - r).abs() < 1e-9));
    }

    /// What comes after a fresh start says nothing of what was before it.
    #[test]
    fn a_fresh_start_cuts_the_chain() {
        let (whole, cut) = (walk(false, None), walk(false, Some(5)));
        let smoothed = |chain: &Walk| smoothed_walk(chain, vec![DVector::zeros(2); chain.len()], 3, 1e-9).states;
        let short = Walk { measured: whole.measured[..5].to_vec(), ..walk(false, None) };
        assert_eq!(smoothed(&cut)[..5], smoothed(&short)[..]);
        assert!((&smoothed(&whole)[4].mean - &smoothed(&cut)[4].mean).amax() > 1e-3);
        assert!(settle(&whole, Vec::new(), 3, 0.1).is_err());
    }
}
