//! What a weighted particle set says: mean, covariance, quantiles, mode.

use super::{Block, ParticleSet};
use crate::rng::BLOCK;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use rayon::prelude::*;

/// The lower quantile of the reported band.
pub const LOWER: f64 = 0.025;
/// The upper quantile of the reported band.
pub const UPPER: f64 = 0.975;

/// Cells of the histograms that quantiles and mode start from.
const CELLS: usize = 256;

/// The 95 % band of one column.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// The 2.5 % quantile.
    pub lo: f64,
    /// The 97.5 % quantile.
    pub hi: f64,
}

impl ParticleSet {
    /// Map every block to a value, in order, on threads where the set is large.
    fn block_values<T: Send>(&self, map: impl Fn(Block<'_>, &[f64]) -> T + Sync) -> Vec<T> {
        let stride = self.dim * BLOCK;
        let work = |(data, weights): (&[f64], &[f64])| map(Block { data, len: weights.len() }, weights);
        if self.is_parallel() {
            self.blocks.par_chunks(stride).zip(self.weights.par_chunks(BLOCK)).map(work).collect()
        } else {
            self.blocks.chunks(stride).zip(self.weights.chunks(BLOCK)).map(work).collect()
        }
    }
}

/// Sum of `a * b` in four interleaved parts: a fixed order that vector instructions can follow.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut parts = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let tail: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for k in 0..4 {
            parts[k] += x[k] * y[k];
        }
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3]) + tail
}

pub(super) fn moments(set: &ParticleSet) -> (DVector<f64>, DMatrix<f64>) {
    let dim = set.dim;
    let mean = set
        .block_values(|block, w| DVector::from_fn(dim, |d, _| dot(block.column(d), w)))
        .into_iter()
        .fold(DVector::zeros(dim), |sum, part| sum + part);
    let covariance = set
        .block_values(|block, w| block_covariance(block, w, &mean))
        .into_iter()
        .fold(DMatrix::zeros(dim, dim), |sum, part| sum + part);
    (mean, covariance)
}

fn block_covariance(block: Block<'_>, w: &[f64], mean: &DVector<f64>) -> DMatrix<f64> {
    let dim = mean.len();
    let mut covariance = DMatrix::zeros(dim, dim);
    let mut centred = vec![[0.0; BLOCK]; dim];
    let mut weighted = [0.0; BLOCK];
    for d in 0..dim {
        for (c, x) in centred[d].iter_mut().zip(block.column(d)) {
            *c = x - mean[d];
        }
        for i in 0..w.len() {
            weighted[i] = centred[d][i] * w[i];
        }
        for e in 0..=d {
            let value = dot(&centred[e][..w.len()], &weighted[..w.len()]);
            covariance[(d, e)] = value;
            covariance[(e, d)] = value;
        }
    }
    covariance
}

/// Weight per cell of `[lo, hi]`; `position` gives each particle's coordinate, block by block.
struct Histogram {
    lo: f64,
    per_unit: f64,
    weight: [f64; CELLS],
}

impl Histogram {
    fn cell(&self, x: f64) -> usize {
        (((x - self.lo) * self.per_unit) as usize).min(CELLS - 1)
    }

    /// `None` when all coordinates are the same.
    fn new(columns: &[&[f64]], weights: &[f64]) -> Option<Self> {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for column in columns {
            for x in *column {
                lo = lo.min(*x);
                hi = hi.max(*x);
            }
        }
        let per_unit = CELLS as f64 / (hi - lo);
        if !per_unit.is_finite() {
            return None;
        }
        let mut histogram = Self { lo, per_unit, weight: [0.0; CELLS] };
        for (column, weights) in columns.iter().zip(weights.chunks(BLOCK)) {
            for (x, w) in column.iter().zip(weights) {
                histogram.weight[histogram.cell(*x)] += w;
            }
        }
        Some(histogram)
    }
}

