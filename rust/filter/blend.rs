//! How what the cues of a layer say becomes one log-weight a particle.
//!
//! [`Blend::Rescaled`] is Li & Kulić's (IV-C2): distances stretched over [0, 1] within the set, `A^-d`, a weighted product. Whatever
//! is seen then weighs as sharply as a perfect match, so that the spread of the set says little. [`Blend::Sum`] keeps the
//! scale of each cue.

use crate::Result;
use crate::error::require;
use crate::parameters::require_positive;
use serde::{Deserialize, Serialize};

/// How losses, negative log-likelihoods or distances, are blended over the set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Blend {
    /// As the paper does, with two cues (IV-C2).
    Rescaled {
        /// `A`: how much more a particle at distance 0 weighs than one at 1.
        base: f64,
        /// Weight of the first cue, 0 to 2; the second has the rest.
        alpha: f64,
        /// How far alpha is moved towards what each cue tells apart in this frame, 0 (the paper) to 1.
        adapt: f64,
    },
    /// Losses added up.
    Sum {
        /// Share of the whole sharpness: below 1 in the flat layers of annealing.
        sharpness: f64,
    },
}

impl Blend {
    /// Likelihoods multiplied: what Bayes' rule asks for.
    pub const PRODUCT: Self = Self::Sum { sharpness: 1.0 };

    /// The paper's; a share of the whole sharpness is that power of the base.
    pub fn rescaled(base: f64, alpha: f64, adapt: f64, sharpness: f64) -> Self {
        Self::Rescaled { base: base.powf(sharpness), alpha, adapt }
    }

    /// Check every range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn check(self) -> Result<()> {
        match self {
            Self::Sum { sharpness } => require_positive("sharpness of a layer", sharpness, "positive"),
            Self::Rescaled { base, alpha, adapt } => {
                require(base > 1.0 && base <= 1e100, "sharpness", base, "above 1")?;
                require((0.0..=2.0).contains(&alpha), "alpha", alpha, "0 to 2")?;
                require((0.0..=1.0).contains(&adapt), "adapt", adapt, "0 to 1")
            }
        }
    }

    /// Write the log-weight of every particle `(N,)`, of what each cue says that it loses `(K, N)`.
    pub fn log_weights(self, losses: &[Vec<f64>], out: &mut [f64]) {
        match self {
            Self::Sum { sharpness } => {
                for (i, out) in out.iter_mut().enumerate() {
                    *out = -sharpness * losses.iter().map(|loss| loss[i]).sum::<f64>();
                }
            }
            Self::Rescaled { base, alpha, adapt } => {
                let [first, second] = [0, 1].map(|k| losses.get(k).map_or(vec![0.0; out.len()], |loss| rescaled(loss)));
                let alpha = weight(&first, &second, base, alpha, adapt);
                for (i, out) in out.iter_mut().enumerate() {
                    *out = -base.ln() * (alpha * first[i] + (2.0 - alpha) * second[i]);
                }
            }
        }
    }
}

/// Linearly to [0, 1] over the set; zero where all are equal.
fn rescaled(distances: &[f64]) -> Vec<f64> {
    let low = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let span = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low;
    distances.iter().map(|d| if span > 0.0 { (d - low) / span } else { 0.0 }).collect()
}

/// The weight of the first of two cues in this frame.
fn weight(first: &[f64], second: &[f64], base: f64, alpha: f64, adapt: f64) -> f64 {
    if adapt == 0.0 {
        return alpha;
    }
    // How much a cue tells particles apart: one less its effective share of the set.
    let discrimination = |distances: &[f64]| {
        let weights: Vec<f64> = distances.iter().map(|d| (-base.ln() * d).exp()).collect();
        let (sum, squares) = weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        1.0 - sum * sum / (squares * weights.len() as f64)
    };
    let (a, b) = (discrimination(first), discrimination(second));
    let told = if a + b > 0.0 { 2.0 * a / (a + b) } else { alpha };
    alpha + adapt * (told - alpha)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blended(blend: Blend, losses: &[Vec<f64>]) -> Vec<f64> {
        let mut out = vec![f64::NAN; losses[0].len()];
        blend.log_weights(losses, &mut out);
        out
    }

    #[test]
    fn a_sum_keeps_the_scale_and_a_flat_layer_a_share_of_it() {
        let losses = [vec![0.0, 1.0, 4.0], vec![2.0, 0.0, 1.0]];
        assert_eq!(blended(Blend::PRODUCT, &losses), [-2.0, -1.0, -5.0]);
        assert_eq!(blended(Blend::Sum { sharpness: 0.5 }, &losses), [-1.0, -0.5, -2.5]);
    }

    #[test]
    fn the_papers_blend_stretches_each_cue_over_the_set() {
        let paper = Blend::rescaled(10.0, 0.5, 0.0, 1.0);
        let losses = [vec![7.0, 8.0, 9.0], vec![0.3, 0.3, 0.3]];
        let expected = [0.0, 0.25, 0.5].map(|d| -10f64.ln() * d);
        for (found, expected) in blended(paper, &losses).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12);
        }
        // A flat layer stretches as far, and weighs half as sharply.
        let flat = blended(Blend::rescaled(10.0, 0.5, 0.0, 0.5), &losses);
        assert!((flat[2] + 0.25 * 10f64.ln()).abs() < 1e-12);
        // What tells nothing apart has no say where alpha follows.
        let adapted = Blend::Rescaled { base: 10.0, alpha: 0.5, adapt: 1.0 };
        assert!((blended(adapted, &losses)[2] + 2.0 * 10f64.ln()).abs() < 1e-12);
    }
}
