//! What one camera does not see of the body as a whole: its distance, its lean towards the camera, its turn; and where skin and
//! outlines are all that it sees, where exactly joints are within them.
//!
//! Each of the first three moves joints along their viewing rays and, to first order and for a trunk that lies in the picture's
//! plane, leaves the picture as it was: the distance all alike, a lean in proportion to the height above the root, a turn to
//! the place beside it. An arm goes with its shoulder: how it is foreshortened says where it is from there. The 11 channels
//! hold all of it and the evidence says nothing of them, so that their posterior is what is known beforehand:
//! normal, at the first frame no more than its pose is unsure of, the whole after some seconds. It is marginalised: their
//! covariance is added to that of the particles, which would be spent on what no weight tells apart were layers to draw it.
//! Who asks for the particles gets them with a draw of each.
//!
//! A trunk that came down may have bent towards the camera as well as gone down with its legs, which are not looked at: so far
//! it may lean besides.

use super::joints::KEY_JOINTS;
use crate::Result;
use crate::error::require;
use crate::particles::{ParticleSet, Summary};
use crate::projection::Projection;
use crate::rng::Streams;
use nalgebra::{DMatrix, Vector3};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// How soon a body forgets the pose of its first frame: the correlation time of an Ornstein-Uhlenbeck process, s.
const MEMORY_S: f64 = 1.0;

/// No body is farther away, m, or turns more, rad.
const MOST: f64 = 100.0;

/// Distance, lean, turn, and places beside and above.
pub const UNSEEN: usize = 5;
/// Coordinates of the key joints.
const COORDINATES: usize = 3 * KEY_JOINTS.len();
/// What names the streams that they are drawn from: they decide nothing, so that no seed does.
const DRAWS: u64 = 0x756e_7365_656e;

/// The joint that a key joint goes with: an elbow or a wrist with its shoulder.
const GOES_WITH: [usize; KEY_JOINTS.len()] = [0, 1, 2, 3, 2, 3, 2, 3];

/// People go up and down by so much where they neither bend nor crouch, m.
const UP_AND_DOWN_M: f64 = 0.03;

/// By how much a trunk whose shoulders are so far above its root, m, must bend to be lower by so much, m: rad.
fn bend(lower_m: f64, trunk_m: f64) -> f64 {
    (1.0 - (lower_m - UP_AND_DOWN_M).max(0.0) / trunk_m.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0).acos()
}

/// From what a body is known at a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// How long after the first frame, s.
    pub since_s: f64,
    /// Outlines and skin are all that shows it: no detector saw its joints.
    pub by_outlines: bool,
    /// How far above the ground, or whatever heights are counted from, the root was at the first frame, m.
    pub root_m: f64,
}

/// Standard deviations of what is not seen; all zero is the paper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unseen {
    /// Of the root's distance, m.
    pub distance_m: f64,
    /// Of its distance at the first frame, and so in all, m.
    pub first_distance_m: f64,
    /// Of the trunk's lean towards the camera, rad.
    pub lean: f64,
    /// Of the trunk's turn about its long axis, rad.
    pub turn: f64,
    /// Of joints in the picture, along each of its axes, m: where the person's outlines and skin are all that shows them.
    pub across_m: f64,
    /// Of the trunk's lean, as a share of the bend by which it would be as low as it is.
    pub bend: f64,
}

