//! A mixture of Gaussians over the state: components that split where a measurement bends over their spread, and merge again.
//!
//! With one component, and nothing to split, it is the (iterated) extended Kalman filter. A posterior with two branches,
//! such as the two depths at which a viewing ray meets a sphere, needs no particles: two components hold both.
//! Splitting after Vittaldev & Russell, "Multidirectional Gaussian mixture models for nonlinear uncertainty propagation",
//! CMES 111(1), 2016; merging after Salmond, "Mixture reduction algorithms for target tracking", IEE Colloquium 1989.

use crate::Result;
use crate::filter::{Gaussian, Linear};
use crate::particles::{LOWER, NORMAL_UPPER, UPPER};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A standard normal as five narrower ones: places, weights, and the standard deviation of each.
const PLACES: [f64; 5] = [-1.689_972_9, -0.800_928_3, 0.0, 0.800_928_3, 1.689_972_9];
const SHARES: [f64; 5] = [0.076_321_6, 0.247_441_7, 0.352_473_4, 0.247_441_7, 0.076_321_6];
const NARROWER: f64 = 0.442_255_5;

/// A quantile is looked for until it moves by less than this share of where it may be; at most so often.
const ENOUGH: f64 = 1e-9;
const MOST_TURNS: usize = 60;

/// How many components there may be, and when two of them are one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reduction {
    /// Components that are kept, the heaviest.
    pub most: usize,
    /// Squared Mahalanobis distance below which two are merged.
    pub merge_within: f64,
    /// A component of less weight goes.
    pub least_weight: f64,
}

/// One Gaussian of a mixture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Where it is.
    pub gaussian: Gaussian,
    /// Logarithm of its share.
    pub log_weight: f64,
}

/// Weighted Gaussians; the weights sum to one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mixture {
    components: Vec<Component>,
}

impl Mixture {
    /// One Gaussian.
    pub fn new(gaussian: Gaussian) -> Self {
        Self { components: vec![Component { gaussian, log_weight: 0.0 }] }
    }

    /// Several, whose weights are made to sum to one.
    pub fn of(components: Vec<Component>) -> Self {
        let mut mixture = Self { components };
        mixture.normalise();
        mixture
    }

    /// The Gaussians, in no order that means anything.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Change every Gaussian alike, such as by a motion.
    pub fn for_each(&mut self, change: impl Fn(&mut Gaussian)) {
        self.components.iter_mut().for_each(|component| change(&mut component.gaussian));
    }

    /// Correct every component by what `linearise` says about a state, given the component's covariance (nothing: it has
    /// nothing to say), relinearised `times` times; weigh them by their evidence. Returns the log evidence of all; none
    /// where nothing was said. A component that cannot be corrected, such as one behind the camera, is dropped beside others.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], at the time given; what `linearise` gives: where no component is left.
    pub fn correct(
        &mut self,
        time_s: f64,
        times: usize,
        linearise: impl Fn(&DVector<f64>, &DMatrix<f64>) -> Result<Option<Linear>>,
    ) -> Result<Option<f64>> {
        let (mut said, mut failed) = (false, None);
        self.components.retain_mut(|component| match component.gaussian.correct(time_s, times, &linearise) {
            Ok(evidence) => {
                said |= evidence.is_some();
                component.log_weight += evidence.unwrap_or(0.0);
                true
            }
            Err(error) => {
                failed = Some(error);
                false
            }
        });
        match failed {
            Some(error) if self.components.is_empty() => Err(error),
            None if !said => Ok(None),
            _ => {
                let evidence = self.normalise();
                Ok(said.then_some(evidence))
            }
        }
    }

    /// Split components along the direction that `bent` gives of a Gaussian, `(D,)` of unit length in the columns that
    /// matter, until none of them is bent or there are `most`.
    pub fn split(&mut self, most: usize, bent: impl Fn(&Gaussian) -> Option<DVector<f64>>) {
        let mut at = 0;
        while at < self.components.len() && self.components.len() + PLACES.len() - 1 <= most {
            match bent(&self.components[at].gaussian) {
                Some(direction) => {
                    let whole = self.components.swap_remove(at);
                    self.components.extend(parts(&whole, &direction));
                }
                None => at += 1,
            }
        }
    }