pub(super) fn interval(set: &ParticleSet, column: usize) -> Interval {
    let columns: Vec<&[f64]> = set.blocks().map(|block| block.column(column)).collect();
    match Histogram::new(&columns, &set.weights) {
        None => Interval { lo: columns[0][0], hi: columns[0][0] },
        Some(histogram) => Interval {
            lo: quantile(&columns, &set.weights, &histogram, LOWER),
            hi: quantile(&columns, &set.weights, &histogram, UPPER),
        },
    }
}

/// Sort only the cell in which the cumulative weight crosses `level`.
fn quantile(columns: &[&[f64]], weights: &[f64], histogram: &Histogram, level: f64) -> f64 {
    let mut cumulative = 0.0;
    let mut cell = 0;
    while cell < CELLS - 1 && cumulative + histogram.weight[cell] < level {
        cumulative += histogram.weight[cell];
        cell += 1;
    }
    let mut inside: Vec<(f64, f64)> = Vec::new();
    for (column, weights) in columns.iter().zip(weights.chunks(BLOCK)) {
        inside.extend(column.iter().copied().zip(weights.iter().copied()).filter(|(x, _)| histogram.cell(*x) == cell));
    }
    inside.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    for (x, w) in &inside {
        cumulative += w;
        if cumulative >= level {
            return *x;
        }
    }
    // Rounding left the level just above the whole: the largest value carries it.
    inside.last().map_or_else(|| histogram.lo + cell as f64 / histogram.per_unit, |(x, _)| *x)
}

pub(super) fn mode<const K: usize>(set: &ParticleSet) -> SVector<f64, K> {
    let mean: SVector<f64, K> =
        SVector::from_fn(|d, _| set.blocks().zip(set.weights.chunks(BLOCK)).map(|(b, w)| dot(b.column(d), w)).sum());
    let mut scatter = SMatrix::<f64, K, K>::zeros();
    let parts = set.block_values(|block, w| {
        let all = block_covariance(block, w, &DVector::from_column_slice(mean.as_slice()));
        SMatrix::<f64, K, K>::from_fn(|r, c| all[(r, c)])
    });
    for part in &parts {
        scatter += part;
    }
    let axis = principal_axis(&scatter);
    let along: Vec<Vec<f64>> = set.block_values(|block, _| {
        let mut x = vec![0.0; block.len()];
        for d in 0..K {
            for (x, value) in x.iter_mut().zip(block.column(d)) {
                *x += axis[d] * (value - mean[d]);
            }
        }
        x
    });
    let columns: Vec<&[f64]> = along.iter().map(Vec::as_slice).collect();
    let Some(histogram) = Histogram::new(&columns, &set.weights) else { return mean };
    // Silverman's width for the whole cloud; two branches that it would merge are one for the reader too.
    let spread = (axis.transpose() * scatter * axis)[0].sqrt();
    let half_width = (0.5 * spread * (set.ess().max(1.0)).powf(-0.2)).max(1.0 / histogram.per_unit);
    let peak = densest(&histogram, half_width);
    let mut total = 0.0;
    let mut sum = SVector::<f64, K>::zeros();
    for ((block, x), w) in set.blocks().zip(&columns).zip(set.weights.chunks(BLOCK)) {
        for i in 0..w.len() {
            if (x[i] - peak).abs() <= half_width {
                total += w[i];
                sum += SVector::<f64, K>::from_fn(|d, _| w[i] * block.column(d)[i]);
            }
        }
    }
    if total > 0.0 { sum / total } else { mean }
}

/// The middle of the window of `2 * half_width` that holds most weight.
fn densest(histogram: &Histogram, half_width: f64) -> f64 {
    let reach = ((half_width * histogram.per_unit).round() as usize).clamp(1, CELLS / 2);
    let mut cumulative = [0.0; CELLS + 1];
    for cell in 0..CELLS {
        cumulative[cell + 1] = cumulative[cell] + histogram.weight[cell];
    }
    let mass = |cell: usize| cumulative[(cell + reach + 1).min(CELLS)] - cumulative[cell.saturating_sub(reach)];
    let best = (0..CELLS).max_by(|a, b| mass(*a).total_cmp(&mass(*b))).unwrap_or(0);
    histogram.lo + (best as f64 + 0.5) / histogram.per_unit
}

