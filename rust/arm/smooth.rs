//! The arm over a whole recording: the mixture's track, smoothed.
//!
//! Not in the paper. The state and its motion are those of [`super::mixture`], what is measured are its [`super::cues`], and the
//! trajectories to start from are the mixture's and either depth of the arm's sphere (`ways`). By how much the camera sees later
//! than the IMU's clock says is constant and bends everything: it is no column here. The frames are put at so many delays, each
//! is a branch that is smoothed by itself, and all are weighed (`weighed`). What the mixture said of the same
//! frames has a share of the say (`averaged`).
//!
//! | file | what |
//! |---|---|
//! | `branch` | a recording at some delay as a chain of states |
//! | `still` | where the arm rests, told from what comes before and after, and the picture |
//! | `ways` | trajectories to start from |
//! | `weighed` | delays and ways, weighed |
//! | `averaged` | with what the mixture said |

mod averaged;
mod branch;
mod still;
mod ways;
mod weighed;

use self::averaged::{at_its_wrist, averaged};
use self::branch::{ArmBranch, Step};
use self::still::still;
use self::weighed::{Delayed, Way, together, weighed, weights};
use super::cues::CueName;
use super::cues::upper_arm::{Direction, direction_at};
use super::frame::News;
use super::memory::Kept;
use super::mixture::ArmMixture;
use super::plausible::{Judged, Plausibility, UNKNOWN};
use super::posed::{Moment, Posed, sightings};
use super::setup::Setup;
use super::state::{Arm, Layout, Noise, POSITION, VELOCITY, View};
use super::timeline::Timeline;
use super::worn::{Moved, WornMotion};
use crate::Result;
use crate::averaged::steadied;
use crate::error::successes;
use crate::estimate::Estimate;
use crate::filter::{Component, Gaussian, Settled, Smoothed, smooth};
use crate::observation::Sample;
use crate::smoothing::{Window, Windowed};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Delays that are tried at first, to either side of none, in standard deviations of what is known beforehand.
const DELAYS: [f64; 4] = [0.5, 1.0, 1.5, 2.0];
/// Between them it is looked so often while one has most of the weight.
const FINER: usize = 4;
const MOST: f64 = 0.4;

/// What is known where a window starts amid a recording, beyond where the mixture has it: wrist, m, and velocity, m/s.
const AMID_M: f64 = 0.1;
const AMID_M_S: f64 = 0.3;

/// A recording at some delay, and where it has settled.
struct Retimed {
    moments: Vec<Moment>,
    at: Vec<DVector<f64>>,
}

/// The delays of one way, each with its weight, the heaviest first.
type Delays = Vec<(f64, Delayed<Retimed>)>;

/// A recording of an arm that a mixture has been through.
#[derive(Clone, Copy)]
pub(super) struct Recorded<'a> {
    pub arm: &'a Arm,
    pub noise: &'a Noise,
    pub views: &'a [View],
    pub filter: &'a ArmMixture,
    pub frames: &'a [Kept],
    pub samples: &'a [Sample],
    pub directions: &'a [Direction],
    pub setup: Option<Setup>,
}

impl<'a> Recorded<'a> {
    /// The frames from `first` on, as many as are smoothed together, each given all about it; none beyond the last.
    ///
    /// # Errors
    /// [`crate::Error::Singular`], [`crate::Error::RanAway`] where no trajectory is found.
    pub fn window(&self, first: usize) -> Result<Windowed> {
        let count = self.frames.len();
        if first >= count {
            return Ok(Windowed::default());
        }
        let span_s = self.frames[count - 1].time_s - self.frames[0].time_s;
        let Window { end, until, seen: [from, to], .. } = Window::lasting(first, count, span_s);
        let part = Self { frames: &self.frames[from..to], samples: self.samples_of(from, to), ..*self };
        let found: Vec<_> = part.smoothed()?.into_iter().zip(part.frames).map(|(own, of)| averaged(own, of)).collect();
        let mut own: Vec<_> = (first..until).map(|frame| at_its_wrist(steadied(&found, frame - from))).collect();
        self.judge(first, &mut own);
        let beyond = own.split_off(end - first);
        Ok(Windowed { own, beyond })
    }

