//! What a tracker says at one time: a state, and the places that it puts named joints at.

use crate::filter::{Gaussian, Mixture};
use crate::particles::{Interval, LOWER, NORMAL_UPPER, Summary, UPPER};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

/// A joint: world, metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Weighted mean.
    pub mean: Vector3<f64>,
    /// Where the cloud is densest; differs from the mean when it has two branches (Tao & Hu III-C name MAP).
    pub mode: Vector3<f64>,
    /// Standard deviation per axis.
    pub sd: Vector3<f64>,
    /// 2.5 % quantile per axis.
    pub lo: Vector3<f64>,
    /// 97.5 % quantile per axis.
    pub hi: Vector3<f64>,
}

/// What a tracker knows at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Recording time, s.
    pub time_s: f64,
    /// The state `(D,)`; its first columns with bands and mode.
    pub state: Summary,
    /// The joints, in the order of [`crate::Tracker::places`].
    pub places: Vec<Point>,
    /// Effective sample size; none for a Gaussian method.
    pub ess: Option<f64>,
    /// Log evidence of this frame's observations; none where nothing was observed, or weights are no likelihoods.
    pub log_evidence: Option<f64>,
    /// Why it must not be believed; none where nothing speaks against it.
    pub doubt: Option<&'static str>,
    /// Body: the skin blob given to head, left and right hand, px.
    pub blobs: [Option<[f64; 2]>; 3],
}

impl Estimate {
    /// Whether every number of it is one.
    pub fn is_finite(&self) -> bool {
        let points = self.places.iter().flat_map(|p| [p.mean, p.mode, p.sd, p.lo, p.hi]);
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        finite(self.state.mean.as_slice())
            && finite(self.state.covariance.as_slice())
            && points.into_iter().all(|v| finite(v.as_slice()))
    }

    /// Itself, where every number of it is one.
    ///
    /// # Errors
    /// [`Error::RanAway`].
    pub(crate) fn checked(self) -> Result<Self> {
        if self.is_finite() { Ok(self) } else { Err(Error::RanAway { time_s: self.time_s }) }
    }

    /// Spread by noise `(D, D)` that was not drawn: the covariance grows, and the bands of every place, which goes with the
    /// first three columns, as if all were Gaussian.
    pub(crate) fn widened(mut self, noise: &DMatrix<f64>) -> Self {
        self.state.covariance += noise;
        for point in &mut self.places {
            for d in 0..3 {
                let band = Interval { lo: point.lo[d], hi: point.hi[d] };
                let Interval { lo, hi } = band.widened(point.mean[d], noise[(d, d)].max(0.0).sqrt());
                point.sd[d] = self.state.covariance[(d, d)].max(0.0).sqrt();
                (point.lo[d], point.hi[d]) = (lo, hi);
            }
        }
        if let Some(first) = self.places.first() {
            self.state.bands = first.bands();
        }
        self
    }
}

impl Point {
    /// Three columns of a summary, from `first` on.
    pub(crate) fn of_columns(summary: &Summary, first: usize) -> Self {
        let sd = |d: usize| summary.covariance[(first + d, first + d)].max(0.0).sqrt();
        Self {
            mean: summary.mean.fixed_rows::<3>(first).into(),
            mode: summary.mode.fixed_rows::<3>(first).into(),
            sd: Vector3::from_fn(|d, _| sd(d)),
            lo: Vector3::from_fn(|d, _| summary.bands[first + d].lo),
            hi: Vector3::from_fn(|d, _| summary.bands[first + d].hi),
        }
    }

    /// The first three columns of a Gaussian.
    pub(crate) fn of_gaussian(state: &Gaussian) -> Self {
        let mean: Vector3<f64> = state.mean.fixed_rows::<3>(0).into();
        let sd = Vector3::from_fn(|d, _| state.covariance[(d, d)].max(0.0).sqrt());
        Self { mean, mode: mean, sd, lo: mean - NORMAL_UPPER * sd, hi: mean + NORMAL_UPPER * sd }
    }

    /// From normal distributions: weight, mean and standard deviation per axis of each.
    pub(crate) fn of_normals(parts: &[(f64, Vector3<f64>, Vector3<f64>)]) -> Self {
        let mean: Vector3<f64> = parts.iter().map(|(weight, mean, _)| *weight * mean).sum();
        let axis = |d: usize| parts.iter().map(move |(w, m, sd)| (*w, m[d], sd[d])).collect::<Vec<_>>();
        let variance = |d: usize| axis(d).iter().map(|(w, m, sd)| w * (sd * sd + (m - mean[d]).powi(2))).sum::<f64>();
        let density = |(weight, _, sd): &(f64, Vector3<f64>, Vector3<f64>)| weight / (sd.x * sd.y * sd.z);
        let mode = parts.iter().max_by(|a, b| density(a).total_cmp(&density(b))).map_or(mean, |part| part.1);
        if let [(_, mean, sd)] = parts {
            return Self { mean: *mean, mode, sd: *sd, lo: mean - NORMAL_UPPER * sd, hi: mean + NORMAL_UPPER * sd };
        }
        Self {
            mean,
            mode,
            sd: Vector3::from_fn(|d, _| variance(d).sqrt()),
            lo: Vector3::from_fn(|d, _| Mixture::quantile(&axis(d), LOWER)),
            hi: Vector3::from_fn(|d, _| Mixture::quantile(&axis(d), UPPER)),
        }
    }

    /// From weighted points that are normal each.
    pub(crate) fn together(parts: &[(f64, &Self)]) -> Self {
        Self::of_normals(&parts.iter().map(|(weight, point)| (*weight, point.mean, point.sd)).collect::<Vec<_>>())
    }

    /// The same, as widely known as another of the same place: its band, and its spread about this mean.
    pub(crate) fn with_bands_of(self, other: &Self) -> Self {
        let sd = Vector3::from_fn(|d, _| other.sd[d].hypot(other.mean[d] - self.mean[d]));
        Self { sd, lo: other.lo, hi: other.hi, ..self }
    }

    pub(crate) fn moved(&self, by: Vector3<f64>) -> Self {
        Self { mean: self.mean + by, mode: self.mode + by, sd: self.sd, lo: self.lo + by, hi: self.hi + by }
    }

    /// As the bands of three columns.
    pub(crate) fn bands(&self) -> Vec<Interval> {
        (0..3).map(|d| Interval { lo: self.lo[d], hi: self.hi[d] }).collect()
    }

    /// A state whose first three columns it is.
    pub(crate) fn with_state(&self, mean: DVector<f64>, covariance: DMatrix<f64>) -> Summary {
        Summary { mean, covariance, bands: self.bands(), mode: DVector::from_column_slice(self.mode.as_slice()) }
    }
}
