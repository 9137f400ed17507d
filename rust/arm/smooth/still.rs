//! Rest, told from the half seconds about a frame: in the mean neither does the sensor turn, nor the patch move in the picture.
//!
//! Not in the paper. [`crate::arm::stillness`] knows what came before, and a wrist that goes slowly and evenly looks to it as if it
//! lay still. Who sees what comes after too, and the picture, can tell them apart. A hand that trembles (at rest by 4 to 6 Hz
//! in Parkinson's disease, by millimetres to centimetres) rests about its place.

use crate::arm::memory::Kept;
use crate::arm::state::{POSITION, VELOCITY, View};
use nalgebra::{SVector, Vector3};
use std::f64::consts::PI;

/// So much before and behind a frame is looked at, s.
const HALF_S: f64 = 0.5;
/// Less than this of both together tells nothing, s.
const LEAST_S: f64 = 0.4;
/// A sensor that lies still turns by less, rad: who moves by a centimetre turns an arm by more.
const TURN: f64 = 0.016;
/// Who trembles turns it by less, to and fro, rad, and in the mean so slowly, rad/s.
const TREMBLES: (f64, f64) = (0.1, 0.032);
/// The patch moves across the picture by less from one half of it to the other, m/s.
const ACROSS_M_S: f64 = 0.016;
/// And is known so often in either.
const LEAST_SEEN: usize = 4;

/// In which of the frames the arm rests, and by how much it then trembles: standard deviation of its velocity, m/s per axis.
pub(super) fn still(frames: &[Kept], views: &[View]) -> Vec<Option<f64>> {
    let (mut from, mut to) = (0, 0);
    let mut found = Vec::with_capacity(frames.len());
    for frame in frames {
        while frames[from].time_s < frame.time_s - HALF_S {
            from += 1;
        }
        while to < frames.len() && frames[to].time_s <= frame.time_s + HALF_S {
            to += 1;
        }
        found.push(rests(frame, &frames[from..to], views));
    }
    found
}

fn rests(frame: &Kept, about: &[Kept], views: &[View]) -> Option<f64> {
    let half_s = 0.5 * (about[about.len() - 1].time_s - about[0].time_s);
    if 2.0 * half_s < LEAST_S || !stays(about, views, frame) {
        return None;
    }
    let most = about.iter().map(|other| turn(frame, other).norm()).fold(0.0, f64::max);
    if most <= TURN {
        return Some(0.0);
    }
    let turned = moved(about, |other| Some(turn(frame, other)))?;
    (most < TREMBLES.0 && turned.norm() < TREMBLES.1 * half_s).then(|| tremor(about))
}

/// How fast the wrist goes to and fro, by the filter, m/s per axis.
fn tremor(about: &[Kept]) -> f64 {
    let velocities = about.iter().map(|frame| frame.means[0].fixed_rows::<3>(VELOCITY).into_owned());
    let mean: Vector3<f64> = velocities.clone().sum::<Vector3<f64>>() / about.len() as f64;
    (velocities.map(|velocity| (velocity - mean).norm_squared()).sum::<f64>() / (3 * about.len()) as f64).sqrt()
}

/// How the sensor is turned from one frame to another that is near, rad, in its own axes.
fn turn(a: &Kept, b: &Kept) -> Vector3<f64> {
    let turned = a.world_sensor.conjugate() * b.world_sensor;
    turned.v * 2f64.copysign(turned.w)
}

/// Whether some camera saw the patch, and none saw it move.
fn stays(about: &[Kept], views: &[View], frame: &Kept) -> bool {
    let half_s = 0.5 * (about[about.len() - 1].time_s - about[0].time_s);
    let wrist: Vector3<f64> = frame.means[0].fixed_rows::<3>(POSITION).into();
    let moved_m = |(camera, view): (usize, &View)| {
        let m_per_px = view.camera.depth(wrist) / view.camera.matrix()[(0, 0)];
        Some(moved(about, |other| other.pixels[camera])?.norm() * m_per_px)
    };
    let mut by = views.iter().enumerate().filter_map(moved_m).peekable();
    by.peek().is_some() && by.all(|moved_m| moved_m < ACROSS_M_S * half_s)
}

