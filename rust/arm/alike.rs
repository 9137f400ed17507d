//! Whether the patch moves as the sensor does, while they come: what a filter bends its track to shows in no single frame.
//!
//! Not in the paper. Over the last seconds the patch's way across the first camera's line of sight is laid over the sensor's,
//! integrated twice; where either begins, how fast, and a steady acceleration are left out, which an integration does not
//! know. A recording is looked at in the same way as a whole, with what comes after a frame too (`pytracker/tracking/alike.py`).

use super::motion::Motion;
use super::posed::Sighting;
use crate::quaternion::Quaternion;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// What is said of a frame before which they did not.
pub const UNLIKE: &str = "the patch does not move as the sensor does";

/// In less a slow arm hardly moves, over more the sensor drifts by as much, s.
const WINDOW_S: f64 = 3.0;
/// They are laid over each other so often, s.
const EVERY_S: f64 = 0.25;
/// Longer than this between sightings, or without a sample, nothing is laid over the other, s.
const SEEN_GAP_S: f64 = 0.3;
const SENSOR_GAP_S: f64 = 0.1;
const LEAST_FRAMES: usize = 15;
/// What a worn sensor is off by: white, m/s/√s, and so much more per m/s² that it accelerates by.
const DENSITY: f64 = 0.085;
const GROWTH: f64 = 0.3;
/// The mean square of what white acceleration of unit density leaves beside a parabola, over the window's third power.
const LEFT_OF_WHITE: f64 = 4.0e-4;
/// A centre is known no better, px, and wanders by as much over a wrist that turns, m.
const CENTRE_PX: f64 = 2.0;
const CENTRE_M: f64 = 0.005;
/// A centre that leaps as far, alone, was not of the patch, px.
const SPIKE_PX: f64 = 10.0;
/// So much of the larger way, as squares, must be left.
const LEAST_SHARE: f64 = 0.4;
/// And so many times what is expected (RMS): to begin, to go on, and to count towards most of the last while.
const CERTAIN: f64 = 2.8;
const LIKELY: f64 = 1.5;
const IN_MOST: f64 = 1.75;
/// That while, s, and how much of it must have been seen.
const MEMORY_S: f64 = 10.0;
const LEAST_KNOWN: f64 = 0.5;
/// More than half, so that few slips do not count.
const MOST: f64 = 0.6;

/// What a recording is judged by as well, as a whole (`pytracker/tracking/alike.py`).
pub const LIMITS: [(&str, f64); 10] = [
    ("window_s", WINDOW_S),
    ("seen_gap_s", SEEN_GAP_S),
    ("sensor_gap_s", SENSOR_GAP_S),
    ("accel_density", DENSITY),
    ("accel_growth", GROWTH),
    ("centre_m", CENTRE_M),
    ("spike_px", SPIKE_PX),
    ("least_share", LEAST_SHARE),
    ("certain", CERTAIN),
    ("likely", LIKELY),
];

/// A frame: when, where the patch is across the line of sight, m, where the sensor would have carried it, and how fast that
/// accelerates, m/s².
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Moment {
    time_s: f64,
    seen: Vector2<f64>,
    driven: Vector2<f64>,
    acceleration: f64,
    m_per_px: f64,
}

/// What both did so far.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Alike {
    moments: VecDeque<Moment>,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    compared_s: Option<f64>,
    is_otherwise: bool,
    /// For how much of the last while they did not move alike, and how much of it is known.
    otherwise: f64,
    known: f64,
}

/// A frame that is to be taken.
pub struct Taken<'a> {
    /// Recording time, s.
    pub time_s: f64,
    /// The sensor's motion since the last frame.
    pub motion: &'a Motion,
    /// For how long of it nothing was measured, s.
    pub gap_s: f64,
    /// How it accelerates now, m/s², world.
    pub acceleration: Vector3<f64>,
    /// Its orientation.
    pub world_sensor: Quaternion,
    /// Where the patch was seen.
    pub sightings: &'a [Sighting<'a>],
    /// Where the wrist is, world, m.
    pub wrist: Vector3<f64>,
}

impl Alike {
    /// Take a frame.
    pub fn take(&mut self, frame: &Taken<'_>) {
        let Motion { input, elapsed_s, .. } = frame.motion;
        self.position += self.velocity * *elapsed_s + input.row(0).transpose();
        self.velocity += input.row(1).transpose();
        let last_s = self.moments.back().map(|last| last.time_s);
        if frame.gap_s > SENSOR_GAP_S || last_s.is_some_and(|last_s| frame.time_s - last_s > SEEN_GAP_S) {
            // What was said before says nothing of what comes.
            let (position, velocity) = (self.position, self.velocity);
            *self = Self { position, velocity, ..Self::default() };
        }
        let first_camera = frame.sightings.iter().find(|sighting| sighting.camera == 0);
        let Some(moment) = first_camera.and_then(|sighting| self.moment(frame, sighting)) else { return };
        self.moments.push_back(moment);
        while self.moments.front().is_some_and(|first| frame.time_s - first.time_s > WINDOW_S) {
            self.moments.pop_front();
        }
        let first_s = self.moments.front().map_or(frame.time_s, |first| first.time_s);
        let is_due = self.compared_s.is_none_or(|compared_s| frame.time_s - compared_s >= EVERY_S);
        if is_due && frame.time_s - first_s > WINDOW_S - EVERY_S && self.moments.len() >= LEAST_FRAMES {
            self.compare(frame.time_s);
        }
    }

