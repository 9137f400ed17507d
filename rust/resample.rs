//! Resampling: `(weights, n, rng) -> indices`, pure functions of normalised weights.
//!
//! Every scheme is unbiased: particle `i` is drawn `n * weight[i]` times on average, also where that is less
//! than one. The indices come out in ascending order. Weights whose sum falls short of one by rounding never
//! give an index beyond the last particle with weight.
//!
//! Douc, Cappé & Moulines, "Comparison of resampling schemes for particle filtering", ISPA 2005.

use crate::rng::Stream;
use crate::{Error, Result};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// How the next generation is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scheme {
    /// Independent draws.
    Multinomial,
    /// One draw in each of `n` equal strata.
    Stratified,
    /// One draw for all strata.
    Systematic,
    /// `floor(n * weight)` copies, the rest by independent draws from the remainders (Tao & Hu III-E).
    Residual,
}

impl Scheme {
    /// The names that [`Scheme::from_name`] knows.
    pub const NAMES: &'static str = "multinomial, stratified, systematic, residual";

    /// From its lower-case name.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "multinomial" => Ok(Self::Multinomial),
            "stratified" => Ok(Self::Stratified),
            "systematic" => Ok(Self::Systematic),
            "residual" => Ok(Self::Residual),
            _ => Err(Error::UnknownName { what: "resampling", name: name.into(), known: Self::NAMES }),
        }
    }

    /// Draw `n` ancestors, ascending, from `weights` (normalised, at least one positive) into `ancestors`.
    pub fn draw(self, weights: &[f64], n: usize, rng: &mut Stream, ancestors: &mut Vec<u32>) {
        ancestors.clear();
        match self {
            Self::Stratified => walk(weights, n, ancestors, |_| rng.random()),
            Self::Systematic => {
                let offset: f64 = rng.random();
                walk(weights, n, ancestors, |_| offset);
            }
            Self::Multinomial => {
                let mut counts = vec![0; weights.len()];
                draw_counts(weights, n, rng, &mut counts);
                expand(&counts, n, ancestors);
            }
            Self::Residual => {
                let (mut counts, remainders, left) = residuals(weights, n);
                draw_counts(&remainders, left, rng, &mut counts);
                expand(&counts, n, ancestors);
            }
        }
    }
}

/// Walk the cumulative weights past the points `(k + u(k)) / n`.
fn walk(weights: &[f64], n: usize, ancestors: &mut Vec<u32>, mut u: impl FnMut(usize) -> f64) {
    let last = last_positive(weights);
    let (mut index, mut cumulative) = (0, weights[0]);
    for k in 0..n {
        let point = (k as f64 + u(k)) / n as f64;
        while point >= cumulative && index < last {
            index += 1;
            cumulative += weights[index];
        }
        ancestors.push(index as u32);
    }
}

/// Copies `floor(n * weight)`, the remainders, and how many draws are left for them.
fn residuals(weights: &[f64], n: usize) -> (Vec<u32>, Vec<f64>, usize) {
    let mut left = n;
    let mut counts = Vec::with_capacity(weights.len());
    let mut remainders = Vec::with_capacity(weights.len());
    for weight in weights {
        let expected = weight * n as f64;
        // A sum of weights a rounding above one must not give more copies than there are places.
        let copies = (expected as usize).min(left);
        left -= copies;
        counts.push(copies as u32);
        remainders.push(expected - copies as f64);
    }
    (counts, remainders, left)
}

/// Add `n` independent draws in proportion to `weights` (any positive sum) to `counts`.
///
/// Each draw is looked up through a table of starting points ("cut points", Chen & Asau 1974), so it costs a
/// step or two whatever the number of particles.
fn draw_counts(weights: &[f64], n: usize, rng: &mut Stream, counts: &mut [u32]) {
    if n == 0 {
        return;
    }
    let mut sum = 0.0;
    let cumulative: Vec<f64> = weights
        .iter()
        .map(|w| {
            sum += w;
            sum
        })
        .collect();
    let last = last_positive(weights);
    let cells = weights.len();
    let per_cell = sum / cells as f64;
    let mut start = Vec::with_capacity(cells);
    let mut index = 0;
    for cell in 0..cells {
        while index < last && cumulative[index] <= cell as f64 * per_cell {
            index += 1;
        }
        start.push(index as u32);
    }
    for _ in 0..n {
        let u: f64 = rng.random();
        let mut index = start[(u * cells as f64) as usize] as usize;
        while index < last && u * sum >= cumulative[index] {
            index += 1;
        }
        counts[index] += 1;
    }
}