/// By how much something is elsewhere in the second half than in the first; none where either hardly has it.
fn moved<const D: usize>(about: &[Kept], of: impl Fn(&Kept) -> Option<SVector<f64, D>>) -> Option<SVector<f64, D>> {
    let middle_s = 0.5 * (about[0].time_s + about[about.len() - 1].time_s);
    let (before, after) = about.split_at(about.partition_point(|other| other.time_s < middle_s));
    Some(mean(after, &of)? - mean(before, &of)?)
}

/// The mean of something over frames, of those at both ends hardly: what goes to and fro leaves little of itself in it.
fn mean<const D: usize>(frames: &[Kept], of: impl Fn(&Kept) -> Option<SVector<f64, D>>) -> Option<SVector<f64, D>> {
    let weight = |k: usize| (PI * (k as f64 + 0.5) / frames.len() as f64).sin();
    let known = || frames.iter().enumerate().filter_map(|(k, frame)| of(frame).map(|value| (weight(k), value)));
    let (count, total) = known().fold((0, 0.0), |(count, total), (weight, _)| (count + 1, total + weight));
    let sum: SVector<f64, D> = known().map(|(weight, value)| weight * value).sum();
    (count >= LEAST_SEEN).then(|| sum / total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::quaternion::Quaternion;
    use nalgebra::{DVector, Matrix3, Vector2};

    /// Five seconds at 25 a second of a patch that goes at such a speed, px/s, and a sensor that turns, rad/s, from 2.5 s on; to
    /// which comes a tremor at 5 Hz, rad, a metre in the picture for each, from 1 s on.
    fn told(px_per_s: f64, turn_rate: f64, tremor: f64, seen: impl Fn(usize) -> bool) -> Vec<Option<f64>> {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        let kept = |k: usize| {
            let (time_s, noise) = (0.04 * k as f64, [0.7, -0.7][k % 2]);
            let gone_s = (time_s - 2.5).max(0.0);
            let size = if time_s > 1.0 { tremor } else { 0.0 };
            let (sine, cosine) = (31.4 * time_s).sin_cos();
            let pixel = Vector2::new(320.0 + noise + px_per_s * gone_s, 240.0 - noise + 350.0 * size * sine);
            let mut mean = DVector::zeros(6);
            mean[VELOCITY] = 0.03 + 31.4 * size * cosine;
            Kept {
                time_s,
                world_sensor: Quaternion::from_rotation_vector(Vector3::new(
                    0.0,
                    turn_rate * gone_s + size * sine,
                    0.0,
                )),
                pixels: vec![seen(k).then_some(pixel)],
                landmarks: Vec::new(),
                is_unknown: false,
                start: None,
                means: [mean.clone(), mean],
                filtered: None,
            }
        };
        let frames: Vec<Kept> = (0..125).map(kept).collect();
        still(&frames, &[View { camera, patch_offset: Vector3::zeros() }])
    }

    #[test]
    fn what_neither_turns_nor_moves_lies_still_to_both_ends() {
        assert!(told(0.0, 0.0, 0.0, |_| true).iter().all(|still| *still == Some(0.0)));
    }

    #[test]
    fn what_goes_slowly_does_not() {
        for found in [told(8.0, 0.0, 0.0, |_| true), told(0.0, 0.06, 0.0, |_| true), told(0.0, 0.06, 0.03, |_| true)] {
            assert!(found[..10].iter().all(Option::is_some), "until it is near");
            assert!(!found[75..].iter().any(Option::is_some));
        }
    }

    /// And is as uncertain as that of such a tremor, which the filter has besides a drift.
    #[test]
    fn what_trembles_rests_about_its_place() {
        let expected = 31.4 * 0.03 / 6f64.sqrt();
        for found in &told(0.0, 0.0, 0.03, |_| true)[40..110] {
            assert!((found.unwrap() - expected).abs() < 0.1 * expected, "{found:?} for {expected}");
        }
        assert!(told(0.0, 0.0, 0.15, |_| true)[40..].iter().all(Option::is_none), "who waves does not rest");
    }

    #[test]
    fn what_is_not_seen_is_not_known() {
        assert!(!told(0.0, 0.0, 0.0, |_| false).iter().any(Option::is_some));
        let found = told(0.0, 0.0, 0.0, |k| k < 60);
        assert!(found[40].is_some() && found[80].is_none());
    }

    #[test]
    fn of_no_frames_nothing_is_told() {
        assert_eq!(still(&[], &[]), Vec::<Option<f64>>::new());
    }
}
