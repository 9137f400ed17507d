//! How people hold their arms: a density that was learned from captured motion.
//!
//! Not in the paper. One camera hardly tells whether a limb leans towards it or away; people hold their forearms before
//! the body, and where their upper arms are tells where their forearms may be. A mixture of Gaussians over the directions of
//! upper arm and forearm, seen from the trunk (`posture_table.rs`), and beside it, with a share of a tenth, any other.

use super::super::figure::Figure;
use super::super::joints::{Group, KEY_JOINTS};
use super::super::sloped::{Rows, Sloped};
use super::super::weighing::{Cue, Posed};
use super::posture_table::{COMPONENTS, Component};
use crate::Result;
use crate::parameters::{Parameters, require_not_negative};
use nalgebra::{DVector, Matrix3, Matrix3xX, Matrix6xX, Unit, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Share of poses that are as likely as any.
const ANY: f64 = 0.1;

/// Root and shoulders among the points of the figure.
const TRUNK: [usize; 3] = [0, 2, 3];

/// Shoulder, elbow and wrist of either arm, and where its outside is.
const ARMS: [(Group, [usize; 3], f64); 2] = [(Group::LeftArm, [2, 4, 6], 1.0), (Group::RightArm, [3, 5, 7], -1.0)];

/// Nothing is more likely than the likeliest by so much: the slope of a square root would have no end there.
const NEAR_PEAK: f64 = 1e-3;

/// How much it counts how arms are held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PostureParameters {
    /// Share of the log-density.
    pub weight: f64,
}

impl PostureParameters {
    /// Of a method's `posture_weight`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self { weight: from.get("posture_weight")? })
    }

    /// Check its range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_not_negative("posture_weight", self.weight, "0 or more")
    }
}

/// What the arms of some groups lose.
pub struct Posture<'a> {
    /// Groups whose arms count.
    pub groups: &'a [Group],
    /// How much they count.
    pub parameters: PostureParameters,
}

impl Posture<'_> {
    fn arms(&self) -> impl Iterator<Item = ([usize; 3], f64)> {
        ARMS.into_iter().filter(|(group, ..)| self.groups.contains(group)).map(|(_, points, side)| (points, side))
    }
}

impl Cue for Posture<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let least = likeliest();
        for (i, out) in out.iter_mut().enumerate() {
            let at = |point: usize| Vector3::from(posed.at(i, point));
            let Some(axes) = trunk(TRUNK.map(at)) else { continue };
            for (points, side) in self.arms() {
                if let Some(limbs) = limbs(points.map(at)) {
                    *out += self.parameters.weight * (surprise(&seen_from(&axes, &limbs, side)).0 - least);
                }
            }
        }
    }

    /// As the square of a number that is zero in the likeliest pose.
    fn linearise(&self, at: &Sloped<'_>, rows: &mut Rows) {
        let weight = self.parameters.weight;
        let Some(axes) = trunk(TRUNK.map(|point| at.at(point))).filter(|_| weight > 0.0) else { return };
        let turning = trunk_slope(&axes, TRUNK.map(|point| at.at(point)), &TRUNK.map(|point| at.slope(point)));
        for (points, side) in self.arms() {
            let places = points.map(|point| at.at(point));
            let Some(limbs) = limbs(places) else { continue };
            let (surprise, by_directions) = surprise(&seen_from(&axes, &limbs, side));
            let moved = points.map(|point| at.slope(point));
            let slope = seen_slope((&axes, &turning), &limbs, &limbs_slope(&limbs, places, &moved), side);
            let off = (2.0 * weight * (surprise - likeliest()).max(NEAR_PEAK)).sqrt();
            rows.push(-off, slope.tr_mul(&by_directions) * (weight / off), 1.0);
        }
    }

    fn reads(&self, _: &Figure) -> usize {
        KEY_JOINTS.len()
    }
}

/// Axes of a trunk by its root and shoulders: to the left, up, forward; none where they lie in one line.
fn trunk([root, left, right]: [Vector3<f64>; 3]) -> Option<[Vector3<f64>; 3]> {
    let across = (left - right).try_normalize(1e-9)?;
    let spine = (left + right) / 2.0 - root;
    let up = (spine - across * spine.dot(&across)).try_normalize(1e-9)?;
    Some([across, up, across.cross(&up)])
}

