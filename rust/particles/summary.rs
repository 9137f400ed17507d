//! What a weighted particle set says: mean, covariance, quantiles, mode.

use super::{Block, ParticleSet};
use crate::rng::BLOCK;
use crate::sums::dot;
use multiversion::multiversion;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// The lower quantile of the reported band.
pub const LOWER: f64 = 0.025;
/// The upper quantile of the reported band.
pub const UPPER: f64 = 0.975;

/// The upper quantile of the standard normal distribution: half a band of it, in standard deviations.
pub const NORMAL_UPPER: f64 = 1.959_963_984_540_054;

/// Cells of the histograms that quantiles and mode start from; a cell's number is one byte.
const CELLS: usize = 256;

/// How far the histograms reach on either side of the mean, in standard deviations; what lies beyond falls
/// into their end cells.
const REACH_SD: f64 = 4.0;

/// The mode is looked for among at most this many particles, evenly chosen.
const MODE_SAMPLE: usize = 4096;

/// Blocks whose sums are added up before they meet the others.
const GROUP: usize = 8;

/// The 95 % band of one column: the particles at which the cumulative weight, in order of value, first
/// reaches [`LOWER`] and [`UPPER`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The 2.5 % quantile.
    pub lo: f64,
    /// The 97.5 % quantile.
    pub hi: f64,
}

impl Interval {
    /// The band about `mean` with an independent normal error of standard deviation `sd` besides. Half widths add up as those of
    /// normal errors do, which is exact where the band is one's; it grows, too, where the mean of two branches lies outside it.
    #[must_use]
    pub fn widened(self, mean: f64, sd: f64) -> Self {
        let wider = |half: f64| half.hypot(NORMAL_UPPER * sd) - half.abs();
        Self { lo: self.lo - wider(mean - self.lo), hi: self.hi + wider(self.hi - mean) }
    }
}

/// All that is reported of a set.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Weighted mean, `(D,)`.
    pub mean: DVector<f64>,
    /// Weighted covariance, `(D, D)`.
    pub covariance: DMatrix<f64>,
    /// Bands of the first `K` columns.
    pub bands: Vec<Interval>,
    /// Where the first `K` columns are densest, along the direction in which they spread most.
    pub mode: DVector<f64>,
}

pub(super) fn summarise(set: &ParticleSet, k: usize) -> Summary {
    let (mean, covariance) = moments(set);
    let band = |d: usize| interval(set, d, mean[d], covariance[(d, d)].max(0.0).sqrt());
    let (centre, scatter) = (mean.rows(0, k).into_owned(), covariance.view((0, 0), (k, k)).into_owned());
    let densest = || mode(set, &centre, &scatter);
    let (bands, mode) = if set.is_parallel() {
        rayon::join(|| (0..k).into_par_iter().map(band).collect(), densest)
    } else {
        ((0..k).map(band).collect(), densest())
    };
    Summary { mean, covariance, bands, mode }
}

/// One pass: first and second moments about the first particle, which lies inside the cloud, so that nothing
/// cancels that matters.
pub(super) fn moments(set: &ParticleSet) -> (DVector<f64>, DMatrix<f64>) {
    let dim = set.dim;
    let about = DVector::from_fn(dim, |d, _| set.blocks[d * BLOCK]);
    let group = |(data, weights): (&[f64], &[f64])| {
        let (mut first, mut second) = (DVector::zeros(dim), DMatrix::zeros(dim, dim));
        let mut centred = vec![[0.0; BLOCK]; dim];
        for (data, w) in data.chunks(dim * BLOCK).zip(weights.chunks(BLOCK)) {
            add_moments(Block { data, len: w.len() }, w, &about, &mut centred, &mut first, &mut second);
        }
        (first, second)
    };
    let stride = GROUP * dim * BLOCK;
    let parts: Vec<_> = if set.is_parallel() {
        set.blocks.par_chunks(stride).zip(set.weights.par_chunks(GROUP * BLOCK)).map(group).collect()
    } else {
        set.blocks.chunks(stride).zip(set.weights.chunks(GROUP * BLOCK)).map(group).collect()
    };
    let (mut first, mut second) = (DVector::zeros(dim), DMatrix::zeros(dim, dim));
    for (f, s) in parts {
        first += f;
        second += s;
    }
    for d in 0..dim {
        for e in 0..=d {
            second[(d, e)] -= first[d] * first[e];
            second[(e, d)] = second[(d, e)];
        }
    }
    (first + about, second)
}