    /// Merge what is near, drop what is light.
    pub fn reduce(&mut self, limits: &Reduction) {
        self.components.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
        let least = limits.least_weight.ln();
        self.components.retain(|component| component.log_weight >= least);
        let mut kept: Vec<Component> = Vec::with_capacity(self.components.len());
        for component in self.components.drain(..) {
            let near = kept.iter().position(|other| distance(other, &component) < limits.merge_within);
            match near {
                Some(k) => kept[k] = merged(&kept[k], &component),
                None => kept.push(component),
            }
        }
        kept.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
        kept.truncate(limits.most.max(1));
        self.components = kept;
        self.normalise();
    }

    /// Forget some of what told the components apart: weights to the power of `kept`, 0 to 1. Those of the parts of one that was
    /// split become more alike too, so that it grows somewhat wider until it is seen again.
    pub fn forget(&mut self, kept: f64) {
        self.components.iter_mut().for_each(|component| component.log_weight *= kept);
        self.normalise();
    }

    /// Mean `(D,)` and covariance `(D, D)` of all.
    pub fn moments(&self) -> (DVector<f64>, DMatrix<f64>) {
        let dim = self.components[0].gaussian.mean.len();
        let (mut mean, mut covariance) = (DVector::zeros(dim), DMatrix::zeros(dim, dim));
        for Component { gaussian, log_weight } in &self.components {
            mean.axpy(log_weight.exp(), &gaussian.mean, 1.0);
        }
        for Component { gaussian, log_weight } in &self.components {
            let (weight, apart) = (log_weight.exp(), &gaussian.mean - &mean);
            covariance += &gaussian.covariance * weight;
            covariance.ger(weight, &apart, &apart, 1.0);
        }
        (mean, covariance)
    }

    /// Shares of the components, in their order, where of what told them apart only so much counts: weights to the power of
    /// `kept`, 0 to 1.
    pub fn shares_told(&self, kept: f64) -> Vec<f64> {
        let shares: Vec<f64> = self.components.iter().map(|component| (kept * component.log_weight).exp()).collect();
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|share| share / sum).collect()
    }

    /// Mean `(D,)` of all, and the covariance `(D, D)` about it of [`Mixture::shares_told`].
    pub fn moments_told(&self, kept: f64) -> (DVector<f64>, DMatrix<f64>) {
        let (mean, mut covariance) = self.moments();
        covariance.fill(0.0);
        for (Component { gaussian, .. }, share) in self.components.iter().zip(self.shares_told(kept)) {
            let apart = &gaussian.mean - &mean;
            covariance += &gaussian.covariance * share;
            covariance.ger(share, &apart, &apart, 1.0);
        }
        (mean, covariance)
    }

    /// The value below which `share` of a sum of normal distributions lies; each: weight, mean, standard deviation.
    pub fn quantile(parts: &[(f64, f64, f64)], share: f64) -> f64 {
        let reach = |sign: f64| {
            let ends = parts.iter().map(|(_, mean, sd)| mean + sign * 8.0 * sd);
            if sign < 0.0 { ends.fold(f64::INFINITY, f64::min) } else { ends.fold(f64::NEG_INFINITY, f64::max) }
        };
        let (mut low, mut high) = (reach(-1.0), reach(1.0));
        let enough = ENOUGH * (high - low);
        let mean: f64 = parts.iter().map(|(weight, mean, _)| weight * mean).sum();
        let variance: f64 = parts.iter().map(|(weight, at, sd)| weight * (sd * sd + (at - mean).powi(2))).sum();
        // Where one normal distribution has it, nearly.
        let mut at = mean + NORMAL_UPPER * (2.0 * share - 1.0) / (UPPER - LOWER) * variance.sqrt();
        for _ in 0..MOST_TURNS {
            let (mut below, mut density) = (-share, 0.0);
            for (weight, mean, sd) in parts {
                let off = (at - mean) / sd;
                below += weight * normal_below(off);
                density += weight * (-0.5 * off * off).exp() / (sd * TAU.sqrt());
            }
            (low, high) = if below < 0.0 { (at, high) } else { (low, at) };
            // Newton's step, where it leads between what is known; else half-way.
            let step = at - below / density;
            let next = if step > low && step < high { step } else { 0.5 * (low + high) };
            if (next - at).abs() < enough {
                return next;
            }
            at = next;
        }
        at
    }

    /// Weights to a sum of one; returns the logarithm of what they summed to.
    fn normalise(&mut self) -> f64 {
        let largest = self.components.iter().map(|c| c.log_weight).fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = self.components.iter().map(|c| (c.log_weight - largest).exp()).sum();
        let log_sum = largest + sum.ln();
        self.components.iter_mut().for_each(|c| c.log_weight -= log_sum);
        log_sum
    }
}

