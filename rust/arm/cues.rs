//! What a frame says of an arm, and what an arm can do: one file a cue.
//!
//! | file | weighs or corrects by |
//! |---|---|
//! | [`colour`] | the patch: eqs (7), (9), (11) |
//! | [`length`] | the upper arm's length: eqs (15), (16) |
//! | [`rest`] | not in the paper: no velocity, while the IMU says that it lies still |
//! | [`landmark`] | not in the paper: shoulder and elbow as a camera sees them |
//! | [`upper_arm`] | not in the paper: where a sensor on the upper arm points |
//!
//! A cue of a Gaussian filter is linear about a state ([`Cue`]). One that weighs particles is a
//! [`crate::filter::Likelihood`] besides: colour, length and rest are.

pub mod colour;
pub mod landmark;
pub mod length;
pub mod rest;
pub mod upper_arm;

use super::posed::Posed;
use crate::filter::{Gaussian, Linear};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// What is seen farther off than this (squared, in standard deviations) is trusted less, as a Student's t would.
const ROBUST: f64 = 9.0;

/// A cue by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CueName {
    /// [`colour`], with [`landmark`]s where a state has columns for them.
    Colour,
    /// [`length`]; or [`upper_arm`], which says the length too, where a sensor says it.
    ArmLength,
    /// [`rest`].
    Rest,
}

impl CueName {
    /// `colour`, `arm_length` or `rest`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "colour" => Ok(Self::Colour),
            "arm_length" => Ok(Self::ArmLength),
            "rest" => Ok(Self::Rest),
            _ => Err(Error::UnknownName { what: "cue", name: name.into(), known: "colour, arm_length, rest" }),
        }
    }
}

/// What is measured of a state.
pub trait Cue: Sync {
    /// Residual, slope by all columns and noise about a state; nothing where it has nothing to say. `covariance`: of the
    /// state, where it is no single place.
    ///
    /// # Errors
    /// [`Error::RanAway`]: what was seen is behind its camera.
    fn linearise(
        &self,
        posed: &Posed<'_>,
        state: &DVector<f64>,
        covariance: Option<&DMatrix<f64>>,
    ) -> Result<Option<Linear>>;

    /// Whether it was observed: then it is evidence, and may be wrong. A length that is known beforehand is neither.
    fn is_seen(&self) -> bool {
        true
    }

    /// How often it is worth linearising it.
    fn times(&self) -> usize {
        1
    }

    /// The direction in which a Gaussian is so wide that it bends over it.
    fn bent(&self, _posed: &Posed<'_>, _gaussian: &Gaussian) -> Option<DVector<f64>> {
        None
    }
}

/// A cue about a state; what was seen far off has more noise, as a Student's t would have it.
///
/// # Errors
/// As [`Cue::linearise`].
pub fn robust(
    cue: &dyn Cue,
    posed: &Posed<'_>,
    state: &DVector<f64>,
    covariance: Option<&DMatrix<f64>>,
) -> Result<Option<Linear>> {
    let found = cue.linearise(posed, state, covariance)?;
    Ok(found.map(|(residual, slope, noise)| {
        let spread = |d: usize| covariance.map_or(0.0, |of| (slope.row(d) * of).dot(&slope.row(d)));
        let far = || (0..residual.len()).map(|d| residual[d] * residual[d] / (noise[(d, d)] + spread(d))).sum::<f64>();
        let wider = if cue.is_seen() { (far() / ROBUST).max(1.0) } else { 1.0 };
        (residual, slope, noise * wider)
    }))
}

/// What is known beforehand, so much of it told once and for all (0 to 1): in units of its standard deviation to that power.
///
/// A length is not measured anew in every frame. How widely it is known at a place (a forearm that lies beside the sensor's axis matters
/// where the elbow is bent, not where the arm is straight or folded) would else speak against that place, frame after frame: slow arms
/// were put at the other depth, where they were folded. What was seen stays as it is.
pub fn told_once(cue: &dyn Cue, linear: Linear, share: f64) -> Linear {
    if cue.is_seen() {
        return linear;
    }
    let (mut residual, mut slope, mut noise) = linear;
    for d in 0..residual.len() {
        let unit = noise[(d, d)].powf(0.5 * share);
        residual[d] /= unit;
        slope.row_mut(d).unscale_mut(unit);
        noise.row_mut(d).unscale_mut(unit);
        noise.column_mut(d).unscale_mut(unit);
    }
    (residual, slope, noise)
}