    /// Whether they do not move alike.
    pub fn is_otherwise(&self) -> bool {
        self.is_otherwise || (self.known > LEAST_KNOWN && self.otherwise > MOST * self.known)
    }

    fn moment(&self, frame: &Taken<'_>, sighting: &Sighting<'_>) -> Option<Moment> {
        let camera = &sighting.view.camera;
        let to_patch = frame.world_sensor.rotate(sighting.view.patch_offset);
        let patch = frame.wrist + to_patch;
        let off_px = sighting.pixel - camera.project(patch)?;
        let m_per_px = camera.depth(patch) / camera.matrix()[(0, 0)];
        let across = camera.rotation().fixed_view::<2, 3>(0, 0).into_owned();
        Some(Moment {
            time_s: frame.time_s,
            seen: across * patch + off_px * m_per_px,
            driven: across * (self.position + to_patch),
            acceleration: frame.acceleration.norm(),
            m_per_px,
        })
    }

    fn compare(&mut self, time_s: f64) {
        let elapsed_s = self.compared_s.map_or(EVERY_S, |compared_s| (time_s - compared_s).min(WINDOW_S));
        self.compared_s = Some(time_s);
        let moments = self.without_spikes();
        if moments.len() < LEAST_FRAMES {
            return;
        }
        let (left, larger, expected) = ways(&moments);
        let is_large = left > LEAST_SHARE * larger;
        let least = if self.is_otherwise { LIKELY } else { CERTAIN };
        self.is_otherwise = is_large && left > least * least * expected;
        let keep = (-elapsed_s / MEMORY_S).exp();
        self.known = keep * self.known + 1.0 - keep;
        self.otherwise *= keep;
        if is_large && left > IN_MOST * IN_MOST * expected {
            self.otherwise += 1.0 - keep;
        }
    }

    /// Those whose patch does not leap away from where it is in the two frames before and after: a leap was of something else.
    fn without_spikes(&self) -> Vec<Moment> {
        let last = self.moments.len() - 1;
        // Beyond either end it is as before it.
        let at = |k: usize, j: usize| if k + j < 2 { 2 - k - j } else { k + j - 2 };
        let within = |k: usize| if k > last { 2 * last - k } else { k };
        let stays = |k: &usize| {
            let about: [Vector2<f64>; 5] = std::array::from_fn(|j| self.moments[within(at(*k, j))].seen);
            let middle = Vector2::new(median(about.map(|place| place.x)), median(about.map(|place| place.y)));
            (self.moments[*k].seen - middle).norm() <= SPIKE_PX * self.moments[*k].m_per_px
        };
        (0..=last).filter(stays).map(|k| self.moments[k]).collect()
    }
}

/// Mean squares, m², of what is left of one way beside the other, of the larger way, and of what is expected to be left.
fn ways(moments: &[Moment]) -> (f64, f64, f64) {
    let count = moments.len() as f64;
    let began_s = moments[0].time_s;
    let half_s = 0.5 * (moments[moments.len() - 1].time_s - began_s);
    let times: Vec<f64> = moments.iter().map(|moment| (moment.time_s - began_s) / half_s - 1.0).collect();
    let bent = |way: fn(&Moment) -> Vector2<f64>| beside_parabola(&times, moments.iter().map(way).collect());
    let (seen, driven) = (bent(|moment| moment.seen), bent(|moment| moment.driven));
    let mean_square = |way: &[Vector2<f64>]| way.iter().map(Vector2::norm_squared).sum::<f64>() / count;
    let apart: Vec<_> = seen.iter().zip(&driven).map(|(a, b)| a - b).collect();
    let mean = |of: fn(&Moment) -> f64| moments.iter().map(of).sum::<f64>() / count;
    let density = mean(|moment| (DENSITY * (1.0 + GROWTH * moment.acceleration)).powi(2));
    let centre = (CENTRE_PX * mean(|moment| moment.m_per_px)).powi(2) + CENTRE_M * CENTRE_M;
    let expected = 2.0 * (LEFT_OF_WHITE * density * WINDOW_S.powi(3) + centre);
    (mean_square(&apart), mean_square(&seen).max(mean_square(&driven)), expected)
}

