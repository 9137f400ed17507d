//! What one camera does not see: how far off the body is, how far it leans towards the camera, how far it has turned.
//!
//! Each of the three moves every joint along the viewing direction and, to first order, leaves the picture as it was: the
//! distance all alike, a lean in proportion to a joint's height above the root, a turn to its place beside it. The
//! 11 channels hold all three, the evidence says nothing of them, so that their posterior is what is known
//! beforehand: normal, nothing at the first frame (whose pose is given), the whole after some seconds. It is
//! added to what the particles say, not drawn in the filter, which would spend particles on what no weight tells apart.

use super::figure::KEY_JOINTS;
use crate::Result;
use crate::error::require;
use crate::particles::ParticleSet;
use crate::projection::Projection;
use crate::rng::{BLOCK, Streams};
use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// How soon a body forgets the pose of its first frame: the correlation time of an Ornstein-Uhlenbeck process, s.
const MEMORY_S: f64 = 1.0;

/// How every particle is moved: each of the three as often one way as the other, so that means stay as they are, and any two
/// as often alike as not, so that they are independent of each other.
const SIGNS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Standard deviations of what is not seen; all zero is the paper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unseen {
    /// Of the root's distance, m.
    pub distance_m: f64,
    /// Of the trunk's lean towards the camera, rad.
    pub lean: f64,
    /// Of the trunk's turn about its long axis, rad.
    pub turn: f64,
}

impl Unseen {
    /// Check every range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] naming the first that is out of range.
    pub fn check(&self) -> Result<()> {
        let zero_or_more = |x: f64| x >= 0.0 && x.is_finite();
        require(zero_or_more(self.distance_m), "unseen_distance_sd_m", self.distance_m, "0 m or more")?;
        require(zero_or_more(self.lean), "unseen_lean_sd_rad", self.lean, "0 rad or more")?;
        require(zero_or_more(self.turn), "unseen_turn_sd_rad", self.turn, "0 rad or more")
    }

    /// Key joints, `(N, 8 * 3)` m, `since_s` after the first frame, spread by what is not seen: every particle four
    /// times. `root` is where the body is.
    pub fn added(&self, joints: ParticleSet, projection: &Projection, root: Vector3<f64>, since_s: f64) -> ParticleSet {
        let grown = (-(-2.0 * since_s / MEMORY_S).exp_m1()).sqrt();
        let sd = [self.distance_m, self.lean, self.turn].map(|sd| sd * grown);
        if sd == [0.0; 3] {
            return joints;
        }
        let [away, up, beside] = directions(projection.viewing_direction(root));
        let scores = normal_scores(joints.len());
        let count = joints.len();
        let mut spread = ParticleSet::together(&[&joints; SIGNS.len()]);
        spread.for_each_block(|b, mut block| {
            for i in 0..block.len() {
                let (copy, particle) = ((b * BLOCK + i) / count, (b * BLOCK + i) % count);
                let [off, lean, turn] = [0, 1, 2].map(|k| SIGNS[copy][k] * sd[k] * scores[particle][k]);
                let hip = [0, 1, 2].map(|d| block.column_mut(d)[i]);
                for joint in 0..KEY_JOINTS.len() {
                    let reach = Vector3::from_fn(|d, _| block.column_mut(3 * joint + d)[i] - hip[d]);
                    let shift = away * (off + lean * reach.dot(&up) + turn * reach.dot(&beside));
                    for d in 0..3 {
                        block.column_mut(3 * joint + d)[i] += shift[d];
                    }
                }
            }
        });
        spread
    }
}

/// Away from the camera, up in the picture and across it, for a world whose y is up.
fn directions(away: Vector3<f64>) -> [Vector3<f64>; 3] {
    // From straight above a lean and a turn are not told apart; any direction across will do.
    let across = Vector3::y().cross(&away).try_normalize(1e-6).unwrap_or(Vector3::x());
    [away, away.cross(&across), across]
}