    /// The samples that frames may need, however late they were seen; the last ones where the sensor ended long before.
    fn samples_of(&self, from: usize, to: usize) -> &'a [Sample] {
        let apart = 1.0 + 3.0 * self.noise.clock.map_or(0.0, |clock| clock.start_sd);
        let until = |time_s: f64| self.samples.partition_point(|sample| sample.time_s <= time_s);
        let last = until(self.frames[to - 1].time_s + apart);
        let first = if from == 0 { 0 } else { until(self.frames[from].time_s - apart) };
        &self.samples[first.min(last.saturating_sub(2))..last]
    }

    /// One window: every way in which the arm may have gone at every delay, weighed.
    fn smoothed(&self) -> Result<Vec<Estimate>> {
        let noise = Noise { clock: None, setup: self.setup, ..self.noise.clone() };
        let ways = self.starts(&noise)?.par_iter().map(|start| self.way(start, &noise)).collect();
        // Most delays weigh nothing: what the others say is worked out alone.
        let ways: Vec<_> = weighed(successes(ways)?).into_par_iter().map(|way| self.spread(way, &noise)).collect();
        let ways = ways.into_iter().collect::<Result<Vec<_>>>()?;
        let said = |frame| {
            let parts = ways.iter().flat_map(|way| self.said(way, frame, &noise));
            together(&parts.collect::<Vec<_>>())
        };
        Ok((0..self.frames.len()).into_par_iter().map(said).collect())
    }

    /// Trajectories that explain more than all about them where no frame is late, the likeliest first.
    fn starts(&self, noise: &Noise) -> Result<Vec<Vec<DVector<f64>>>> {
        let steps = self.retimed(0.0, noise)?;
        let branch = self.branch(noise, &steps);
        let starts = ways::starts(&branch);
        let tries = starts.par_iter().map(|start| branch.settled(start.clone()));
        // Where none leads anywhere at this delay, one may at another.
        Ok(successes(tries.collect()).map_or(starts.clone(), ways::distinct))
    }

    fn branch<'b>(&'b self, noise: &'b Noise, steps: &'b [Step<'b>]) -> ArmBranch<'b> {
        ArmBranch { arm: self.arm, noise, views: self.views, filter: self.filter, steps }
    }

    /// One way, at all delays.
    fn way(&self, start: &[DVector<f64>], noise: &Noise) -> Result<Way<Retimed>> {
        let known_sd = self.noise.clock.map_or(0.0, |clock| clock.start_sd);
        let mut found = self.at_delays(start, known_sd, noise)?;
        let mut apart = 0.5 * known_sd;
        for _ in 0..FINER {
            let weights = weights(&found);
            let best = (0..found.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap_or(0);
            if apart == 0.0 || weights[best] < MOST {
                break;
            }
            apart *= 0.5;
            let finer = [-apart, apart].map(|off| found[best].delay_s + off);
            let finer = finer.par_iter().map(|delay_s| self.delayed(between(&found, *delay_s), *delay_s, noise));
            found.extend(successes(finer.collect())?);
            found.sort_by(|a, b| a.delay_s.total_cmp(&b.delay_s));
        }
        Ok(Way(weights(&found).into_iter().zip(found).collect()))
    }

    /// Those of the delays with which a trajectory is found, in increasing order; an error where there is none. From none on to
    /// either side, as each tells where to start with the next.
    fn at_delays(&self, start: &[DVector<f64>], known_sd: f64, noise: &Noise) -> Result<Vec<Delayed<Retimed>>> {
        let none = self.delayed(start.to_vec(), 0.0, noise);
        if known_sd == 0.0 {
            return Ok(vec![none?]);
        }
        let first = none.as_ref().map_or(start, |none| &none.of.at);
        let on = |side: f64| {
            let mut tried: Vec<Result<Delayed<Retimed>>> = Vec::with_capacity(DELAYS.len());
            for delay in DELAYS {
                let delay_s = side * delay * known_sd;
                let last = tried.iter().filter_map(|one| one.as_ref().ok()).next_back();
                let from = last.map_or(first, |last| &last.of.at).to_vec();
                tried.push(self.delayed(from, delay_s, noise));
            }
            tried
        };
        let (mut tried, later) = rayon::join(|| on(-1.0), || on(1.0));
        tried.reverse();
        tried.push(none);
        tried.extend(later);
        successes(tried)
    }

    fn delayed(&self, start: Vec<DVector<f64>>, delay_s: f64, noise: &Noise) -> Result<Delayed<Retimed>> {
        let steps = self.retimed(delay_s, noise)?;
        let branch = self.branch(noise, &steps);
        let Settled { at, cost, log_evidence, .. } = branch.settled(start)?;
        let in_sd =
            self.noise.clock.map_or(0.0, |clock| if clock.start_sd > 0.0 { delay_s / clock.start_sd } else { 0.0 });
        let log_fit = branch.log_fit(&at, cost)?;
        let [log_density, log_fit] = [log_evidence, log_fit].map(|log| log - 0.5 * in_sd * in_sd);
        Ok(Delayed { delay_s, log_density, log_fit, of: Retimed { moments: branch.moments(), at } })
    }

    /// One way with the spread about it: that at its heaviest delay.
    fn spread(&self, way: Delays, noise: &Noise) -> Result<(Delays, Smoothed)> {
        let Delayed { delay_s, of, .. } = &way[0].1;
        let smoothed = smooth(&self.branch(noise, &self.retimed(*delay_s, noise)?), of.at.clone())?;
        Ok((way, smoothed))
    }

    /// What one way says of a frame at each of its delays.
    fn said<'b>(
        &'b self,
        (way, spread): &'b (Delays, Smoothed),
        frame: usize,
        noise: &'b Noise,
    ) -> impl Iterator<Item = (f64, Delayed<Estimate>)> + 'b {
        let (covariance, log_evidence) = (&spread.states[frame].covariance, Some(spread.log_evidence[frame]));
        way.iter().map(move |(weight, Delayed { delay_s, log_density, log_fit, of })| {
            let posed = Posed::new(Layout::new(noise), self.arm, noise, of.moments[frame]);
            let gaussian = Gaussian { mean: of.at[frame].clone(), covariance: covariance.clone() };
            let component = Component { gaussian, log_weight: 0.0 };
            let estimate = self.filter.of_components(vec![component], &posed, self.frames[frame].time_s);
            let of = Estimate { log_evidence, ..estimate };
            (*weight, Delayed { delay_s: *delay_s, log_density: *log_density, log_fit: *log_fit, of })
        })
    }

    /// The frames, seen so much later by the IMU's clock; without the clock's column, which is the last.
    fn retimed(&self, delay_s: f64, noise: &Noise) -> Result<Vec<Step<'a>>> {
        let dim = self.filter.dim_without_clock();
        let (_, sd) = Layout::new(noise).start(self.arm, noise);
        // Lengths and cameras are as they are said to be at first.
        let long = |of: &DVector<f64>| of.rows(0, dim).into_owned().resize_vertically(sd.len(), 0.0);
        let mut timeline = Timeline::new(true);
        let first_s = self.samples.first().map_or(0.0, |sample| sample.time_s);
        let mut samples = self.samples.iter().peekable();
        let mut steps = Vec::with_capacity(self.frames.len());
        let mut news = News::default();
        let says_rest = self.filter.cues().contains(&CueName::Rest);
        let still = still(self.frames, self.views);
        for (k, frame) in self.frames.iter().enumerate() {
            // A frame before the first sample is met with it.
            let time_s = (frame.time_s + delay_s).max(first_s + 1e-9 * (k as f64));
            while let Some(sample) = samples.next_if(|sample| sample.time_s <= time_s) {
                timeline.take(sample, noise)?;
            }
            timeline.reach_frame(time_s, noise)?;
            let cameras = frame.pixels.iter().enumerate().filter_map(|(camera, pixel)| pixel.map(|_| camera));
            let start = match &frame.start {
                Some(Gaussian { mean, covariance }) => {
                    let mut known = DMatrix::from_diagonal(&sd.component_mul(&sd));
                    known.view_mut((0, 0), (dim, dim)).copy_from(&covariance.view((0, 0), (dim, dim)));
                    Some(Gaussian { mean: long(mean), covariance: known })
                }
                None => (k == 0).then(|| self.amid(long(&frame.means[0]), noise)),
            };
            if start.is_some() {
                timeline.clear_pending();
            }
            let moved = Moved::new(timeline.worn().cloned().unwrap_or_else(WornMotion::none), noise);
            steps.push(Step {
                time_s: frame.time_s,
                spread: moved.spread(),
                moved,
                world_sensor: timeline.world_sensor(noise),
                stale_s: timeline.stale_s(noise),
                rest: still[k].or_else(|| (says_rest && timeline.is_rest(noise)).then_some(0.0)),
                is_new: news.is_new(frame.time_s, cameras),
                pixels: &frame.pixels,
                landmarks: &frame.landmarks,
                // Whether it says something does not depend on the delay: they are compared by all that is measured.
                upper_arm: direction_at(self.directions, frame.time_s)
                    .map(|seen| direction_at(self.directions, time_s).unwrap_or(seen)),
                start,
                means: [long(&frame.means[0]), long(&frame.means[1])],
            });
            timeline.clear_pending();
        }
        Ok(steps)
    }

    /// What is known where a window starts amid a recording.
    fn amid(&self, mean: DVector<f64>, noise: &Noise) -> Gaussian {
        let (_, mut sd) = Layout::new(noise).start(self.arm, noise);
        sd.rows_mut(POSITION, 3).fill(AMID_M);
        sd.rows_mut(VELOCITY, 3).fill(AMID_M_S);
        Gaussian { mean, covariance: DMatrix::from_diagonal(&sd.component_mul(&sd)) }
    }

    /// What speaks against them, as of the filter's own.
    fn judge(&self, first: usize, estimates: &mut [Estimate]) {
        let mut plausibility = Plausibility::new();
        for (frame, estimate) in self.frames[first..].iter().zip(estimates) {
            if frame.start.is_some() {
                plausibility = Plausibility::new();
            }
            let sightings = sightings(self.views, &frame.pixels);
            let (arm, noise, world_sensor) = (self.arm, self.noise, frame.world_sensor);
            let doubt = plausibility.doubt(estimate, &Judged { arm, noise, sightings: &sightings, world_sensor });
            estimate.doubt = if frame.is_unknown { Some(UNKNOWN) } else { doubt };
        }
    }
}

/// Where a trajectory is looked for at a delay: on the line through those that were found next to it.
fn between(found: &[Delayed<Retimed>], delay_s: f64) -> Vec<DVector<f64>> {
    let mut near: Vec<&Delayed<Retimed>> = found.iter().collect();
    near.sort_by(|a, b| (a.delay_s - delay_s).abs().total_cmp(&(b.delay_s - delay_s).abs()));
    let [one, other, ..] = near[..] else { return near[0].of.at.clone() };
    // Beyond the last of them it is the line's going on.
    let share = (delay_s - one.delay_s) / (other.delay_s - one.delay_s);
    one.of.at.iter().zip(&other.of.at).map(|(one, other)| one.lerp(other, share)).collect()
}