#[cfg(test)]
mod tests {
    use super::landmark::{Landmark, SeenJoint};
    use super::length::UpperArmLength;
    use super::rest::Rest;
    use super::upper_arm::Direction;
    use super::*;
    use crate::arm::posed::{Moment, Sighting};
    use crate::arm::process::GaussMarkov;
    use crate::arm::setup::Setup;
    use crate::arm::state::{Arm, Layout, Noise, POSITION, View};
    use crate::camera::Camera;
    use crate::quaternion::Quaternion;
    use nalgebra::{Matrix3, Vector2, Vector3};
    use proptest::prelude::*;

    const STEP: f64 = 1e-6;

    fn noise() -> Noise {
        let some = |start_sd| Some(GaussMarkov { start_sd, density: 0.01 });
        let (bias, tilt, patch_offset) = (some(0.1), some(0.02), some(0.01));
        let setup = Setup {
            upper_arm_sd_m: 0.01,
            forearm_sd_m: 0.02,
            shoulder_place_sd_m: 0.02,
            mount_sd_rad: 0.05,
            camera_turn_sd_rad: 0.01,
            camera_distance_sd_m: 0.05,
            focal_sd: 0.02,
            cameras: 2,
        };
        let (shoulder, clock, setup) = (some(0.02), some(0.05), Some(setup));
        let (landmarks, upper_arm) = ([some(0.03), some(0.03)], some(0.05));
        Noise {
            bias,
            patch_offset,
            tilt,
            shoulder,
            landmarks,
            upper_arm,
            clock,
            setup,
            forearm_sd_rad: 0.08,
            ..Noise::default()
        }
    }

    fn arm() -> Arm {
        let shoulder = Vector3::new(0.1, -0.05, 0.2);
        Arm { shoulder, upper_arm_m: 0.3, forearm_m: 0.25, wrist_start: Vector3::new(0.2, 0.1, -0.1) }
    }

    fn view() -> View {
        let matrix = Matrix3::new(700.0, 0.0, 320.0, 0.0, 650.0, 240.0, 0.0, 0.0, 1.0);
        let camera = Camera::new(matrix, [0.0; 5], Matrix3::identity(), Vector3::new(0.0, 0.0, 2.0)).unwrap();
        View { camera, patch_offset: Vector3::new(0.02, -0.01, 0.03) }
    }

    /// A wrist some 0.3 m from the shoulder, and small errors of all else.
    fn state(units: &[f64]) -> DVector<f64> {
        let sd = |d: usize| if d < 6 { 0.15 } else { 0.03 };
        let about = |d: usize| if d < 6 { 0.15 } else { 0.0 };
        DVector::from_iterator(units.len(), units.iter().enumerate().map(|(d, unit)| about(d) + sd(d) * unit))
    }

    fn some() -> DVector<f64> {
        let units: Vec<f64> = (0..Layout::new(&noise()).dim).map(|d| (1.7 * d as f64 + 0.4).sin()).collect();
        state(&units)
    }

    fn with_posed(moment: Moment, check: impl FnOnce(&Posed<'_>, &Sighting<'_>)) {
        let (arm, noise, view) = (arm(), noise(), view());
        let posed = Posed::new(Layout::new(&noise), &arm, &noise, moment);
        check(&posed, &Sighting { view: &view, camera: 1, pixel: Vector2::new(300.0, 250.0) });
    }

    fn moment() -> Moment {
        let world_sensor = Quaternion::from_wxyz([0.5, 0.1, -0.7, 0.5]);
        Moment { time_s: 1.0, world_sensor, acceleration: Vector3::new(1.0, -2.0, 3.0), stale_s: 0.0 }
    }

    fn linear(cue: &dyn Cue, posed: &Posed<'_>, at: &DVector<f64>) -> Linear {
        cue.linearise(posed, at, None).unwrap().unwrap()
    }

    /// What falls in the residual as a column grows is the slope.
    fn is_slope_of(residual: impl Fn(&DVector<f64>) -> DVector<f64>, slope: &DMatrix<f64>, at: &DVector<f64>) {
        for d in 0..at.len() {
            let (mut more, mut less) = (at.clone(), at.clone());
            more[d] += STEP;
            less[d] -= STEP;
            let falls = (residual(&less) - residual(&more)) / (2.0 * STEP);
            assert!((falls - slope.column(d)).amax() < 1e-5 * (1.0 + slope.amax()), "column {d}");
        }
    }