/// Three standard normal numbers a particle, the same in every frame so that bands do not flicker, of mean square one.
fn normal_scores(count: usize) -> Vec<[f64; 3]> {
    let mut stream = Streams::new(0, 0, 0).block(0);
    let mut scores: Vec<[f64; 3]> =
        (0..count).map(|_| std::array::from_fn(|_| stream.sample(StandardNormal))).collect();
    for k in 0..3 {
        let scale = (scores.iter().map(|s| s[k] * s[k]).sum::<f64>() / count as f64).sqrt();
        for score in &mut scores {
            score[k] /= scale;
        }
    }
    scores
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, within: f64) {
        assert!((a - b).abs() <= within, "{a} is not {b} within {within}");
    }

    fn joints() -> ParticleSet {
        // 40 particles: a root that stands still, seven joints half a metre up and 0.2 m beside, a little apart.
        let row = |i: usize| {
            let mut row = vec![0.1, 1.0, 0.0];
            for joint in 1..8 {
                row.extend([0.3, 1.5, 0.001 * (i * joint) as f64]);
            }
            row
        };
        ParticleSet::from_rows(24, &(0..40).flat_map(row).collect::<Vec<_>>()).unwrap()
    }

    fn front() -> Projection {
        Projection::weak([[100.0, 0.0, 0.0, 160.0], [0.0, -100.0, 0.0, 240.0]]).unwrap()
    }

    #[test]
    fn depth_is_spread_and_nothing_else() {
        let unseen = Unseen { distance_m: 0.05, lean: 0.1, turn: 0.2 };
        let (seen, all) = (joints().summary(24), unseen.added(joints(), &front(), Vector3::zeros(), 1e3).summary(24));
        for d in 0..24 {
            close(seen.mean[d], all.mean[d], 1e-12);
            let added = all.covariance[(d, d)] - seen.covariance[(d, d)];
            // Of the root the distance alone; above and beside it lean and turn too, drawn independently of each other.
            let (off, lean, turn) = (0.05f64.powi(2), 0.05f64.powi(2), 0.04f64.powi(2));
            match d {
                _ if d % 3 < 2 => close(added, 0.0, 1e-12),
                2 => close(added, off, 1e-12),
                _ => close(added, off + lean + turn, 1e-12),
            }
        }
    }

    #[test]
    fn it_grows_from_nothing() {
        let unseen = Unseen { distance_m: 0.05, lean: 0.1, turn: 0.1 };
        let sd = |since_s: f64| {
            unseen.added(joints(), &front(), Vector3::zeros(), since_s).summary(24).covariance[(2, 2)].sqrt()
        };
        assert_eq!(unseen.added(joints(), &front(), Vector3::zeros(), 0.0), joints());
        assert!(sd(0.1) < sd(0.5) && sd(0.5) < sd(5.0));
        close(sd(50.0), 0.05, 1e-12);
        close(sd(0.5), 0.05 * (1.0 - (-1.0f64).exp()).sqrt(), 1e-12);
    }

    #[test]
    fn directions_are_at_right_angles() {
        for away in [Vector3::z(), -Vector3::z(), Vector3::new(0.3, -0.4, 0.8).normalize(), -Vector3::y()] {
            let [a, u, s] = directions(away);
            for (x, y) in [(a, u), (a, s), (u, s)] {
                close(x.dot(&y), 0.0, 1e-12);
            }
            close(u.norm(), 1.0, 1e-12);
            close(s.norm(), 1.0, 1e-12);
        }
    }

    #[test]
    fn ranges() {
        assert!(Unseen { distance_m: 0.0, lean: 0.0, turn: 0.0 }.check().is_ok());
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(Unseen { distance_m: bad, lean: 0.0, turn: 0.0 }.check().is_err());
            assert!(Unseen { distance_m: 0.0, lean: bad, turn: 0.0 }.check().is_err());
            assert!(Unseen { distance_m: 0.0, lean: 0.0, turn: bad }.check().is_err());
        }
    }
}