impl Unseen {
    /// Check every range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        let zero_or_more = |x: f64| (0.0..=MOST).contains(&x);
        require(zero_or_more(self.distance_m), "unseen_distance_sd_m", self.distance_m, "0 m or more")?;
        let first = self.first_distance_m;
        require(zero_or_more(first), "first_distance_sd_m", first, "0 m or more")?;
        require(zero_or_more(self.lean), "unseen_lean_sd_rad", self.lean, "0 rad or more")?;
        require(zero_or_more(self.turn), "unseen_turn_sd_rad", self.turn, "0 rad or more")?;
        require(zero_or_more(self.across_m), "unseen_across_sd_m", self.across_m, "0 m or more")?;
        require((0.0..=1.0).contains(&self.bend), "unseen_bend", self.bend, "a share from 0 to 1")
    }

    /// Whether there is none of it, whatever the time.
    pub fn is_none(&self) -> bool {
        [self.distance_m, self.first_distance_m, self.lean, self.turn, self.across_m, self.bend] == [0.0; 6]
    }

    /// Standard deviations of distance, m, lean and turn, rad, and places, m, in that case; of key joints of those heights, m.
    fn sds(&self, Known { since_s, by_outlines, root_m }: Known, height_m: impl Fn(usize) -> f64) -> [f64; UNSEEN] {
        let grown = (-(-2.0 * since_s / MEMORY_S).exp_m1()).sqrt();
        let across_m = if by_outlines { self.across_m } else { 0.0 };
        let [distance, lean, turn, across] = [self.distance_m, self.lean, self.turn, across_m].map(|sd| sd * grown);
        let trunk_m = f64::midpoint(height_m(2), height_m(3)) - height_m(0);
        let bent = self.bend * bend(root_m - height_m(0), trunk_m);
        [distance.hypot(self.first_distance_m), lean.hypot(bent), turn, across, across]
    }

    /// Particles `(N, D)` with columns for distance, m, lean and turn, rad, and places, m, `(N, D + 5)`: each drawn from what is
    /// known of them, their key joints being about there `(8 * 3,)`, m. A particle has the same draw, in standard deviations,
    /// whenever it is asked.
    pub fn drawn(&self, particles: &ParticleSet, known: Known, joints: &[f64]) -> ParticleSet {
        let (dim, sds) = (particles.dim(), self.sds(known, |joint| joints[3 * joint + 1]));
        let mut all = particles.mapped(dim + UNSEEN, |block, out| {
            (0..dim).for_each(|d| out.column_mut(d).copy_from_slice(block.column(d)));
        });
        let streams = Streams::new(DRAWS, 0, 0);
        all.for_each_block(|index, mut block| {
            let mut stream = streams.block(index);
            for (k, sd) in sds.into_iter().enumerate() {
                block.column_mut(dim + k).fill_with(|| sd * stream.sample::<f64, _>(StandardNormal));
            }
        });
        all
    }

    /// Key joints `(8 * 3,)` m, moved by a distance, m, a lean and a turn, rad, and places beside and above, m.
    pub fn moved(joints: &[f64], unseen: [f64; UNSEEN], projection: &Projection) -> Vec<f64> {
        let moved = moves(|k| joints[k], unseen, projection).column_sum();
        joints.iter().zip(&moved).map(|(at, by)| at + by).collect()
    }

    /// Add it to covariance and bands of the key joints, `(8 * 3,)` m. Mean and mode stay.
    pub fn add(&self, joints: &mut Summary, projection: &Projection, known: Known) {
        let sds = self.sds(known, |joint| joints.mean[3 * joint + 1]);
        if sds == [0.0; UNSEEN] {
            return;
        }
        // One standard deviation of each.
        let moves = moves(|k| joints.mean[k], sds, projection);
        let added = &moves * moves.transpose();
        for (d, band) in joints.bands.iter_mut().enumerate() {
            *band = band.widened(joints.mean[d], added[(d, d)].sqrt());
        }
        joints.covariance += added;
    }
}

/// How far a distance, m, a lean and a turn, rad, and places beside and above, m, each move every coordinate of the key joints,
/// `(8 * 3, 5)`.
fn moves(joints: impl Fn(usize) -> f64, by: [f64; UNSEEN], projection: &Projection) -> DMatrix<f64> {
    let at = |joint: usize| Vector3::from_fn(|d, _| joints(3 * joint + d));
    let [up, beside] = across(projection.viewing_direction(at(0)));
    let mut moves = DMatrix::zeros(COORDINATES, UNSEEN);
    for (joint, with) in GOES_WITH.into_iter().enumerate() {
        let reach = at(with) - at(0);
        let along = projection.viewing_direction(at(joint));
        let in_depth = [by[0], by[1] * reach.dot(&up), by[2] * reach.dot(&beside)].map(|depth| along * depth);
        for (k, moved) in in_depth.into_iter().chain([beside * by[3], up * by[4]]).enumerate() {
            moves.fixed_view_mut::<3, 1>(3 * joint, k).copy_from(&moved);
        }
    }
    moves
}

