//! A smoothed recording, window by window: where two meet, one goes over into the next.
//!
//! Each window finds for itself what is constant of a recording, so that two of them put the same frame at somewhat different
//! places. Over a seam of frames that both have smoothed the weight goes from one to the other: no place jumps, and where they
//! disagree the band reaches over both. A pose that is one of several stays one of them.

use crate::estimate::{Estimate, Point};
use crate::particles::{Interval, Summary};
use nalgebra::Vector3;

/// Frames that are smoothed together; of an arm at least those of so many seconds: a few tell little of what is constant.
const WINDOW: usize = 600;
const WINDOW_S: f64 = 24.0;
/// A window looks at so much of one before and after it besides, and over so much of one it goes over into the next.
const LEAD: f64 = 1.0 / 3.0;
const SEAM: f64 = 1.0 / 6.0;
/// Modes that are nearer than so many of their standard deviations, together, and than so far, m, are one on its way to the other.
const ALIKE_SD: f64 = 2.0;
const ALIKE_M: f64 = 0.05;

/// Frames of a recording that are smoothed together: memory does not grow with its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Window {
    /// The first of the next window.
    pub end: usize,
    /// Up to here it has a say in what the next window says; `end` where there is none.
    pub until: usize,
    /// All that it looks at, from the first number up to the second.
    pub seen: [usize; 2],
}

impl Window {
    /// Of `count` frames those from `first` on.
    pub fn new(first: usize, count: usize) -> Self {
        Self::of(WINDOW, first, count)
    }

    /// The same, of [`WINDOW_S`] where that is more, of frames which last `span_s` in all.
    pub fn lasting(first: usize, count: usize, span_s: f64) -> Self {
        let in_time = (WINDOW_S * (count - 1) as f64 / span_s.max(f64::MIN_POSITIVE)).min(count as f64);
        Self::of(WINDOW.max(in_time.round() as usize), first, count)
    }

    fn of(window: usize, first: usize, count: usize) -> Self {
        let [lead, seam] = [LEAD, SEAM].map(|share| (share * window as f64).round() as usize);
        // What is left is not cut into a window and a rest.
        let end = if count - first <= window + lead { count } else { first + window };
        Self { end, until: (end + seam).min(count), seen: [first.saturating_sub(lead), (end + lead).min(count)] }
    }
}

/// What one window says.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Windowed {
    /// Of its own frames.
    pub own: Vec<Estimate>,
    /// Of the first frames of the next.
    pub beyond: Vec<Estimate>,
}

/// How far a recording was smoothed: see [`crate::Tracker::smoothed`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Smoothing {
    next: usize,
    beyond: Vec<Estimate>,
}

impl Smoothing {
    /// Number of the frame that comes next.
    pub(crate) fn next(&self) -> usize {
        self.next
    }

    /// The next frames, gone over into from what the window before said of them.
    pub(crate) fn joined(&mut self, Windowed { mut own, beyond }: Windowed) -> Vec<Estimate> {
        let before = std::mem::replace(&mut self.beyond, beyond);
        let count = before.len() as f64;
        for (k, (before, after)) in before.iter().zip(&mut own).enumerate() {
            let passed = (k as f64 + 0.5) / count;
            // Neither places nor speeds jump.
            *after = between(before, after, passed * passed * (3.0 - 2.0 * passed));
        }
        self.next += own.len();
        own
    }
}

/// An estimate `share` of the way from one of the same frame to another.
fn between(before: &Estimate, after: &Estimate, share: f64) -> Estimate {
    let (nearer, other) = if share < 0.5 { (before, after) } else { (after, before) };
    // The way from one pose to another, and from one mode: where they are not one, that of the nearer.
    let along = if are_one(before, after) { share } else { share.round() };
    let places = before.places.iter().zip(&after.places).map(|(before, after)| point(before, after, share, along));
    let evidence = before.log_evidence.zip(after.log_evidence);
    Estimate {
        state: state(&before.state, &after.state, share, along),
        places: places.collect(),
        log_evidence: evidence.map(|(before, after)| before + share * (after - before)),
        // It is made of both.
        doubt: nearer.doubt.or(other.doubt),
        ..nearer.clone()
    }
}

/// Whether the modes of two estimates are near enough for one on its way to the other.
fn are_one(before: &Estimate, after: &Estimate) -> bool {
    before.places.iter().zip(&after.places).all(|(before, after)| {
        (after.mode - before.mode).norm() <= (ALIKE_SD * (before.sd.norm() + after.sd.norm())).min(ALIKE_M)
    })
}