/// The direction of largest variance, by power iteration; any unit vector where the cloud has no extent.
fn principal_axis<const K: usize>(scatter: &SMatrix<f64, K, K>) -> SVector<f64, K> {
    let widest = (0..K).max_by(|a, b| scatter[(*a, *a)].total_cmp(&scatter[(*b, *b)])).unwrap_or(0);
    let mut axis = SVector::<f64, K>::from_fn(|d, _| f64::from(u8::from(d == widest)));
    for _ in 0..16 {
        let next = scatter * axis;
        let norm = next.norm();
        if norm <= 0.0 || !norm.is_finite() {
            break;
        }
        axis = next / norm;
    }
    axis
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn set_of(rows: &[[f64; 3]], weights: &[f64]) -> ParticleSet {
        let mut set = ParticleSet::new(rows.len(), 3).unwrap();
        set.for_each_block(|b, mut block| {
            for i in 0..block.len() {
                for d in 0..3 {
                    block.column_mut(d)[i] = rows[b * BLOCK + i][d];
                }
            }
        });
        set.reweigh(&weights.iter().map(|w| w.ln()).collect::<Vec<_>>()).unwrap();
        set
    }

    fn naive_quantile(rows: &[[f64; 3]], weights: &[f64], d: usize, level: f64) -> f64 {
        let total: f64 = weights.iter().sum();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|a, b| rows[*a][d].total_cmp(&rows[*b][d]));
        let mut cumulative = 0.0;
        for i in order.iter().copied() {
            cumulative += weights[i] / total;
            if cumulative >= level - 1e-12 {
                return rows[i][d];
            }
        }
        rows[*order.last().unwrap()][d]
    }

    proptest! {
        #[test]
        fn moments_and_quantiles_as_defined(
            rows in prop::collection::vec(prop::array::uniform3(-5.0..5.0f64), 1..700),
            seed in prop::collection::vec(0.01..1.0f64, 700),
        ) {
            let weights = &seed[..rows.len()];
            let set = set_of(&rows, weights);
            let total: f64 = weights.iter().sum();
            let (mean, covariance) = set.moments();
            for d in 0..3 {
                let expected: f64 = rows.iter().zip(weights).map(|(r, w)| r[d] * w / total).sum();
                prop_assert!((mean[d] - expected).abs() < 1e-12);
                for e in 0..3 {
                    let expected: f64 = rows.iter().zip(weights).map(|(r, w)| (r[d] - mean[d]) * (r[e] - mean[e]) * w / total).sum();
                    prop_assert!((covariance[(d, e)] - expected).abs() < 1e-11);
                }
                let band = set.interval(d);
                // A crossing that falls on a rounding may go to the neighbour: compare by cumulative weight.
                let share = |x: f64| rows.iter().zip(weights).filter(|(r, _)| r[d] <= x).map(|(_, w)| w / total).sum::<f64>();
                prop_assert!((share(band.lo) - share(naive_quantile(&rows, weights, d, LOWER))).abs() < 1e-9);
                prop_assert!((share(band.hi) - share(naive_quantile(&rows, weights, d, UPPER))).abs() < 1e-9);
            }
        }
    }

    /// Of two branches the heavier is the mode, where the mean lies between them.
    #[test]
    fn mode_is_on_a_branch() {
        let rows: Vec<[f64; 3]> = (0..1000)
            .map(|i| [if i % 5 < 3 { 0.1 } else { -0.1 } + 1e-5 * f64::from(i), 0.3, 1e-3 * f64::from(i % 7)])
            .collect();
        let set = set_of(&rows, &vec![1.0; 1000]);
        let mode: SVector<f64, 3> = set.mode();
        assert!((mode.x - 0.105).abs() < 0.01, "{mode}");
        assert!((mode.y - 0.3).abs() < 1e-12);
    }

    #[test]
    fn a_single_point_is_its_own_everything() {
        let set = set_of(&[[1.0, 2.0, 3.0]; 5], &[1.0; 5]);
        assert_eq!(set.interval(1), Interval { lo: 2.0, hi: 2.0 });
        assert!((set.mode::<3>() - SVector::from([1.0, 2.0, 3.0])).norm() < 1e-15);
    }
}
