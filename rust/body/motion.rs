//! How the body moves: the paper's zero-order dynamics (IV-C1), and arms drawn anew.
//!
//! An arm that was lost is far from where it was; normal steps would take seconds to find it again. A small share of
//! the particles therefore draws an arm from all that its joints allow. Not in the paper, where it is 0.

use super::figure::Figure;
use super::joints::Group;
use crate::filter::Transition;
use crate::particles::BlockMut;
use crate::rng::Stream;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

/// An arm that may be drawn anew: its columns and their ranges, rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Anew {
    columns: Vec<(usize, [f64; 2])>,
}

impl Anew {
    /// The arms among `groups`; a joint without limits has a full turn.
    pub fn arms(figure: &Figure, groups: &[Group]) -> Vec<Self> {
        let arms = groups.iter().filter(|group| **group != Group::Torso);
        arms.map(|arm| {
            let of_arm = (0..figure.groups.len()).filter(|d| figure.groups[*d] == *arm);
            let columns = of_arm.map(|d| {
                let [low, high] = figure.limits[d];
                (d, if low.is_finite() && high.is_finite() { [low, high] } else { [-PI, PI] })
            });
            Self { columns: columns.collect() }
        })
        .collect()
    }

    /// Log-density of drawing `to`.
    fn log_density(&self, to: &[f64]) -> f64 {
        let within = |(d, [low, high]): &(usize, [f64; 2])| (*low..=*high).contains(&to[*d]);
        if !self.columns.iter().all(within) {
            return f64::NEG_INFINITY;
        }
        -self.columns.iter().map(|(_, [low, high])| (high - low).ln()).sum::<f64>()
    }
}

/// A normal step in every column; with a small chance an arm is drawn anew instead.
#[derive(Debug, Clone, PartialEq)]
pub struct Walk {
    /// Standard deviation of every column.
    pub sd: Vec<f64>,
    /// Arms that may be drawn anew.
    pub anew: Vec<Anew>,
    /// Chance of each.
    pub share: f64,
}

impl Walk {
    /// Log-density of a normal step in one column; a column that does not move must stay.
    fn step(&self, d: usize, from: f64, to: f64) -> f64 {
        let sd = self.sd[d];
        if sd > 0.0 {
            -0.5 * ((to - from) / sd).powi(2) - (sd * TAU.sqrt()).ln()
        } else if to.total_cmp(&from).is_eq() {
            0.0
        } else {
            f64::NEG_INFINITY
        }
    }

    /// `ln p(to | from)` of one state.
    fn log_density(&self, from: &[f64], to: &[f64]) -> f64 {
        let is_arm = |d: usize| self.anew.iter().any(|arm| arm.columns.iter().any(|(column, _)| *column == d));
        let rest: f64 = (0..self.sd.len()).filter(|d| !is_arm(*d)).map(|d| self.step(d, from[d], to[d])).sum();
        let arms = self.anew.iter().map(|arm| {
            let walked: f64 = arm.columns.iter().map(|(d, _)| self.step(*d, from[*d], to[*d])).sum();
            ((1.0 - self.share) * walked.exp() + self.share * arm.log_density(to).exp()).ln()
        });
        rest + arms.sum::<f64>()
    }
}

impl Transition for Walk {
    fn propagate(&self, mut block: BlockMut<'_>, rng: &mut Stream) {
        for (d, sd) in self.sd.iter().enumerate().filter(|(_, sd)| **sd > 0.0) {
            for x in block.column_mut(d) {
                let z: f64 = rng.sample(StandardNormal);
                *x += sd * z;
            }
        }
        if self.share > 0.0 {
            for arm in &self.anew {
                for i in 0..block.len() {
                    if rng.random::<f64>() < self.share {
                        for (d, [low, high]) in &arm.columns {
                            block.column_mut(*d)[i] = low + (high - low) * rng.random::<f64>();
                        }
                    }
                }
            }
        }
    }

    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        for (out, from) in out.iter_mut().zip(from.chunks(to.len())) {
            *out = self.log_density(from, to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column that walks, one that stays, and an arm of two that may be drawn anew.
    fn walk(share: f64) -> Walk {
        let arm = Anew { columns: vec![(2, [-1.0, 1.0]), (3, [0.0, 2.0])] };
        Walk { sd: vec![0.1, 0.0, 0.2, 0.2], anew: vec![arm], share }
    }

    fn of(walk: &Walk, to: [f64; 4]) -> f64 {
        let mut out = [0.0];
        walk.log_densities(&[0.0, 0.5, 0.0, 1.0], &to, &mut out);
        out[0]
    }

    fn assert_near(found: f64, expected: f64, within: f64) {
        assert!((found - expected).abs() < within, "{found} is not {expected}");
    }

    fn normal(x: f64, sd: f64) -> f64 {
        -0.5 * (x / sd).powi(2) - (sd * TAU.sqrt()).ln()
    }

    #[test]
    fn near_it_is_the_walk_and_far_off_the_arm_drawn_anew() {
        let near = normal(0.05, 0.1) + (0.9 * (normal(0.1, 0.2) + normal(0.1, 0.2)).exp() + 0.1 * 0.25).ln();
        assert_near(of(&walk(0.1), [0.05, 0.5, 0.1, 1.1]), near, 1e-12);
        let far = normal(0.0, 0.1) + (0.1f64 * 0.25).ln();
        assert_near(of(&walk(0.1), [0.0, 0.5, 0.99, 0.01]), far, 1e-3);
        assert!(of(&walk(0.0), [0.0, 0.5, 0.99, 0.01]) < far - 10.0);
    }

    /// What no joint allows is walked to only; what does not move stays.
    #[test]
    fn what_cannot_be_reached_is_minus_infinity() {
        assert_eq!(of(&walk(0.1), [0.0, 0.6, 0.0, 1.0]), f64::NEG_INFINITY);
        assert_eq!(of(&Walk { sd: vec![0.0; 4], ..walk(0.1) }, [0.0, 0.5, 1.5, 1.0]), f64::NEG_INFINITY);
        assert!(of(&walk(0.1), [0.0, 0.5, 1.5, 1.0]).is_finite());
    }

    /// Over all places it adds up to one.
    #[test]
    fn it_is_a_density() {
        let walk = Walk {
            sd: vec![0.2, 0.2],
            anew: vec![Anew { columns: vec![(0, [-1.0, 1.0]), (1, [0.0, 2.0])] }],
            share: 0.3,
        };
        let step = 0.02;
        let grid = || (-150..=250).map(move |k| step * f64::from(k));
        let mut out = [0.0];
        let sum: f64 = grid()
            .flat_map(|x| grid().map(move |y| [x, y]))
            .map(|to| {
                walk.log_densities(&[0.1, 0.9], &to, &mut out);
                out[0].exp() * step * step
            })
            .sum();
        assert_near(sum, 1.0, 0.02);
    }
}