fn state(before: &Summary, after: &Summary, share: f64, along: f64) -> Summary {
    // A body's mean is its mode, a pose: between two there is none. An arm's is a mean.
    let is_pose = before.mode.len() == before.mean.len();
    let mean = before.mean.lerp(&after.mean, if is_pose { along } else { share });
    let mode = before.mode.lerp(&after.mode, along);
    let pairs = before.bands.iter().zip(&after.bands).enumerate();
    let band = |(d, (b, a)): (usize, (&Interval, &Interval))| reach(*b, *a, [before.mean[d], after.mean[d]], share);
    let about = |of: &Summary| {
        let off = &of.mean - &mean;
        &of.covariance + &off * off.transpose()
    };
    let covariance = about(before) * (1.0 - share) + about(after) * share;
    Summary { bands: pairs.map(band).collect(), mean, mode, covariance }
}

fn point(before: &Point, after: &Point, share: f64, along: f64) -> Point {
    let off = after.mean - before.mean;
    let sd = Vector3::from_fn(|d, _| {
        let variance = (1.0 - share) * before.sd[d].powi(2) + share * after.sd[d].powi(2);
        (variance + spread(share) * off[d] * off[d]).sqrt()
    });
    let band = Vector3::from_fn(|d, _| {
        let band = |of: &Point| Interval { lo: of.lo[d], hi: of.hi[d] };
        reach(band(before), band(after), [before.mean[d], after.mean[d]], share)
    });
    Point {
        mean: before.mean.lerp(&after.mean, share),
        mode: before.mode.lerp(&after.mode, along),
        sd,
        lo: band.map(|of| of.lo),
        hi: band.map(|of| of.hi),
    }
}

/// Variance of one or the other, at 0 and 1.
fn spread(share: f64) -> f64 {
    share * (1.0 - share)
}