/// A standard normal as narrower ones: place and logarithm of the weight of each; and the standard deviation of all.
fn narrower() -> ([(f64, f64); PLACES.len()], f64) {
    let spread: f64 = PLACES.iter().zip(SHARES).map(|(place, share)| share * place * place).sum();
    let (scale, total) = (((1.0 - NARROWER * NARROWER) / spread).sqrt(), SHARES.iter().sum::<f64>());
    (std::array::from_fn(|k| (PLACES[k] * scale, (SHARES[k] / total).ln())), NARROWER)
}

/// Five narrower components along a direction; mean and covariance of all of them are those of the whole.
fn parts(whole: &Component, direction: &DVector<f64>) -> Vec<Component> {
    let Component { gaussian, log_weight } = whole;
    let sd = direction.dot(&(&gaussian.covariance * direction)).max(f64::MIN_POSITIVE).sqrt();
    // What goes with one standard deviation along the direction.
    let along = &gaussian.covariance * direction / sd;
    let (places, kept) = narrower();
    let mut covariance = gaussian.covariance.clone();
    covariance.ger(kept * kept - 1.0, &along, &along, 1.0);
    places
        .iter()
        .map(|(place, log_share)| Component {
            gaussian: Gaussian { mean: &gaussian.mean + &along * *place, covariance: covariance.clone() },
            log_weight: log_weight + log_share,
        })
        .collect()
}

/// Squared distance of two means in the narrower one's terms, largest over the columns: cheap, and enough to tell apart.
fn distance(a: &Component, b: &Component) -> f64 {
    let apart = &a.gaussian.mean - &b.gaussian.mean;
    let variance = |d: usize| a.gaussian.covariance[(d, d)].min(b.gaussian.covariance[(d, d)]).max(f64::MIN_POSITIVE);
    (0..apart.len()).map(|d| apart[d] * apart[d] / variance(d)).fold(0.0, f64::max)
}

/// One component of the same mean and covariance as the two.
fn merged(a: &Component, b: &Component) -> Component {
    let largest = a.log_weight.max(b.log_weight);
    let log_weight = largest + ((a.log_weight - largest).exp() + (b.log_weight - largest).exp()).ln();
    let share = (b.log_weight - log_weight).exp();
    let apart = &b.gaussian.mean - &a.gaussian.mean;
    let mean = &a.gaussian.mean + &apart * share;
    let mut covariance = &a.gaussian.covariance * (1.0 - share) + &b.gaussian.covariance * share;
    covariance.ger(share * (1.0 - share), &apart, &apart, 1.0);
    Component { gaussian: Gaussian { mean, covariance }, log_weight }
}