/// Add what one block holds: `w (x - about)` to `first`, its lower triangle of products to `second`.
#[multiversion(targets("x86_64+avx2"))]
fn add_moments(
    block: Block<'_>,
    w: &[f64],
    about: &DVector<f64>,
    centred: &mut [[f64; BLOCK]],
    first: &mut DVector<f64>,
    second: &mut DMatrix<f64>,
) {
    let len = w.len();
    let mut weighted = [0.0; BLOCK];
    for d in 0..about.len() {
        let (column, origin) = (&block.column(d)[..len], about[d]);
        for i in 0..len {
            centred[d][i] = column[i] - origin;
            weighted[i] = centred[d][i] * w[i];
        }
        first[d] += dot(&centred[d][..len], w);
        for e in 0..=d {
            second[(d, e)] += dot(&centred[e][..len], &weighted[..len]);
        }
    }
}

fn interval(set: &ParticleSet, column: usize, mean: f64, sd: f64) -> Interval {
    let (low, per_unit) = (mean - REACH_SD * sd, CELLS as f64 / (2.0 * REACH_SD * sd));
    if !per_unit.is_finite() {
        return Interval { lo: mean, hi: mean };
    }
    let mut cells = vec![0u8; set.len];
    let mut weight = [0.0; CELLS];
    for ((block, w), cells) in set.blocks().zip(set.weights.chunks(BLOCK)).zip(cells.chunks_mut(BLOCK)) {
        for ((x, w), cell) in block.column(column).iter().zip(w).zip(cells) {
            *cell = ((x - low) * per_unit) as u8;
            weight[usize::from(*cell)] += w;
        }
    }
    let (lo, hi) = (Crossing::find(&weight, LOWER), Crossing::find(&weight, UPPER));
    let (mut inside_lo, mut inside_hi) = (Vec::new(), Vec::new());
    for ((block, w), cells) in set.blocks().zip(set.weights.chunks(BLOCK)).zip(cells.chunks(BLOCK)) {
        let column = block.column(column);
        for (i, cell) in cells.iter().enumerate() {
            if *cell == lo.cell || *cell == hi.cell {
                let inside = if *cell == lo.cell { &mut inside_lo } else { &mut inside_hi };
                inside.push((column[i], w[i]));
            }
        }
    }
    if lo.cell == hi.cell {
        inside_hi.clone_from(&inside_lo);
    }
    Interval { lo: lo.within(inside_lo), hi: hi.within(inside_hi) }
}

/// The cell in which the cumulative weight crosses a level.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    cell: u8,
    /// Weight of the cells before it.
    before: f64,
    level: f64,
}

impl Crossing {
    fn find(weight: &[f64; CELLS], level: f64) -> Self {
        let (mut before, mut cell) = (0.0, 0);
        while cell < CELLS - 1 && before + weight[cell] < level {
            before += weight[cell];
            cell += 1;
        }
        // Rounding may leave the level just above the whole: then the last filled cell holds it.
        while weight[cell] == 0.0 && cell > 0 {
            cell -= 1;
            before -= weight[cell];
        }
        Self { cell: cell as u8, before, level }
    }

    /// The value at the crossing, of the (value, weight) inside the cell.
    fn within(self, mut inside: Vec<(f64, f64)>) -> f64 {
        inside.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut cumulative = self.before;
        for (x, w) in &inside {
            cumulative += w;
            if cumulative >= self.level {
                return *x;
            }
        }
        inside.last().map_or(f64::NAN, |(x, _)| *x)
    }
}

/// The densest window along the principal axis, and the mean of the particles in it.
fn mode(set: &ParticleSet, mean: &DVector<f64>, scatter: &DMatrix<f64>) -> DVector<f64> {
    let axis = principal_axis(scatter);
    let spread = axis.dot(&(scatter * &axis)).max(0.0).sqrt();
    let (low, per_unit) = (-REACH_SD * spread, CELLS as f64 / (2.0 * REACH_SD * spread));
    if !per_unit.is_finite() {
        return mean.clone();
    }
    let stride = set.dim * BLOCK;
    let at = |i: usize, d: usize| set.blocks[i / BLOCK * stride + d * BLOCK + i % BLOCK];
    let step = set.len.div_ceil(MODE_SAMPLE);
    let along: Vec<(usize, f64)> = (0..set.len)
        .step_by(step)
        .map(|i| (i, (0..axis.len()).map(|d| axis[d] * (at(i, d) - mean[d])).sum()))
        .collect();
    let mut weight = [0.0; CELLS];
    for (i, x) in &along {
        weight[usize::from(((x - low) * per_unit) as u8)] += set.weights[*i];
    }
    // Silverman's width for the whole cloud; two branches that it would merge are one for the reader too.
    let half_width = (0.5 * spread * (along.len() as f64).powf(-0.2)).max(1.0 / per_unit);
    let peak = low + densest(&weight, half_width * per_unit) / per_unit;
    let (mut total, mut sum) = (0.0, DVector::zeros(axis.len()));
    for (i, x) in &along {
        if (x - peak).abs() <= half_width {
            total += set.weights[*i];
            for d in 0..axis.len() {
                sum[d] += at(*i, d) * set.weights[*i];
            }
        }
    }
    if total > 0.0 { sum / total } else { mean.clone() }
}