    fn units(count: usize) -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1.0..1.0f64, count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn slopes_are_derivatives(
            of_state in units(Layout::new(&noise()).dim),
            turn in units(3),
            pushed in units(3),
            to_shoulder in units(3),
        ) {
            let at = state(&of_state);
            let world_sensor = Quaternion::from_rotation_vector(3.0 * Vector3::from_column_slice(&turn));
            let acceleration = 5.0 * Vector3::from_column_slice(&pushed);
            let moment = Moment { world_sensor, acceleration, ..moment() };
            let to_shoulder: Vector3<f64> = Vector3::from_column_slice(&to_shoulder) + 0.01 * Vector3::x();
            let to_shoulder = to_shoulder.normalize();
            with_posed(moment, |posed, sighting| {
                // About a point on the shoulder nothing is linear.
                if posed.upper_arm(&at).0.norm() < 0.05 {
                    return;
                }
                let views = [view(), view()];
                let joint = |joint| Landmark { joint, camera: 1, pixel: sighting.pixel, sd: 3.0 };
                let [shoulder, elbow] = [SeenJoint::Shoulder, SeenJoint::Elbow].map(|one| joint(one).seen_by(&views));
                let direction = Direction { time_s: 1.0, to_shoulder, sd: 0.05 };
                let rest = Rest::new(0.1, posed.noise);
                let cues: [&dyn Cue; 6] = [sighting, &UpperArmLength, &rest, &shoulder, &elbow, &direction];
                for cue in cues {
                    is_slope_of(|x| linear(cue, posed, x).0, &linear(cue, posed, &at).1, &at);
                }
                let place = |(place, _): (Vector3<f64>, DMatrix<f64>)| DVector::from_column_slice((-place).as_slice());
                is_slope_of(|x| place(posed.elbow_seen(x)), &posed.elbow_seen(&at).1, &at);
            });
        }
    }

    /// A place known to within a ball is farther off, and by a length less known, than its middle: by quadrature.
    #[test]
    fn the_length_is_of_second_order() {
        with_posed(moment(), |posed, _| {
            let (at, sd) = (some(), 0.03);
            let mut covariance = DMatrix::zeros(posed.layout.dim, posed.layout.dim);
            covariance.fixed_view_mut::<3, 3>(POSITION, POSITION).fill_diagonal(sd * sd);
            let known = linear(&UpperArmLength, posed, &at);
            let unknown = UpperArmLength.linearise(posed, &at, Some(&covariance)).unwrap().unwrap();
            // Sigma points at the square root of 3: exact for a Gaussian up to the fifth order.
            let residual = |x: &DVector<f64>| posed.arm.upper_arm_m - posed.upper_arm(x).0.norm();
            let moved = |d: usize, by: f64| {
                let mut x = at.clone();
                x[POSITION + d] += by * 3f64.sqrt() * sd;
                residual(&x)
            };
            let mean: f64 = (0..3).map(|d| (moved(d, 1.0) + moved(d, -1.0) - 2.0 * residual(&at)) / 6.0).sum();
            assert!(mean < -0.001 && (unknown.0[0] - known.0[0] - mean).abs() < 0.05 * mean.abs(), "{mean}");
            assert!(unknown.2[(0, 0)] > known.2[(0, 0)]);
        });
    }

    /// The residual in standard deviations stays; what is told once has no width of its own, what was seen is as it was.
    #[test]
    fn a_constraint_is_told_once() {
        with_posed(moment(), |posed, sighting| {
            let (at, of) = (some(), |cue: &dyn Cue| linear(cue, posed, &some()));
            let (residual, slope, noise) = of(&UpperArmLength);
            for share in [0.0, 0.7, 1.0] {
                let (told, by_state, left) = told_once(&UpperArmLength, of(&UpperArmLength), share);
                let in_sd = |residual: f64, noise: &DMatrix<f64>| residual / noise[(0, 0)].sqrt();
                assert!((in_sd(told[0], &left) - in_sd(residual[0], &noise)).abs() < 1e-12);
                assert!((by_state * residual[0] - &slope * told[0]).amax() < 1e-12);
                assert!((left[(0, 0)] - noise[(0, 0)].powf(1.0 - share)).abs() < 1e-12);
            }
            assert_eq!(told_once(sighting, of(sighting), 1.0), linear(sighting, posed, &at));
        });
    }

    #[test]
    fn a_sighting_far_off_is_trusted_less() {
        with_posed(moment(), |posed, sighting| {
            let at = some();
            let noise = |pixel| robust(&Sighting { pixel, ..*sighting }, posed, &at, None).unwrap().unwrap().2[(0, 0)];
            let (residual, _, _) = linear(sighting, posed, &at);
            let expected = sighting.pixel - Vector2::new(residual[0], residual[1]);
            let variance = posed.noise.pixel_sd * posed.noise.pixel_sd;
            assert!((noise(expected) - variance).abs() < 1e-12);
            assert!(noise(expected + Vector2::new(100.0 * posed.noise.pixel_sd, 0.0)) > 100.0 * variance);
        });
    }
}