/// The middle of five.
fn median(mut of: [f64; 5]) -> f64 {
    of.sort_by(f64::total_cmp);
    of[2]
}

/// What a way `(T,)` over times from -1 to 1 has beside the parabola that fits it best.
fn beside_parabola(times: &[f64], mut way: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for power in 0..3 {
        let mut column: Vec<f64> = times.iter().map(|time| time.powi(power)).collect();
        for other in &basis {
            let along: f64 = column.iter().zip(other).map(|(a, b)| a * b).sum();
            column.iter_mut().zip(other).for_each(|(a, b)| *a -= along * b);
        }
        let norm = column.iter().map(|a| a * a).sum::<f64>().sqrt();
        for a in &mut column {
            *a /= norm;
        }
        basis.push(column);
    }
    for column in &basis {
        let along: Vector2<f64> = way.iter().zip(column).map(|(place, b)| place * *b).sum();
        way.iter_mut().zip(column).for_each(|(place, b)| *place -= along * *b);
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::state::View;
    use crate::camera::Camera;
    use nalgebra::{Matrix2, Matrix3};

    /// A camera two metres from a wrist that goes round at a turn in two seconds, 15 cm across, 25 frames/s for 12 s; the patch
    /// is seen where `seen` puts it. How many of the frames are said not to move alike.
    fn said(seen: impl Fn(f64) -> Vector2<f64>) -> usize {
        let matrix = Matrix3::new(600.0, 0.0, 320.0, 0.0, 600.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        let view = View { camera, patch_offset: Vector3::zeros() };
        let (mut alike, mut count) = (Alike::default(), 0);
        for k in 0..300 {
            let mut motion = Motion::none();
            for step in 0..4 {
                let time_s = 0.04 * f64::from(k) - 0.04 + 0.01 * (f64::from(step) + 0.5);
                let across = circle(time_s) * -(std::f64::consts::PI.powi(2));
                motion.append(0.01, Vector3::new(across.x, across.y, 0.0), 0.1, None);
            }
            let place = seen(0.04 * f64::from(k));
            let wrist = Vector3::new(place.x, place.y, 0.0);
            let pixel = view.camera.project(wrist).unwrap();
            let sightings = [Sighting { view: &view, camera: 0, pixel }];
            alike.take(&Taken {
                time_s: 0.04 * f64::from(k),
                motion: &motion,
                gap_s: 0.0,
                acceleration: Vector3::new(1.5, 0.0, 0.0),
                world_sensor: Quaternion::identity(),
                sightings: &sightings,
                wrist,
            });
            count += usize::from(alike.is_otherwise());
        }
        count
    }

    fn circle(time_s: f64) -> Vector2<f64> {
        let angle = std::f64::consts::PI * time_s;
        Vector2::new(angle.cos(), angle.sin()) * 0.15
    }

    #[test]
    fn what_moves_alike_is_never_doubted() {
        assert_eq!(said(circle), 0);
        // Seen a little later, and by less.
        assert_eq!(said(|time_s| circle(time_s - 0.1) * 0.8), 0);
    }

    #[test]
    fn what_stands_still_or_goes_another_way_is_doubted_within_seconds() {
        assert!(said(|_| Vector2::new(0.1, 0.0)) > 200);
        assert!(said(|time_s| circle(0.6 * time_s)) > 200);
        assert!(said(|time_s| Matrix2::new(-1.0, 0.0, 0.0, 1.0) * circle(time_s)) > 200);
    }

    #[test]
    fn a_patch_that_leaps_away_now_and_then_is_believed() {
        let leaps = |time_s: f64| {
            let away = if (time_s / 0.04).round() % 20.0 == 7.0 { Vector2::new(0.2, 0.1) } else { Vector2::zeros() };
            circle(time_s) + away
        };
        assert_eq!(said(leaps), 0);
    }

    #[test]
    fn centres_that_leap_in_every_frame_say_nothing() {
        let leaps = |time_s: f64| Vector2::new((7e3 * time_s).sin(), (9e3 * time_s).cos()) * 0.3;
        assert_eq!(said(leaps), 0);
    }

    #[test]
    fn a_patch_that_is_followed_again_is_believed_again() {
        let lost = |time_s: f64| if (4.0..6.0).contains(&time_s) { circle(4.0) } else { circle(time_s) };
        assert!((25..125).contains(&said(lost)), "{}", said(lost));
    }

    #[test]
    fn a_parabola_is_nothing() {
        let times: Vec<f64> = (0..20).map(|k| f64::from(k) / 9.5 - 1.0).collect();
        let way = times.iter().map(|t| Vector2::new(1.0 + 2.0 * t, 3.0 * t * t - t)).collect();
        assert!(beside_parabola(&times, way).iter().all(|place| place.norm() < 1e-12));
    }
}
