//! Resampling: `(weights, n, rng) -> indices`, pure functions of normalised weights.
//!
//! Every scheme is unbiased: particle `i` is drawn `n * weight[i]` times on average, also where that is less
//! than one. The indices come out in ascending order. Weights whose sum falls short of one by rounding never
//! give an index beyond the last particle with weight.
//!
//! Douc, Cappé & Moulines, "Comparison of resampling schemes for particle filtering", ISPA 2005.

use crate::rng::Stream;
use crate::sums::{sum, sum_of};
use crate::{Error, Result};
use rand::{RngExt, SeedableRng};
use rand_distr::Exp1;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Particles that are walked over together, by one thread.
const GROUP: usize = 2048;

/// Up to this many groups, sharing them between threads costs more than it saves.
const SERIAL_GROUPS: usize = 16;

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
    pub fn draw(self, weights: &[f64], n: usize, rng: &mut Stream, ancestors: &mut Ancestors) {
        match self {
            Self::Stratified => strata(weights, n, &mut ancestors.indices, || rng.random()),
            Self::Systematic => {
                let offset: f64 = rng.random();
                strata(weights, n, &mut ancestors.indices, || offset);
            }
            Self::Multinomial => independent(weights, n, |_| 0.0, rng, ancestors),
            Self::Residual => independent(weights, n, floor, rng, ancestors),
        }
    }
}

/// Where the next generation comes from; memory that is kept from call to call.
#[derive(Debug, Clone, Default)]
pub struct Ancestors {
    indices: Vec<u32>,
    points: Vec<f64>,
}

impl Ancestors {
    /// Ascending indices of the last draw.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }
}

/// Walk the cumulative weights past the points `(k + u) / n`.
fn strata(weights: &[f64], n: usize, indices: &mut Vec<u32>, mut u: impl FnMut() -> f64) {
    let last = last_positive(weights);
    let (mut index, mut cumulative) = (0, weights[0]);
    indices.clear();
    for k in 0..n {
        let point = (k as f64 + u()) / n as f64;
        while point >= cumulative && index < last {
            index += 1;
            cumulative += weights[index];
        }
        indices.push(index as u32);
    }
}

/// `copies(n * weight)` of every particle, and independent draws in proportion to what that leaves.
///
/// Independent uniforms come sorted as normalised sums of exponentials (Devroye 1986, V.3), so that one walk
/// over the particles serves. The walk is done in groups of [`GROUP`] particles, which threads may share:
/// where a group starts follows from the sums of those before it.
fn independent(
    weights: &[f64],
    n: usize,
    copies: impl Fn(f64) -> f64 + Sync,
    rng: &mut Stream,
    ancestors: &mut Ancestors,
) {
    let places = n as f64;
    let Ancestors { indices, points } = ancestors;
    let left_by = |weights: &[f64]| {
        let copied = sum_of(weights, |weight| copies(weight * places));
        (copied, sum(weights) * places - copied)
    };
    let is_parallel = weights.len() > SERIAL_GROUPS * GROUP;
    let groups: Vec<(f64, f64)> = if is_parallel {
        weights.par_chunks(GROUP).map(left_by).collect()
    } else {
        weights.chunks(GROUP).map(left_by).collect()
    };
    let (copied, remainder) = groups.iter().fold((0.0, 0.0), |(c, r), group| (c + group.0, r + group.1));
    // Weights that sum to a rounding above one must not give more copies than there are places: `as` stops at 0.
    let total = spacings((places - copied) as usize, rng, points, is_parallel);
    // The walk is in the unit of the points, not the other way round: one product instead of one a draw.
    let scale = total / remainder;
    indices.resize(n, 0);
    let mut walks = Vec::with_capacity(groups.len());
    let (mut before, mut rest) = (Walk { first: 0, next: 0, passed: 0.0 }, &mut indices[..]);
    let mut copied = 0.0;
    for (g, group) in groups.iter().enumerate() {
        copied += group.0;
        let passed = before.passed + group.1 * scale;
        let is_last = g + 1 == groups.len();
        let next = if is_last { points.len() } else { points.partition_point(|point| *point < passed) };
        let end = if is_last { n } else { (copied as usize + next).min(n) };
        let (here, after) = rest.split_at_mut(end - (n - rest.len()));
        walks.push((before, here));
        (before, rest) = (Walk { first: (g + 1) * GROUP, next, passed }, after);
    }
    points.push(f64::INFINITY);
    let work = |((start, out), weights): ((Walk, &mut [u32]), &[f64])| {
        start.walk(weights, places, scale, &copies, points, out);
    };
    if is_parallel {
        walks.into_par_iter().zip(weights.par_chunks(GROUP)).for_each(work);
    } else {
        walks.into_iter().zip(weights.chunks(GROUP)).for_each(work);
    }
}

