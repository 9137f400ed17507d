//! Smoothed recordings of an arm, weighed: the delays at which frames were put, and the ways in which the arm may have gone.

use crate::arm::state::{PLACES, WRIST};
use crate::estimate::{Estimate, Point};

/// What has less weight is left out.
const LEAST: f64 = 1e-4;
/// What a worn sensor's errors make of so many frames is alike: ways are told apart by how well they explain, divided by it.
const ALIKE: f64 = 2.0;

/// A delay of the camera, and what became of the recording with it.
pub(super) struct Delayed<T> {
    /// By how much the camera sees later, s.
    pub delay_s: f64,
    /// By prior and evidence, per s of delay.
    pub log_density: f64,
    /// How well it explains what was measured and how it moves, by prior and likelihood.
    pub log_fit: f64,
    /// What was found.
    pub of: T,
}

/// A way in which the arm may have gone: delays with their weights.
///
/// Ways are not told apart by evidence, as delays are: it counts in every frame anew how far a trajectory may stray and explain as much,
/// and where the arm is folded, or the ray grazes its sphere, that is so much farther that slow movements were put at the wrong depth.
pub(super) struct Way<T>(pub Vec<(f64, Delayed<T>)>);

impl<T> Way<T> {
    /// How well its likeliest delay explains the recording.
    fn log_fit(&self) -> f64 {
        let likeliest = self.0.iter().max_by(|(a, _), (b, _)| a.total_cmp(b));
        likeliest.map_or(f64::NEG_INFINITY, |(_, delayed)| delayed.log_fit)
    }
}

/// The delays of every way that weigh something with the weight of each, the heaviest first; all weights sum to one.
pub(super) fn weighed<T>(ways: Vec<Way<T>>) -> Vec<Vec<(f64, Delayed<T>)>> {
    let most = ways.iter().map(Way::log_fit).fold(f64::NEG_INFINITY, f64::max);
    let shares: Vec<f64> = ways.iter().map(|way| ((way.log_fit() - most) / ALIKE).exp()).collect();
    let sum: f64 = shares.iter().sum();
    let heavy = |(way, share): (Way<T>, f64)| {
        let each = way.0.into_iter().map(|(weight, delayed)| (share / sum * weight, delayed));
        let mut heavy: Vec<_> = each.filter(|(weight, _)| *weight > LEAST).collect();
        heavy.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        heavy
    };
    let mut parts: Vec<Vec<_>> = ways.into_iter().zip(shares).map(heavy).filter(|way| !way.is_empty()).collect();
    let sum: f64 = parts.iter().flatten().map(|(weight, _)| weight).sum();
    parts.iter_mut().flatten().for_each(|(weight, _)| *weight /= sum);
    parts
}

/// The weight of each of some delays in increasing order, for the stretch about it.
pub(super) fn weights<T>(found: &[Delayed<T>]) -> Vec<f64> {
    let most = found.iter().map(|one| one.log_density).fold(f64::NEG_INFINITY, f64::max);
    let at = |k: usize| found[k].delay_s;
    let last = found.len() - 1;
    let width = |k: usize| if last == 0 { 1.0 } else { at((k + 1).min(last)) - at(k.saturating_sub(1)) };
    let each: Vec<f64> = (0..found.len()).map(|k| (found[k].log_density - most).exp() * width(k)).collect();
    let sum: f64 = each.iter().sum();
    each.into_iter().map(|weight| weight / sum).collect()
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
        Delayed { delay_s, log_density, log_fit: log_density, of: () }
    }

    /// However closely they were tried, delays have the same say.
    #[test]
    fn delays_stand_for_the_stretch_about_them() {
        let early = |delays: Vec<f64>| {
            let found: Vec<_> = delays.iter().map(|d| delayed(*d, -0.5 * (d / 0.01).powi(2))).collect();
            let weights = weights(&found);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            found.iter().zip(weights).filter(|(one, _)| one.delay_s < -0.005).map(|(_, weight)| weight).sum::<f64>()
        };
        let coarse = early((-40..=40).map(|k| 0.001 * f64::from(k)).collect());
        let finer =
            early((-40..0).map(|k| 0.001 * f64::from(k)).chain((0..=80).map(|k| 0.0005 * f64::from(k))).collect());
        assert!((coarse - finer).abs() < 1e-3);
        assert_eq!(weights(&[delayed(0.0, -7.0)]), [1.0]);
    }

    /// Ways are told apart by half of how well they explain; what has next to no weight goes.
    #[test]
    fn ways_share_by_tempered_fit() {
        let way = |log_density| Way(vec![(1.0, delayed(0.0, log_density))]);
        let found = weighed(vec![way(-100.0), way(-102.0), way(-200.0)]);
        let shares: Vec<f64> = found.iter().flatten().map(|part| part.0).collect();
        assert_eq!(shares.len(), 2);
        assert!((shares[0] / shares[1] - 1f64.exp()).abs() < 1e-12);
        assert!((shares[0] + shares[1] - 1.0).abs() < 1e-12);
    }
}