/// Write index `i` `counts[i]` times.
fn expand(counts: &[u32], n: usize, ancestors: &mut Vec<u32>) {
    ancestors.resize(n, 0);
    let mut at = 0;
    for (index, &count) in counts.iter().enumerate() {
        for slot in &mut ancestors[at..at + count as usize] {
            *slot = index as u32;
        }
        at += count as usize;
    }
    debug_assert_eq!(at, n);
}

/// The last particle that may be drawn at all.
fn last_positive(weights: &[f64]) -> usize {
    weights.iter().rposition(|w| *w > 0.0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;

    const ALL: [Scheme; 4] = [Scheme::Multinomial, Scheme::Stratified, Scheme::Systematic, Scheme::Residual];

    fn draw(scheme: Scheme, weights: &[f64], n: usize, seed: u64) -> Vec<u32> {
        let mut ancestors = Vec::new();
        scheme.draw(weights, n, &mut Stream::seed_from_u64(seed), &mut ancestors);
        ancestors
    }

    fn counts(ancestors: &[u32], len: usize) -> Vec<usize> {
        let mut counts = vec![0; len];
        for i in ancestors {
            counts[*i as usize] += 1;
        }
        counts
    }

    /// Weights with zeros, light (N·w < 1) and heavy particles, normalised.
    fn weights() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(prop_oneof![Just(0.0), 1e-9..1e-6f64, 0.0..1.0f64, 5.0..50.0f64], 1..60)
            .prop_filter("some weight", |w| w.iter().sum::<f64>() > 0.0)
            .prop_map(|w| {
                let sum: f64 = w.iter().sum();
                w.iter().map(|x| x / sum).collect()
            })
    }

    proptest! {
        #[test]
        fn draws_n_in_order_and_never_a_zero_weight(w in weights(), n in 1..200usize, seed: u64) {
            for scheme in ALL {
                let ancestors = draw(scheme, &w, n, seed);
                prop_assert_eq!(ancestors.len(), n);
                prop_assert!(ancestors.is_sorted());
                prop_assert!(ancestors.iter().all(|i| w[*i as usize] > 0.0), "{:?}", scheme);
            }
        }

        #[test]
        fn copies_stay_within_the_scheme_bounds(w in weights(), n in 1..200usize, seed: u64) {
            let systematic = counts(&draw(Scheme::Systematic, &w, n, seed), w.len());
            let residual = counts(&draw(Scheme::Residual, &w, n, seed), w.len());
            for i in 0..w.len() {
                let expected = w[i] * n as f64;
                // Rounding of the cumulative sum may move a point across a border that it sits on.
                prop_assert!((systematic[i] as f64 - expected).abs() < 1.0 + 1e-9);
                prop_assert!(residual[i] as f64 > expected - 1.0 - 1e-9);
            }
        }

        #[test]
        fn a_short_sum_never_runs_over_the_end(n in 1..300usize, seed: u64) {
            let w = [0.3, 0.7 - 1e-9, 0.0];
            for scheme in ALL {
                prop_assert!(draw(scheme, &w, n, seed).iter().all(|i| *i < 2));
            }
        }
    }

    /// Each scheme's mean count is `n * weight` within five standard errors, light particles included.
    #[test]
    fn unbiased_over_many_seeds() {
        let w = [0.001, 0.02, 0.0, 0.3, 0.079, 0.6];
        let (n, seeds) = (10, 40_000);
        for scheme in ALL {
            let mut total = [0usize; 6];
            for seed in 0..seeds {
                for i in draw(scheme, &w, n, seed) {
                    total[i as usize] += 1;
                }
            }
            for i in 0..w.len() {
                let mean = total[i] as f64 / seeds as f64;
                let expected = w[i] * n as f64;
                let standard_error = (expected * (1.0 - w[i]) / seeds as f64).sqrt();
                assert!((mean - expected).abs() <= 5.0 * standard_error, "{scheme:?} particle {i}: {mean}");
            }
        }
    }

    #[test]
    fn equal_weights_keep_every_particle_once() {
        let w = vec![1.0 / 64.0; 64];
        for scheme in [Scheme::Stratified, Scheme::Systematic, Scheme::Residual] {
            assert_eq!(counts(&draw(scheme, &w, 64, 3), 64), vec![1; 64], "{scheme:?}");
        }
    }

    #[test]
    fn unknown_name_lists_the_known() {
        let message = Scheme::from_name("resedual").unwrap_err().to_string();
        assert!(message.contains("resedual") && message.contains("systematic"));
    }
}