/// `draws` points in ascending order, as sums of exponentials; returns the sum that one more gives.
///
/// Each group of [`GROUP`] draws has a stream of its own, so that threads may share them.
fn spacings(draws: usize, rng: &mut Stream, points: &mut Vec<f64>, is_parallel: bool) -> f64 {
    points.resize(draws + 1, 0.0);
    let fill = |(points, mut own): (&mut [f64], Stream)| {
        let mut sum = 0.0;
        for point in points {
            sum += own.sample::<f64, _>(Exp1);
            *point = sum;
        }
    };
    let streams: Vec<Stream> = (0..points.len().div_ceil(GROUP)).map(|_| Stream::seed_from_u64(rng.random())).collect();
    if is_parallel {
        points.par_chunks_mut(GROUP).zip(streams).for_each(fill);
    } else {
        points.chunks_mut(GROUP).zip(streams).for_each(fill);
    }
    let mut before = 0.0;
    for points in points.chunks_mut(GROUP) {
        for point in &mut *points {
            *point += before;
        }
        before = points.last().copied().unwrap_or(before);
    }
    points.pop().unwrap_or(before)
}

/// Where a group of particles starts.
#[derive(Debug, Clone, Copy)]
struct Walk {
    /// Its first particle.
    first: usize,
    /// The first point that is not before it.
    next: usize,
    /// The scaled remainders of all particles before it.
    passed: f64,
}

impl Walk {
    /// Write every particle of the group as often as it was drawn.
    fn walk(
        mut self,
        weights: &[f64],
        places: f64,
        scale: f64,
        copies: &impl Fn(f64) -> f64,
        points: &[f64],
        out: &mut [u32],
    ) {
        let mut at: usize = 0;
        for (index, weight) in (self.first as u32..).zip(weights) {
            let expected = weight * places;
            let certain = copies(expected);
            self.passed += (expected - certain) * scale;
            // Whether one more is drawn is a toss-up, so it is added without a branch; two more are rare.
            let one_more = usize::from(points[self.next] < self.passed);
            let mut count = certain as usize + one_more;
            self.next += one_more;
            while points[self.next] < self.passed {
                count += 1;
                self.next += 1;
            }
            let end = at.saturating_add(count).min(out.len());
            if let Some([one, two]) = out.get_mut(at..at + 2) {
                // Written before they are counted, again to spare a branch.
                *one = index;
                *two = index;
                if count > 2 {
                    out[at + 2..end].fill(index);
                }
            } else {
                out[at..end].fill(index);
            }
            at = end;
        }
        // Points that rounding left beyond the last remainder belong to the last particle with weight.
        out[at..].fill((self.first + last_positive(weights)) as u32);
    }
}

/// `x.floor()` for `0 <= x < 2^51`, in operations that every x86-64 has as vector instructions.
fn floor(x: f64) -> f64 {
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    let nearest = (x + WHOLE) - WHOLE;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// The last particle that may be drawn at all.
fn last_positive(weights: &[f64]) -> usize {
    weights.iter().rposition(|w| *w > 0.0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [Scheme; 4] = [Scheme::Multinomial, Scheme::Stratified, Scheme::Systematic, Scheme::Residual];

    fn draw(scheme: Scheme, weights: &[f64], n: usize, seed: u64) -> Vec<u32> {
        let mut ancestors = Ancestors::default();
        scheme.draw(weights, n, &mut Stream::seed_from_u64(seed), &mut ancestors);
        ancestors.indices
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

    /// Groups change nothing: a large set, light and heavy particles, zeros at the seams.
    #[test]
    fn large_sets_are_drawn_as_small_ones() {
        let len = 5 * GROUP + 77;
        let raw: Vec<f64> =
            (0..len).map(|i| if i % GROUP < 3 { 0.0 } else { (i % 97) as f64 * (i % 5) as f64 }).collect();
        let sum: f64 = raw.iter().sum();
        let w: Vec<f64> = raw.iter().map(|x| x / sum).collect();
        let seeds = 100;
        for scheme in [Scheme::Residual, Scheme::Multinomial] {
            let mut total = vec![0usize; len];
            for seed in 0..seeds {
                let ancestors = draw(scheme, &w, len, seed);
                assert!(ancestors.len() == len && ancestors.is_sorted());
                for i in ancestors {
                    assert!(w[i as usize] > 0.0);
                    total[i as usize] += 1;
                }
            }
            let z2: f64 = (0..len)
                .filter(|i| w[*i] > 0.0)
                .map(|i| {
                    let expected = w[i] * len as f64 * seeds as f64;
                    (total[i] as f64 - expected).powi(2) / expected
                })
                .sum::<f64>()
                / len as f64;
            assert!(z2 < 1.05, "{scheme:?}: {z2}");
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
    fn floor_is_floor() {
        for x in [0.0, 0.25, 0.5, 0.999_999_999, 1.0, 1.5, 2.5, 1e6 - 1e-6, 4_294_967_295.75] {
            assert_eq!(floor(x), x.floor());
        }
    }

    #[test]
    fn unknown_name_lists_the_known() {
        let message = Scheme::from_name("resedual").unwrap_err().to_string();
        assert!(message.contains("resedual") && message.contains("systematic"));
    }
}