/// How they turn where the three points move so, `(3, D)` each.
fn trunk_slope(
    [across, up, _]: &[Vector3<f64>; 3],
    [root, left, right]: [Vector3<f64>; 3],
    [by_root, by_left, by_right]: &[Matrix3xX<f64>; 3],
) -> [Matrix3xX<f64>; 3] {
    let by_across = direction_slope(across, (left - right).norm(), &(by_left - by_right));
    let (spine, by_spine) = ((left + right) / 2.0 - root, (by_left + by_right) / 2.0 - by_root);
    let along = spine.dot(across);
    let by_along = by_spine.tr_mul(across) + by_across.tr_mul(&spine);
    let by_rest = by_spine - &by_across * along - across * by_along.transpose();
    let by_up = direction_slope(up, (spine - across * along).norm(), &by_rest);
    let by_forward = across.cross_matrix() * &by_up - up.cross_matrix() * &by_across;
    [by_across, by_up, by_forward]
}

/// How a direction turns, where a vector of that length moves so.
fn direction_slope(direction: &Vector3<f64>, length: f64, moved: &Matrix3xX<f64>) -> Matrix3xX<f64> {
    (Matrix3::identity() - direction * direction.transpose()) * moved / length
}

/// Directions of upper arm and forearm; none of an arm without length.
fn limbs([shoulder, elbow, wrist]: [Vector3<f64>; 3]) -> Option<[Unit<Vector3<f64>>; 2]> {
    Some([Unit::try_new(elbow - shoulder, 1e-9)?, Unit::try_new(wrist - elbow, 1e-9)?])
}

fn limbs_slope(
    [upper, fore]: &[Unit<Vector3<f64>>; 2],
    [shoulder, elbow, wrist]: [Vector3<f64>; 3],
    [by_shoulder, by_elbow, by_wrist]: &[Matrix3xX<f64>; 3],
) -> [Matrix3xX<f64>; 2] {
    [
        direction_slope(upper, (elbow - shoulder).norm(), &(by_elbow - by_shoulder)),
        direction_slope(fore, (wrist - elbow).norm(), &(by_wrist - by_elbow)),
    ]
}

/// Two directions by the trunk's axes: outwards, up, forward, of the upper arm and of the forearm.
fn seen_from(axes: &[Vector3<f64>; 3], limbs: &[Unit<Vector3<f64>>; 2], side: f64) -> Vector6<f64> {
    Vector6::from_fn(|k, _| limbs[k / 3].dot(&axes[k % 3]) * if k % 3 == 0 { side } else { 1.0 })
}

/// How they change, `(6, D)`.
fn seen_slope(
    (axes, by_axes): (&[Vector3<f64>; 3], &[Matrix3xX<f64>; 3]),
    limbs: &[Unit<Vector3<f64>>; 2],
    by_limbs: &[Matrix3xX<f64>; 2],
    side: f64,
) -> Matrix6xX<f64> {
    let mut slope = Matrix6xX::zeros(by_axes[0].ncols());
    for k in 0..6 {
        let (limb, axis, side) = (k / 3, k % 3, if k % 3 == 0 { side } else { 1.0 });
        let row: DVector<f64> = by_limbs[limb].tr_mul(&axes[axis]) + by_axes[axis].tr_mul(&*limbs[limb]);
        slope.set_row(k, &(row * side).transpose());
    }
    slope
}

/// Minus the log-density of two directions beside that of any two, and its slope.
fn surprise(directions: &Vector6<f64>) -> (f64, Vector6<f64>) {
    let (mut sum, mut slope) = (ANY, Vector6::zeros());
    for Component { log_weight, mean, whitening } in &COMPONENTS {
        let mut square = 0.0;
        let mut pull = Vector6::zeros();
        for (row, weights) in whitening.iter().enumerate() {
            let off: f64 = (0..=row).map(|k| weights[k] * (directions[k] - mean[k])).sum();
            square += off * off;
            (0..=row).for_each(|k| pull[k] += weights[k] * off);
        }
        let density = (log_weight - 0.5 * square).exp();
        sum += density;
        slope += pull * density;
    }
    (-sum.ln(), slope / sum)
}

/// The least surprise that there is: that of the middle of a component.
fn likeliest() -> f64 {
    COMPONENTS.iter().map(|component| surprise(&Vector6::from(component.mean)).0).fold(f64::INFINITY, f64::min)
}