/// Band between two, which reaches farther where they disagree.
fn reach(before: Interval, after: Interval, means: [f64; 2], share: f64) -> Interval {
    let between = |[a, b]: [f64; 2]| a + share * (b - a);
    let band = Interval { lo: between([before.lo, after.lo]), hi: between([before.hi, after.hi]) };
    band.widened(between(means), spread(share).sqrt() * (means[1] - means[0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::NORMAL_UPPER;
    use nalgebra::{DMatrix, DVector};

    fn estimate(x: f64, sd: f64) -> Estimate {
        let mean = Vector3::new(x, 0.0, 1.0);
        let reach = Vector3::from_element(NORMAL_UPPER * sd);
        let place = Point { mean, mode: mean, sd: Vector3::from_element(sd), lo: mean - reach, hi: mean + reach };
        let state = place.with_state(DVector::from_column_slice(mean.as_slice()), DMatrix::identity(3, 3) * sd * sd);
        Estimate {
            time_s: 0.0,
            state,
            places: vec![place],
            ess: None,
            log_evidence: Some(x),
            doubt: None,
            blobs: [None; 3],
        }
    }

    fn joined(before: &Estimate, after: &Estimate, frames: usize) -> Vec<Estimate> {
        let mut smoothing = Smoothing::default();
        let stretch = |of: &Estimate, beyond| Windowed { own: vec![of.clone(); 2 * frames], beyond };
        let first = smoothing.joined(stretch(before, vec![before.clone(); frames]));
        assert_eq!((first.len(), smoothing.next()), (2 * frames, 2 * frames));
        let all = [first, smoothing.joined(stretch(after, Vec::new()))].concat();
        assert_eq!(smoothing.next(), all.len());
        all
    }

    /// Windows follow each other to the end, and look as far about themselves as there are frames.
    #[test]
    fn windows_are_the_whole_recording() {
        for (count, rate_hz) in
            [(1, 25.0), (700, 25.0), (800, 25.0), (801, 25.0), (1400, 60.0), (5000, 120.0), (5000, 10.0)]
        {
            let span_s = (count - 1) as f64 / rate_hz;
            let of_time = |first| Window::lasting(first, count, span_s);
            let of_frames = |first| Window::new(first, count);
            for window_from in [&of_time as &dyn Fn(usize) -> Window, &of_frames] {
                let (mut first, mut until) = (0, 0);
                let most = window_from(0).end;
                while first < count {
                    let window = window_from(first);
                    assert!(window.end > first && window.seen[0] <= first && window.seen[1] >= window.until);
                    assert!(window.end - first >= until - first && window.until - window.end <= most.div_ceil(6));
                    (first, until) = (window.end, window.until);
                }
                assert_eq!((first, until), (count, count));
            }
        }
    }

    /// As many as there always were at 25 frames/s or fewer, of as many seconds at more; times that are all one are no reason to fail.
    #[test]
    fn a_window_is_of_some_time() {
        for (rate_hz, frames) in [(25.0, 600), (10.0, 600), (120.0, 2880)] {
            let window = Window::lasting(0, 10_000, 9_999.0 / rate_hz);
            let (lead, seam) = (frames / 3, frames / 6);
            assert_eq!((window.end, window.until, window.seen), (frames, frames + seam, [0, frames + lead]));
        }
        assert_eq!(Window::lasting(0, 900, 0.0).end, 900);
        assert_eq!(Window::new(0, 10_000), Window::lasting(0, 10_000, 1e6));
    }

    /// Two windows that put an arm 3 cm apart: no step is larger than a seam's share of it, and the ends are what either said.
    #[test]
    fn a_seam_is_no_jump() {
        let (before, after) = (estimate(0.0, 0.02), estimate(0.03, 0.01));
        let all = joined(&before, &after, 100);
        assert_eq!((&all[0], &all[199], &all[300], &all[399]), (&before, &before, &after, &after));
        for pair in all.windows(2) {
            let [a, b] = [&pair[0].places[0], &pair[1].places[0]];
            assert!((b.mean.x - a.mean.x).abs() < 0.0005 && (b.mode.x - a.mode.x).abs() < 0.0005);
            assert!((b.lo.x - a.lo.x).abs() < 0.001 && (b.hi.x - a.hi.x).abs() < 0.001);
        }
        let middle = &all[250];
        assert!((middle.state.mean[0] - middle.places[0].mean.x).abs() < 1e-12);
        assert!((middle.state.bands[0].lo - middle.places[0].lo.x).abs() < 1e-12);
        assert!(middle.state.covariance[(0, 0)] > 0.015f64.powi(2));
    }

    /// Far apart, the band holds both; the mode and a body's pose are of one of them.
    #[test]
    fn where_windows_disagree_the_band_holds_both() {
        let all = joined(&estimate(0.0, 0.01), &estimate(0.4, 0.01), 10);
        let middle = &all[25].places[0];
        assert!(middle.lo.x < 0.0 && middle.hi.x > 0.4 && middle.sd.x > 0.19);
        assert!(all.iter().all(|one| [0.0, 0.4].contains(&one.places[0].mode.x)));
        assert!(all.iter().all(|one| [0.0, 0.4].contains(&one.state.mean[0])));
        // About the pose that is reported.
        assert!((all[25].state.covariance[(0, 0)] - (0.0001 + 0.16 * 0.425)).abs() < 0.002);
    }

    /// An arm's state has columns beyond its place, one of them known exactly: its place is where the wrist is, all the same.
    #[test]
    fn an_arms_state_goes_with_its_wrist() {
        let arm = |x: f64, delay_s: f64| {
            let one = estimate(x, 0.02);
            let mean = DVector::from_column_slice(&[x, 0.0, 1.0, delay_s]);
            let covariance = DMatrix::from_diagonal(&DVector::from_column_slice(&[4e-4, 4e-4, 4e-4, 0.0]));
            Estimate { state: one.places[0].with_state(mean, covariance), ..one }
        };
        for one in joined(&arm(0.0, 0.02), &arm(0.03, 0.025), 100) {
            assert!((one.state.mean[0] - one.places[0].mean.x).abs() < 1e-12);
            assert!((one.state.covariance[(0, 0)].sqrt() - one.places[0].sd.x).abs() < 1e-12);
        }
    }

    /// What speaks against either window speaks against what is made of both.
    #[test]
    fn a_doubt_of_either_stays() {
        let doubted = Estimate { doubt: Some("beyond the reach"), ..estimate(0.0, 0.02) };
        let right = estimate(0.01, 0.02);
        for (before, after) in [(&doubted, &right), (&right, &doubted)] {
            let all = joined(before, after, 10);
            assert!(all[20..30].iter().all(|one| one.doubt == Some("beyond the reach")));
        }
    }

    /// A mean outside its own band, as of one branch in fifty: the band begins where the window before has it.
    #[test]
    fn a_band_beside_its_mean_does_not_jump() {
        let (band, next) = (Interval { lo: -0.02, hi: 0.0136 }, Interval { lo: -0.02, hi: 0.02 });
        assert_eq!(reach(band, next, [0.016, 0.0], 0.0), band);
        let Interval { lo, hi } = reach(band, next, [0.016, 0.0], 1e-6);
        assert!((lo - band.lo).abs() < 1e-3 && (hi - band.hi).abs() < 1e-3);
    }
}
