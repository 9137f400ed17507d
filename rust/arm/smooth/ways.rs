//! Ways in which an arm may have gone: trajectories that a smoother starts from.
//!
//! The patch's ray meets the sphere on which the arm's length holds the wrist twice, and a trajectory that was started at the wrong
//! depth settles there. So it is started from what the mixture made of it, and from either depth.

use super::branch::ArmBranch;
use crate::arm::posed::sightings;
use crate::arm::state::{POSITION, VELOCITY};
use crate::filter::Settled;
use nalgebra::{DVector, Vector3};

/// Trajectories that are nearer on average are one, m.
const ONE_M: f64 = 0.01;

/// Those that are not one, the likeliest first.
pub(super) fn distinct(mut settled: Vec<Settled>) -> Vec<Vec<DVector<f64>>> {
    settled.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut kept: Vec<Vec<DVector<f64>>> = Vec::new();
    for Settled { at, .. } in settled {
        if kept.iter().all(|other| apart(other, &at) > ONE_M) {
            kept.push(at);
        }
    }
    kept
}

/// How far the wrists of two trajectories are apart on average, m.
fn apart(a: &[DVector<f64>], b: &[DVector<f64>]) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a.fixed_rows::<3>(POSITION) - b.fixed_rows::<3>(POSITION)).norm());
    off.sum::<f64>() / a.len() as f64
}

/// The mixture's trajectory, that of its heaviest component, and where an arm's length holds the wrist the nearer and the farther depth
/// throughout.
pub(super) fn starts(branch: &ArmBranch<'_>) -> Vec<Vec<DVector<f64>>> {
    let of_mixture = [0, 1].map(|which| branch.steps.iter().map(|step| step.means[which].clone()).collect());
    let sides: &[f64] = if branch.filter.is_held_by_arm() { &[-1.0, 1.0] } else { &[] };
    of_mixture.into_iter().chain(sides.iter().map(|side| at_depth(branch, *side))).collect()
}

/// The mixture's trajectory, moved to the nearer (-1) or the farther (1) of the two depths; where the patch is not seen, by as much as when
/// it was last.
fn at_depth(branch: &ArmBranch<'_>, side: f64) -> Vec<DVector<f64>> {
    let mut off = Vector3::zeros();
    let mut moved: Vec<DVector<f64>> = Vec::with_capacity(branch.steps.len());
    for step in branch.steps {
        let mut state = step.means[0].clone();
        let wrist: Vector3<f64> = state.fixed_rows::<3>(POSITION).into();
        if let Some(sighting) = sightings(branch.views, step.pixels).first() {
            let camera = &sighting.view.camera;
            let origin = camera.centre() - step.world_sensor.rotate(sighting.view.patch_offset);
            let ray = camera.ray(sighting.pixel);
            let middle = branch.arm.shoulder - step.world_sensor.rotate(branch.arm.elbow_in_sensor());
            let nearest = ray.dot(&(middle - origin));
            let miss = (origin + nearest * ray - middle).norm();
            let half = (branch.arm.upper_arm_m.powi(2) - miss * miss).max(0.0).sqrt();
            off = origin + (nearest + side * half) * ray - wrist;
        }
        state.fixed_rows_mut::<3>(POSITION).copy_from(&(wrist + off));
        moved.push(state);
    }
    set_velocities(branch, &mut moved);
    moved
}

