//! Smoothed recordings of an arm, weighed: the delays at which frames were put, and the ways in which the arm may have gone.

use super::state::{PLACES, WRIST};
use crate::estimate::{Estimate, Point};

/// What has less weight is left out.
const LEAST: f64 = 1e-4;
/// What a worn sensor's errors make of so many frames is alike: ways are told apart by evidence divided by it.
const ALIKE: f64 = 4.0;

/// A delay of the camera, and what became of the recording with it.
pub(super) struct Delayed<T> {
    /// By how much the camera sees later, s.
    pub delay_s: f64,
    /// By prior and evidence, per s of delay.
    pub log_density: f64,
    /// What was found.
    pub of: T,
}

/// A way in which the arm may have gone, with each delay and its weight.
pub(super) struct Way<T> {
    /// Of all delays together.
    pub log_density: f64,
    /// Delays with their weights.
    pub delayed: Vec<(f64, Delayed<T>)>,
}

/// The delays of every way that weigh something with the weight of each, the heaviest first; all weights sum to one.
pub(super) fn weighed<T>(ways: Vec<Way<T>>) -> Vec<Vec<(f64, Delayed<T>)>> {
    let most = ways.iter().map(|way| way.log_density).fold(f64::NEG_INFINITY, f64::max);
    let shares: Vec<f64> = ways.iter().map(|way| ((way.log_density - most) / ALIKE).exp()).collect();
    let sum: f64 = shares.iter().sum();
    let heavy = |(way, share): (Way<T>, f64)| {
        let each = way.delayed.into_iter().map(|(weight, delayed)| (share / sum * weight, delayed));
        let mut heavy: Vec<_> = each.filter(|(weight, _)| *weight > LEAST).collect();
        heavy.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        heavy
    };
    let mut parts: Vec<Vec<_>> = ways.into_iter().zip(shares).map(heavy).filter(|way| !way.is_empty()).collect();
    let sum: f64 = parts.iter().flatten().map(|(weight, _)| weight).sum();
    parts.iter_mut().flatten().for_each(|(weight, _)| *weight /= sum);
    parts
}

/// Log density of delays in increasing order together, and the weight of each for the stretch about it; one that is alone stands for
/// `alone_s`.
pub(super) fn weights<T>(found: &[Delayed<T>], alone_s: f64) -> (f64, Vec<f64>) {
    let most = found.iter().map(|one| one.log_density).fold(f64::NEG_INFINITY, f64::max);
    let at = |k: usize| found[k].delay_s;
    let last = found.len() - 1;
    let width = |k: usize| if last == 0 { alone_s } else { at((k + 1).min(last)) - at(k.saturating_sub(1)) };
    let each: Vec<f64> = (0..found.len()).map(|k| (found[k].log_density - most).exp() * width(k)).collect();
    let sum: f64 = each.iter().sum();
    (most + sum.ln(), each.into_iter().map(|weight| weight / sum).collect())
}

/// One estimate of a frame from those of all ways and delays; the delay is the last column of its state.
pub(super) fn together(parts: &[(f64, Delayed<Estimate>)]) -> Estimate {
    let of = |one: &Delayed<Estimate>| one.of.state.mean.push(one.delay_s);
    let mut mean = of(&parts[0].1) * 0.0;
    for (weight, one) in parts {
        mean += of(one) * *weight;
    }
    let dim = mean.len();
    let mut covariance = &mean * mean.transpose() * 0.0;
    for (weight, one) in parts {
        let off = of(one) - &mean;
        covariance += &off * off.transpose() * *weight;
        let mut own = covariance.view_mut((0, 0), (dim - 1, dim - 1));
        own += &one.of.state.covariance * *weight;
    }
    let point = |place: usize| {
        let each = parts.iter().map(|(weight, one)| (*weight, &one.of.places[place]));
        Point::together(&each.collect::<Vec<_>>())
    };
    let places: Vec<Point> = (0..PLACES.len()).map(point).collect();
    let state = places[WRIST].with_state(mean, covariance);
    let evidence = parts.iter().map(|(weight, one)| weight * one.of.log_evidence.unwrap_or(0.0)).sum();
    Estimate { state, places, log_evidence: Some(evidence), ..parts[0].1.of.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delayed(delay_s: f64, log_density: f64) -> Delayed<()> {
        Delayed { delay_s, log_density, of: () }
    }

    /// The sum over delays is the density's integral, however closely they were tried.
    #[test]
    fn delays_stand_for_the_stretch_about_them() {
        let at = |delays: &[f64]| delays.iter().map(|d| delayed(*d, -0.5 * (d / 0.01).powi(2))).collect::<Vec<_>>();
        let even: Vec<f64> = (-40..=40).map(|k| 0.001 * f64::from(k)).collect();
        let finer: Vec<f64> = (-80..=80).map(|k| 0.0005 * f64::from(k)).collect();
        let (integral, weights_of_even) = weights(&at(&even), 1.0);
        assert!((integral - weights(&at(&finer), 1.0).0).abs() < 1e-3);
        assert!((weights_of_even.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // As much as one of several that are so far apart.
        assert!((weights(&[delayed(0.0, 0.0)], 0.002).0 - 0.002f64.ln()).abs() < 1e-12);
    }

    /// Ways are told apart by a quarter of their evidence; what has next to no weight goes.
    #[test]
    fn ways_share_by_tempered_evidence() {
        let way = |log_density| Way { log_density, delayed: vec![(1.0, delayed(0.0, log_density))] };
        let found = weighed(vec![way(-100.0), way(-104.0), way(-200.0)]);
        let shares: Vec<f64> = found.iter().flatten().map(|part| part.0).collect();
        assert_eq!(shares.len(), 2);
        assert!((shares[0] / shares[1] - 1f64.exp()).abs() < 1e-12);
        assert!((shares[0] + shares[1] - 1.0).abs() < 1e-12);
    }
}