/// The middle, in cells, of the window of `2 * half_width` cells that holds most weight.
fn densest(weight: &[f64; CELLS], half_width: f64) -> f64 {
    let reach = (half_width.round() as usize).clamp(1, CELLS / 2);
    let mut cumulative = [0.0; CELLS + 1];
    for cell in 0..CELLS {
        cumulative[cell + 1] = cumulative[cell] + weight[cell];
    }
    let mass = |cell: usize| cumulative[(cell + reach + 1).min(CELLS)] - cumulative[cell.saturating_sub(reach)];
    let mut best = 0;
    for cell in 1..CELLS {
        if mass(cell) > mass(best) {
            best = cell;
        }
    }
    best as f64 + 0.5
}

/// The direction of largest variance, by power iteration; any unit vector where the cloud has no extent.
fn principal_axis(scatter: &DMatrix<f64>) -> DVector<f64> {
    let widest = (0..scatter.nrows()).max_by(|a, b| scatter[(*a, *a)].total_cmp(&scatter[(*b, *b)])).unwrap_or(0);
    let mut axis = DVector::from_fn(scatter.nrows(), |d, _| f64::from(u8::from(d == widest)));
    for _ in 0..16 {
        let next = scatter * &axis;
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
            rows in prop::collection::vec(prop::array::uniform3(prop_oneof![-5.0..5.0f64, 90.0..99.0f64]), 1..700),
            seed in prop::collection::vec(0.01..1.0f64, 700),
        ) {
            let weights = &seed[..rows.len()];
            let Summary { mean, covariance, bands, .. } = set_of(&rows, weights).summary(3);
            let total: f64 = weights.iter().sum();
            for d in 0..3 {
                let expected: f64 = rows.iter().zip(weights).map(|(r, w)| r[d] * w / total).sum();
                prop_assert!((mean[d] - expected).abs() < 1e-11);
                for e in 0..3 {
                    let product = |r: &[f64; 3]| (r[d] - mean[d]) * (r[e] - mean[e]);
                    let expected: f64 = rows.iter().zip(weights).map(|(r, w)| product(r) * w / total).sum();
                    prop_assert!((covariance[(d, e)] - expected).abs() < 1e-9);
                }
                // A crossing that falls on a rounding may go to the neighbour: compare by cumulative weight.
                let share = |x: f64| {
                    rows.iter().zip(weights).filter(|(r, _)| r[d] <= x).map(|(_, w)| w / total).sum::<f64>()
                };
                prop_assert!((share(bands[d].lo) - share(naive_quantile(&rows, weights, d, LOWER))).abs() < 1e-9);
                prop_assert!((share(bands[d].hi) - share(naive_quantile(&rows, weights, d, UPPER))).abs() < 1e-9);
            }
        }
    }

    /// Of two branches the heavier is the mode, where the mean lies between them.
    #[test]
    fn mode_is_on_a_branch() {
        for len in [1000, 20_000] {
            let branch = |i: i32| if i % 5 < 3 { 0.1 } else { -0.1 };
            let rows: Vec<[f64; 3]> = (0..len)
                .map(|i| [branch(i) + 0.01 * f64::from(i) / f64::from(len), 0.3, 1e-3 * f64::from(i % 7)])
                .collect();
            let mode = set_of(&rows, &vec![1.0; rows.len()]).summary(3).mode;
            assert!((mode[0] - 0.105).abs() < 0.01, "{mode}");
            assert!((mode[1] - 0.3).abs() < 1e-12);
        }
    }

    #[test]
    fn a_single_point_is_its_own_everything() {
        let summary = set_of(&[[1.0, 2.0, 3.0]; 5], &[1.0; 5]).summary(3);
        assert_eq!(summary.bands[1], Interval { lo: 2.0, hi: 2.0 });
        assert!((summary.mode - DVector::from_vec(vec![1.0, 2.0, 3.0])).norm() < 1e-15);
    }

    /// Its value, whichever it is.
    #[test]
    fn one_particle_with_all_the_weight_is_the_band() {
        let mut set = ParticleSet::from_rows(1, &[1.0, 2.0, 3.0]).unwrap();
        set.reweigh(&[f64::NEG_INFINITY, 0.0, f64::NEG_INFINITY]).unwrap();
        let summary = set.summary(1);
        assert_eq!((summary.mean[0], summary.bands[0].lo, summary.bands[0].hi), (2.0, 2.0, 2.0));
    }
}
