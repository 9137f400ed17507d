//! The mathematics of pytracker: particle filters that track human motion.
//!
//! This crate knows no file, no pixel decoding and (without the `python` feature) no Python.
//!
//! # Conventions
//!
//! Written once, here; pinned by the tests named beside each.
//!
//! * SI units: metres, seconds, radians, m/s²; pixels for image points, `(u right, v down)`, pixel centres
//!   at integers (`camera::tests::principal_point_is_a_pixel_centre`).
//! * Quaternions are Hamilton, scalar first, and named for what they do: `q_world_sensor` takes vectors of
//!   the sensor frame to the world (`quaternion::tests::quarter_turn_about_z_takes_x_to_y`).
//! * World: right-handed; z up for the arm, the Acclaim file's own frame, y up, for the body. An accelerometer at rest, z up, reads +9.81
//!   (`arm::timeline::tests::rest_reads_plus_g`).
//! * Camera: x right, y down, z forward; `R|t` maps world to camera
//!   (`camera::tests::right_is_plus_u_and_down_is_plus_v`).
//! * A particle set has `N` particles of `D` columns; outside it is `(N, D)`: a row is a particle.
//! * Weights are kept as logarithms, normalised; all weights zero is an [`Error`], never a NaN.
//!
//! # Map
//!
//! | module | owns |
//! |---|---|
//! | [`rng`] | which random stream a draw comes from: same seed, same bits, for any number of threads |
//! | [`particles`] | states and weights in one struct: normalise, ESS, moments, quantiles, mode, resample |
//! | [`resample`] | multinomial, stratified, systematic, residual |
//! | [`filter`] | the engine: layers of (transition, likelihoods), islands, the recorder; the Kalman baseline, mixture, smoother |
//! | [`quaternion`], [`camera`], [`projection`] | geometry |
//! | [`skeleton`] | Acclaim bones and channels, forward kinematics |
//! | [`arm`] | wrist IMU and colour patch (Tao & Hu 2008): models, cues, methods |
//! | [`body`] | upper body from one camera (Li & Kulić 2010): figure, cues, methods |
//! | [`parameters`] | numbers of a method by name |
//! | [`observation`], [`tracker`], [`estimate`] | what goes into the one online tracker of both, and what comes out |
//! | [`smoothing`] | the same of a whole recording, window by window; `averaged` with what the filter said of it |

pub mod arm;
mod averaged;
pub mod body;
pub mod camera;
mod error;
pub mod estimate;
pub mod filter;
pub mod observation;
pub mod parameters;
pub mod particles;
pub mod projection;
pub mod quaternion;
pub mod resample;
pub mod rng;
mod saved;
pub mod skeleton;
pub mod smoothing;
mod sums;
pub mod tracker;

#[cfg(feature = "python")]
mod python;

pub use error::Error;
pub use estimate::{Estimate, Point};
pub use observation::{Observation, Sample, What};
pub use smoothing::Smoothing;
pub use tracker::Tracker;

/// What every fallible call of this crate returns.
pub type Result<T> = std::result::Result<T, Error>;
