//! Bayes' rule on a particle set: weights times likelihoods, in logarithms so that nothing underflows.

use super::ParticleSet;
use super::exponential::exp;
use crate::rng::BLOCK;
use crate::sums::sum;
use multiversion::multiversion;
use rayon::prelude::*;

impl ParticleSet {
    /// Multiply the weights by likelihoods given as logarithms, and normalise.
    ///
    /// Returns the log of the weighted mean likelihood (the evidence of this observation), or `None`, with
    /// the weights unchanged, when every weight would be zero or one is not a number.
    ///
    /// # Panics
    /// When `log_likelihood` has another length than the set.
    pub fn reweigh(&mut self, log_likelihood: &[f64]) -> Option<f64> {
        assert_eq!(log_likelihood.len(), self.len, "one value a particle");
        let largest = self.largest_sum(log_likelihood)?;
        let work = |((weights, logs), likelihood): ((&mut [f64], &mut [f64]), &[f64])| {
            weigh(weights, logs, likelihood, largest);
            sum(weights)
        };
        let scaled = |scale: f64| move |weights: &mut [f64]| weights.iter_mut().for_each(|w| *w *= scale);
        let total: f64;
        if self.is_parallel() {
            let blocks = self.weights.par_chunks_mut(BLOCK).zip(self.log_weights.par_chunks_mut(BLOCK));
            let sums: Vec<f64> = blocks.zip(log_likelihood.par_chunks(BLOCK)).map(work).collect();
            total = sums.iter().sum();
            self.weights.par_chunks_mut(BLOCK).for_each(scaled(1.0 / total));
        } else {
            let blocks = self.weights.chunks_mut(BLOCK).zip(self.log_weights.chunks_mut(BLOCK));
            total = blocks.zip(log_likelihood.chunks(BLOCK)).map(work).sum();
            self.weights.chunks_mut(BLOCK).for_each(scaled(1.0 / total));
        }
        let evidence = largest + total.ln() - self.log_sum;
        self.log_sum = total.ln();
        Some(evidence)
    }

    /// The largest `log_weight + log_likelihood`; `None` where that is not finite or any is not a number.
    fn largest_sum(&self, log_likelihood: &[f64]) -> Option<f64> {
        let work = |(logs, likelihood): (&[f64], &[f64])| {
            let (mut largest, mut is_nan) = (f64::NEG_INFINITY, false);
            for (w, l) in logs.iter().zip(likelihood) {
                let sum = w + l;
                is_nan |= sum.is_nan();
                largest = if sum > largest { sum } else { largest };
            }
            if is_nan { f64::NAN } else { largest }
        };
        let pick = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
        let largest = if self.is_parallel() {
            let blocks = self.log_weights.par_chunks(BLOCK).zip(log_likelihood.par_chunks(BLOCK));
            blocks.map(work).reduce(|| f64::NEG_INFINITY, pick)
        } else {
            self.log_weights.chunks(BLOCK).zip(log_likelihood.chunks(BLOCK)).map(work).fold(f64::NEG_INFINITY, pick)
        };
        largest.is_finite().then_some(largest)
    }
}

/// Add the log-likelihoods, less the largest sum, and take the exponential.
#[multiversion(targets("x86_64+avx2"))]
fn weigh(weights: &mut [f64], logs: &mut [f64], likelihood: &[f64], largest: f64) {
    for ((w, log), l) in weights.iter_mut().zip(logs).zip(likelihood) {
        *log += l - largest;
        *w = exp(*log);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sums::dot;

    fn ramp(len: usize) -> ParticleSet {
        ParticleSet::from_rows(1, &(0..len).map(|i| i as f64).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn evidence_is_the_weighted_mean_likelihood() {
        let mut set = ramp(4);
        let evidence = set.reweigh(&[1f64.ln(), 2f64.ln(), 3f64.ln(), 6f64.ln()]).unwrap();
        assert!((evidence - 3f64.ln()).abs() < 1e-14);
        assert!((set.ess() - 144.0 / 50.0).abs() < 1e-12);
        // Very small likelihoods do not underflow.
        let evidence = set.reweigh(&[-5000.0; 4]).unwrap();
        assert!((evidence + 5000.0).abs() < 1e-9);
    }

    /// What the processor at hand runs and what every processor could run give the same bits.
    #[test]
    fn wider_vectors_change_no_bit() {
        let mut set = ramp(700);
        let likelihood: Vec<f64> = (0..700).map(|i| -0.01 * f64::from(i) * f64::from(i % 13)).collect();
        set.reweigh(&likelihood).unwrap();
        let plain: Vec<f64> = likelihood.iter().map(|l| exp(*l)).collect();
        let total: f64 = plain.chunks(BLOCK).map(sum).sum();
        assert!(set.weights.iter().zip(&plain).all(|(w, p)| *w == p * (1.0 / total)));
        let (mean, _) = set.moments();
        let (x, w) = (set.blocks().map(|b| b.column(0).to_vec()).collect::<Vec<_>>(), set.weights.chunks(BLOCK));
        let plain: f64 = x.iter().zip(w).map(|(x, w)| dot(x, w)).sum();
        assert_eq!(mean[0], plain);
    }

    #[test]
    fn no_weight_left_is_said_and_changes_nothing() {
        let mut set = ramp(3);
        let before = set.clone();
        assert_eq!(set.reweigh(&[f64::NEG_INFINITY; 3]), None);
        assert_eq!(set.reweigh(&[0.0, f64::NAN, 0.0]), None);
        assert_eq!(set, before);
    }
}