/// Velocities as the places have them.
fn set_velocities(branch: &ArmBranch<'_>, moved: &mut [DVector<f64>]) {
    for k in 0..moved.len() {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(moved.len() - 1));
        let elapsed_s = (branch.steps[after].time_s - branch.steps[before].time_s).max(f64::MIN_POSITIVE);
        let way = moved[after].fixed_rows::<3>(POSITION) - moved[before].fixed_rows::<3>(POSITION);
        moved[k].fixed_rows_mut::<3>(VELOCITY).copy_from(&(way / elapsed_s));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::cues::CueName;
    use crate::arm::mixture::ArmMixture;
    use crate::arm::process::GaussMarkov;
    use crate::arm::smooth::branch::Step;
    use crate::arm::state::{Arm, Noise, View};
    use crate::arm::worn::{Moved, WornMotion};
    use crate::camera::Camera;
    use crate::quaternion::Quaternion;
    use nalgebra::{Matrix3, Vector2};

    fn settled(x: f64, cost: f64) -> Settled {
        Settled { at: vec![DVector::from_element(6, x); 3], cost, log_evidence: 0.0, is_settled: true }
    }

    #[test]
    fn of_those_that_are_one_the_likeliest_stays() {
        let kept = distinct(vec![settled(0.0, 9.0), settled(0.5, 3.0), settled(0.502, 1.0)]);
        assert_eq!(kept.iter().map(|states| states[0][0]).collect::<Vec<_>>(), [0.502, 0.0]);
    }

    /// Either depth is on the patch's ray, as far from the shoulder as the arm is long; hidden, it stays as far from the mixture's.
    #[test]
    fn both_depths_are_on_the_ray_and_on_the_sphere() {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        let views = [View { camera, patch_offset: Vector3::new(0.01, 0.0, 0.02) }];
        let arm = Arm {
            shoulder: Vector3::new(0.1, 0.0, 0.2),
            upper_arm_m: 0.3,
            forearm_m: 0.25,
            wrist_start: Vector3::new(0.1, -0.2, 0.1),
        };
        let noise = Noise::default();
        let zero = Some(GaussMarkov { start_sd: 0.0, density: 0.0 });
        let filter = ArmMixture::new(&arm, &noise, &[CueName::ArmLength], 12);
        let pixels = [vec![Some(Vector2::new(345.0, 205.0))], vec![Some(Vector2::new(350.0, 200.0))], vec![None]];
        let q = Quaternion::from_wxyz([0.5, 0.1, -0.7, 0.5]).normalized();
        let still = Moved::new(WornMotion::none(), &Noise { bias: zero, tilt: zero, ..noise.clone() });
        let step = |k: usize| Step {
            time_s: 0.04 * k as f64,
            spread: still.spread(),
            moved: still.clone(),
            world_sensor: q,
            stale_s: 0.0,
            rest: None,
            is_new: true,
            pixels: &pixels[k],
            landmarks: &[],
            upper_arm: None,
            start: None,
            means: [0.1, 0.2].map(|x| DVector::from_element(6, x)),
        };
        let steps: Vec<Step<'_>> = (0..3).map(step).collect();
        let branch = ArmBranch { arm: &arm, noise: &noise, views: &views, filter: &filter, steps: &steps };
        let found = starts(&branch);
        assert_eq!(found.len(), 4);
        let wrist = |way: usize, k: usize| -> Vector3<f64> { found[way][k].fixed_rows::<3>(POSITION).into() };
        for way in [2, 3] {
            for k in [0, 1] {
                let seen = views[0].camera.project(wrist(way, k) + q.rotate(views[0].patch_offset)).unwrap();
                assert!((seen - pixels[k][0].unwrap()).norm() < 1e-6);
                let elbow = wrist(way, k) + q.rotate(arm.elbow_in_sensor());
                assert!(((elbow - arm.shoulder).norm() - arm.upper_arm_m).abs() < 1e-9);
            }
            assert!((wrist(way, 2) - wrist(way, 1)).norm() < 1e-12);
            let speed: Vector3<f64> = found[way][1].fixed_rows::<3>(VELOCITY).into();
            assert!((speed - (wrist(way, 2) - wrist(way, 0)) / 0.08).norm() < 1e-9);
        }
        assert!(wrist(2, 0).z < wrist(3, 0).z - 0.1);
        let free = ArmMixture::new(&arm, &noise, &[], 12);
        assert_eq!(starts(&ArmBranch { filter: &free, ..branch }).len(), 2);
    }
}
