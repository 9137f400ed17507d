//! Rest, told from the half seconds about a frame: neither does the sensor turn, nor the patch move in the picture.
//!
//! Not in the paper. [`super::stillness`] knows what came before, and a wrist that goes slowly and evenly looks to it as if it
//! lay still. Who sees what comes after too, and the picture, can tell them apart.

use super::memory::Kept;
use super::state::{POSITION, View};
use nalgebra::{Vector2, Vector3};

/// So much before and behind a frame is looked at, s.
const HALF_S: f64 = 0.5;
/// Less than this of both together tells nothing, s.
const LEAST_S: f64 = 0.4;
/// The sensor turns by less, rad: who moves by a centimetre turns an arm by more.
const TURN: f64 = 0.016;
/// The patch moves across the picture by less from one half of it to the other, m/s.
const ACROSS_M_S: f64 = 0.016;
/// And is seen so often in either.
const LEAST_SEEN: usize = 4;

/// In which of the frames the arm lies still.
pub(super) fn still(frames: &[Kept], views: &[View]) -> Vec<bool> {
    let (mut from, mut to) = (0, 0);
    let mut found = Vec::with_capacity(frames.len());
    for frame in frames {
        while frames[from].time_s < frame.time_s - HALF_S {
            from += 1;
        }
        while to < frames.len() && frames[to].time_s <= frame.time_s + HALF_S {
            to += 1;
        }
        let about = &frames[from..to];
        let lasted_s = about[about.len() - 1].time_s - about[0].time_s;
        let turns = about.iter().any(|other| angle(frame, other) > TURN);
        found.push(lasted_s >= LEAST_S && !turns && stays(about, views, frame));
    }
    found
}

/// How far the sensor is turned from one frame to another, rad.
fn angle(a: &Kept, b: &Kept) -> f64 {
    2.0 * (a.world_sensor.conjugate() * b.world_sensor).v.norm().min(1.0).asin()
}

/// Whether some camera saw the patch, and none saw it move.
fn stays(about: &[Kept], views: &[View], frame: &Kept) -> bool {
    let [first_s, last_s] = [about[0].time_s, about[about.len() - 1].time_s];
    let half_s = 0.5 * (last_s - first_s);
    let middle_s = first_s + half_s;
    let (before, after) = about.split_at(about.partition_point(|other| other.time_s < middle_s));
    let wrist: Vector3<f64> = frame.means[0].fixed_rows::<3>(POSITION).into();
    let moved_m = |(camera, view): (usize, &View)| {
        let m_per_px = view.camera.depth(wrist) / view.camera.matrix()[(0, 0)];
        Some((mean(after, camera)? - mean(before, camera)?).norm() * m_per_px)
    };
    let mut moved = views.iter().enumerate().filter_map(moved_m).peekable();
    moved.peek().is_some() && moved.all(|moved_m| moved_m < ACROSS_M_S * half_s)
}

/// Where a camera saw the patch in the mean, px; none where it was hardly seen.
fn mean(frames: &[Kept], camera: usize) -> Option<Vector2<f64>> {
    let seen = || frames.iter().filter_map(|frame| frame.pixels[camera]);
    let count = seen().count();
    (count >= LEAST_SEEN).then(|| seen().sum::<Vector2<f64>>() / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::quaternion::Quaternion;
    use nalgebra::{DVector, Matrix3};

    /// Five seconds at 25 a second of a patch that goes at such a speed, px/s, and a sensor that turns, rad/s, from 2.5 s on.
    fn told(px_per_s: f64, turn_rate: f64, seen: impl Fn(usize) -> bool) -> Vec<bool> {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        let kept = |k: usize| {
            let (time_s, tremble) = (0.04 * k as f64, [0.7, -0.7][k % 2]);
            let gone_s = (time_s - 2.5).max(0.0);
            let pixel = Vector2::new(320.0 + tremble + px_per_s * gone_s, 240.0 - tremble);
            Kept {
                time_s,
                world_sensor: Quaternion::from_rotation_vector(Vector3::new(0.0, turn_rate * gone_s, 0.0)),
                pixels: vec![seen(k).then_some(pixel)],
                landmarks: Vec::new(),
                is_unknown: false,
                start: None,
                means: [DVector::zeros(6), DVector::zeros(6)],
                filtered: None,
            }
        };
        let frames: Vec<Kept> = (0..125).map(kept).collect();
        still(&frames, &[View { camera, patch_offset: Vector3::zeros() }])
    }

    #[test]
    fn what_neither_turns_nor_moves_lies_still_to_both_ends() {
        assert!(told(0.0, 0.0, |_| true).iter().all(|still| *still));
    }

    #[test]
    fn what_goes_slowly_does_not() {
        for found in [told(8.0, 0.0, |_| true), told(0.0, 0.06, |_| true)] {
            assert!(found[..50].iter().all(|still| *still), "until it is near");
            assert!(!found[70..].iter().any(|still| *still));
        }
    }

    #[test]
    fn what_is_not_seen_is_not_known() {
        assert!(!told(0.0, 0.0, |_| false).iter().any(|still| *still));
        let found = told(0.0, 0.0, |k| k < 60);
        assert!(found[40] && !found[80]);
    }

    #[test]
    fn of_no_frames_nothing_is_told() {
        assert_eq!(still(&[], &[]), Vec::<bool>::new());
    }
}