/// The standard normal distribution function, to 1.2e-7 (Numerical Recipes' erfc).
fn normal_below(x: f64) -> f64 {
    let z = x.abs() / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.5 * z);
    let series = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let sum = series.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let above = 0.5 * t * (-z * z + sum).exp();
    if x >= 0.0 { 1.0 - above } else { above }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaussian(mean: &[f64], covariance: &[f64]) -> Gaussian {
        let dim = mean.len();
        Gaussian { mean: DVector::from_column_slice(mean), covariance: DMatrix::from_row_slice(dim, dim, covariance) }
    }

    fn close(a: f64, b: f64, within: f64) {
        assert!((a - b).abs() <= within, "{a} is not {b} within {within}");
    }

    #[test]
    fn splitting_and_merging_keep_mean_and_covariance() {
        let one = gaussian(&[1.0, -2.0, 0.5], &[2.0, 0.6, 0.1, 0.6, 1.0, -0.2, 0.1, -0.2, 0.5]);
        let mut mixture = Mixture::new(one.clone());
        let direction = DVector::from_column_slice(&[0.6, 0.8, 0.0]);
        let is_whole = |g: &Gaussian| (direction.dot(&(&g.covariance * &direction)) > 1.0).then(|| direction.clone());
        mixture.split(30, is_whole);
        assert_eq!(mixture.components().len(), 5);
        let (mean, covariance) = mixture.moments();
        assert!((mean - &one.mean).amax() < 1e-12 && (covariance - &one.covariance).amax() < 1e-9);
        mixture.reduce(&Reduction { most: 12, merge_within: 1e9, least_weight: 1e-9 });
        assert_eq!(mixture.components().len(), 1);
        assert!((mixture.moments().1 - &one.covariance).amax() < 1e-9);
    }

    /// A prior over two places that a distance from the origin allows: both stay, and the middle goes.
    #[test]
    fn two_branches_are_both_kept() {
        let mut mixture = Mixture::new(gaussian(&[0.0], &[1.0]));
        let distance_of_one = |x: &DVector<f64>, _: &DMatrix<f64>| {
            let slope = if x[0] < 0.0 { -1.0 } else { 1.0 };
            let one = |v: f64| DMatrix::from_element(1, 1, v);
            Ok(Some((DVector::from_element(1, 1.0 - x[0].abs()), one(slope), one(0.01))))
        };
        mixture.split(5, |g| (g.covariance[0] > 0.05).then(|| DVector::from_element(1, 1.0)));
        mixture.correct(0.0, 3, distance_of_one).unwrap();
        mixture.reduce(&Reduction { most: 12, merge_within: 0.5, least_weight: 1e-4 });
        let left = mixture.components().iter().filter(|c| c.gaussian.mean[0] < 0.0);
        let share: f64 = left.map(|c| c.log_weight.exp()).sum();
        assert!((0.2..0.8).contains(&share), "{share} {:?}", mixture.components());
        assert!(mixture.components().iter().all(|c| (c.gaussian.mean[0].abs() - 1.0).abs() < 0.1));
    }

    /// Of two places the one beyond a border, where nothing can be seen: the other stays, alone; where none stays is an error.
    #[test]
    fn a_component_that_cannot_be_corrected_is_dropped() {
        let one = |mean| Component { gaussian: gaussian(&[mean], &[1.0]), log_weight: 0.5f64.ln() };
        let seen = |border: f64| {
            move |x: &DVector<f64>, _: &DMatrix<f64>| {
                let of = |v: f64| DMatrix::from_element(1, 1, v);
                let seen = (DVector::from_element(1, 0.5 - x[0]), of(1.0), of(1.0));
                if x[0] < border { Ok(Some(seen)) } else { Err(crate::Error::RanAway { time_s: 2.0 }) }
            }
        };
        let mut mixture = Mixture::of(vec![one(0.0), one(9.0)]);
        assert!(mixture.correct(2.0, 2, seen(5.0)).unwrap().is_some());
        assert_eq!(mixture.components().len(), 1);
        close(mixture.components()[0].log_weight, 0.0, 1e-12);
        close(mixture.components()[0].gaussian.mean[0], 0.25, 1e-12);
        assert!(matches!(mixture.correct(2.0, 1, seen(-5.0)), Err(crate::Error::RanAway { .. })));
    }

    #[test]
    fn what_is_forgotten_makes_components_more_alike() {
        let one = |mean, share: f64| Component { gaussian: gaussian(&[mean], &[1.0]), log_weight: share.ln() };
        let mut mixture = Mixture::of(vec![one(0.0, 0.9), one(5.0, 0.1)]);
        mixture.forget(1.0);
        close(mixture.components()[0].log_weight.exp(), 0.9, 1e-12);
        mixture.forget(0.5);
        close(mixture.components()[0].log_weight.exp(), 0.75, 1e-12);
        mixture.forget(0.0);
        close(mixture.components()[1].log_weight.exp(), 0.5, 1e-12);
    }

    #[test]
    fn bands_may_take_less_for_told_than_means_do() {
        let one = |mean, share: f64| Component { gaussian: gaussian(&[mean], &[1.0]), log_weight: share.ln() };
        let mixture = Mixture::of(vec![one(0.0, 0.9), one(5.0, 0.1)]);
        close(mixture.shares_told(0.5)[1], 0.25, 1e-12);
        let (mean, covariance) = mixture.moments_told(0.5);
        close(mean[0], 0.5, 1e-12);
        close(covariance[0], 1.0 + 0.75 * 0.25 + 0.25 * 4.5 * 4.5, 1e-12);
        let (all, told) = (mixture.moments().1, mixture.moments_told(1.0).1);
        close(all[0], told[0], 1e-12);
    }

    #[test]
    fn quantiles_of_one_and_of_two() {
        close(Mixture::quantile(&[(1.0, 2.0, 3.0)], 0.975), 2.0 + 3.0 * 1.959_964, 1e-4);
        close(Mixture::quantile(&[(0.5, -10.0, 1.0), (0.5, 10.0, 1.0)], 0.25), -10.0, 1e-4);
        close(normal_below(0.0), 0.5, 1e-7);
        close(normal_below(-1.0), 0.158_655_25, 2e-7);
    }
}