/// Up in the picture and across it, for a world whose y is up.
fn across(away: Vector3<f64>) -> [Vector3<f64>; 2] {
    // From straight above a lean and a turn are not told apart; any direction across will do.
    let beside = Vector3::y().cross(&away).try_normalize(1e-6).unwrap_or(Vector3::x());
    [away.cross(&beside), beside]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::particles::{NORMAL_UPPER, ParticleSet};
    use nalgebra::Matrix3;

    const SD: Unseen =
        Unseen { distance_m: 0.05, first_distance_m: 0.0, lean: 0.1, turn: 0.2, across_m: 0.03, bend: 0.0 };

    fn at(since_s: f64) -> Known {
        Known { since_s, by_outlines: false, root_m: 1.0 }
    }

    fn close(a: f64, b: f64, within: f64) {
        assert!((a - b).abs() <= within, "{a} is not {b} within {within}");
    }

    /// Of weighted particles: a root, seven joints half a metre above and 0.2 m beside it.
    fn joints() -> Summary {
        let row = |i: usize| {
            let of = move |joint: usize| {
                let spread = 0.001 * (i * joint) as f64;
                if joint == 0 { [0.1, 1.0, 3.0] } else { [0.3 + spread, 1.5 - spread, 3.0 + spread] }
            };
            (0..8).flat_map(of)
        };
        let mut set = ParticleSet::from_rows(24, &(0..40).flat_map(row).collect::<Vec<_>>()).unwrap();
        set.reweigh(&(0..40).map(|i| -0.1 * f64::from(i)).collect::<Vec<_>>()).unwrap();
        set.summary(24)
    }

    fn front() -> Projection {
        Projection::weak([[100.0, 0.0, 0.0, 160.0], [0.0, -100.0, 0.0, 240.0]]).unwrap()
    }

    #[test]
    fn depth_is_spread_and_nothing_else() {
        let (seen, mut all) = (joints(), joints());
        SD.add(&mut all, &front(), at(1e3));
        assert_eq!((&seen.mean, &seen.mode), (&all.mean, &all.mode));
        for d in 0..24 {
            let added = all.covariance[(d, d)] - seen.covariance[(d, d)];
            let (before, after) = (seen.bands[d], all.bands[d]);
            if d % 3 < 2 {
                assert_eq!((added, before), (0.0, after));
                continue;
            }
            let (up, beside) = (all.mean[3 * GOES_WITH[d / 3] + 1] - 1.0, all.mean[3 * GOES_WITH[d / 3]] - 0.1);
            close(added, 0.05f64.powi(2) + (0.1 * up).powi(2) + (0.2 * beside).powi(2), 1e-12);
            let half = (all.mean[d] - before.lo).hypot(NORMAL_UPPER * added.sqrt());
            close(all.mean[d] - after.lo, half, 1e-12);
            assert!(after.hi > before.hi);
        }
        // What moves the root moves the wrists with it.
        close(all.covariance[(2, 23)] - seen.covariance[(2, 23)], 0.05f64.powi(2), 1e-12);
    }

    /// Along both axes of the picture, as depth is along none; a detector's points say more.
    #[test]
    fn outlines_do_not_tell_where_in_them_joints_are() {
        let (seen, mut all) = (joints(), joints());
        SD.add(&mut all, &front(), Known { by_outlines: true, ..at(1e3) });
        let mut in_depth = joints();
        SD.add(&mut in_depth, &front(), at(1e3));
        for d in 0..24 {
            let added = all.covariance[(d, d)] - in_depth.covariance[(d, d)];
            close(added, if d % 3 < 2 { 0.03f64.powi(2) } else { 0.0 }, 1e-12);
            assert!(d % 3 == 2 || all.bands[d].hi > seen.bands[d].hi);
        }
    }

    #[test]
    fn it_grows_from_nothing() {
        let sd = |since_s: f64| {
            let mut all = joints();
            SD.add(&mut all, &front(), at(since_s));
            all.covariance[(2, 2)].sqrt()
        };
        let mut at_once = joints();
        SD.add(&mut at_once, &front(), at(0.0));
        assert_eq!(at_once, joints());
        close(sd(50.0), 0.05, 1e-12);
        close(sd(0.5), 0.05 * (1.0 - (-1.0f64).exp()).sqrt(), 1e-12);
    }

    /// Of a trunk of half a metre that is lower by a quarter: bent by 60° or gone down.
    #[test]
    fn a_trunk_that_came_down_may_have_bent() {
        let bending = Unseen { bend: 0.5, ..SD };
        let lean =
            |root_m: f64| bending.sds(Known { root_m, ..at(1e3) }, |joint| if joint == 0 { 1.0 } else { 1.5 })[1];
        close(lean(1.0), 0.1, 1e-12);
        close(lean(1.0 + UP_AND_DOWN_M), 0.1, 1e-12);
        close(lean(0.5), 0.1, 1e-12);
        close(lean(1.25 + UP_AND_DOWN_M), 0.1f64.hypot(0.5 * 60f64.to_radians()), 1e-12);
        close(lean(9.0), 0.1f64.hypot(0.25 * std::f64::consts::PI), 1e-12);
        assert_eq!(SD.sds(Known { root_m: 1.25, ..at(1e3) }, |_| 1.0)[1], SD.sds(at(1e3), |_| 1.0)[1]);
    }

    #[test]
    fn a_first_pose_that_is_unsure_of_its_distance_is_so_from_the_first() {
        let unsure = Unseen { first_distance_m: 0.12, ..SD };
        for (since_s, expected) in [(0.0, 0.12), (50.0, 0.13)] {
            let mut all = joints();
            unsure.add(&mut all, &front(), at(since_s));
            close(all.covariance[(2, 2)].sqrt(), expected, 1e-12);
        }
    }

    /// Through a pinhole every joint has a ray of its own.
    #[test]
    fn pixels_stay_where_they_are() {
        let matrix = Matrix3::new(500.0, 0.0, 160.0, 0.0, 500.0, 120.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::zeros()).unwrap();
        let projection = Projection::Pinhole(Box::new(camera));
        let (seen, mut all) = (joints(), joints());
        SD.add(&mut all, &projection, at(1e3));
        for joint in 0..8 {
            let at = Vector3::from_fn(|d, _| all.mean[3 * joint + d]);
            let added = (&all.covariance - &seen.covariance).fixed_view::<3, 3>(3 * joint, 3 * joint).into_owned();
            // All of it lies along the ray.
            let ray = projection.viewing_direction(at);
            close((added - ray * ray.transpose() * added.trace()).amax(), 0.0, 1e-12);
            let (before, after) = (projection.see(at.into()), projection.see((at + 0.1 * ray).into()));
            close(before.u, after.u, 1e-9);
            close(before.v, after.v, 1e-9);
        }
    }

    #[test]
    fn directions_are_at_right_angles() {
        for away in [Vector3::z(), -Vector3::z(), Vector3::new(0.3, -0.4, 0.8).normalize(), -Vector3::y()] {
            let [up, beside] = across(away);
            for (x, y) in [(away, up), (away, beside), (up, beside)] {
                close(x.dot(&y), 0.0, 1e-12);
            }
            close(up.norm(), 1.0, 1e-12);
            close(beside.norm(), 1.0, 1e-12);
        }
    }

    #[test]
    fn ranges() {
        assert!(
            Unseen { distance_m: 0.0, first_distance_m: 0.0, lean: 0.0, turn: 0.0, across_m: 0.0, bend: 0.0 }
                .check()
                .is_ok()
        );
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(Unseen { distance_m: bad, ..SD }.check().is_err());
            assert!(Unseen { first_distance_m: bad, ..SD }.check().is_err());
            assert!(Unseen { lean: bad, ..SD }.check().is_err());
            assert!(Unseen { turn: bad, ..SD }.check().is_err());
            assert!(Unseen { across_m: bad, ..SD }.check().is_err());
            assert!(Unseen { bend: bad, ..SD }.check().is_err());
        }
    }
}
