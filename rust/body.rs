//! Body tracking: the upper body of a skeleton, seen by one camera.
//!
//! Li & Kulić, "Particle filter based human motion tracking", ICARCV 2010. Equation numbers here are theirs. The state
//! is any subset of the skeleton's channels; 11 of them are the paper's upper body.
//!
//! | file | paper |
//! |---|---|
//! | [`model`] | IV-A1: the sub-model, many particles at once |
//! | `segment`, `forward`, `lanes` | its kinematics in vector instructions |
//! | [`joints`] | names: groups, key joints, keypoints |
//! | [`figure`] | IV-A2: the outer shape, the key joints, the limits of joints |
//! | [`facing`] | the root in the picture's plane, of a camera that looks along any axis |
//! | [`motion`] | IV-C1: zero-order dynamics |
//! | [`edges`] | eq. (4): the edge cue |
//! | [`skin`] | the distance cue: blobs given to head and hands |
//! | [`cues`] | IV-C2: weights: one file a cue, their names, and what a frame shows them |
//! | [`weighing`] | posed particles, and what the cues of a layer say of them |
//! | [`balance`] | a trunk that gives way to its arms |
//! | [`unseen`] | depth that neither model nor camera knows, added to the bands |
//! | [`method`] | IV-C: lists of layers and their parameters |
//! | [`filter`] | IV-C: evidence in, a pose out |
//! | `particles`, `mixture`, `moment` | by particles, by Gaussians, and what either is given of a frame |
//! | [`sloped`] | a pose and its slopes, for cues that are smooth |
//! | [`momentum`] | channels with velocities |
//! | `gaussians` | Gaussians over these as an estimate |
//! | `trajectory`, `mirrored`, `smooth` | a whole recording at once |

pub mod balance;
pub mod cues;
pub mod edges;
pub mod facing;
pub mod figure;
pub mod filter;
mod forward;
mod gaussians;
mod jacobian;
pub mod joints;
mod lanes;
pub mod method;
mod mirrored;
mod mixture;
pub mod model;
mod moment;
pub mod momentum;
pub mod motion;
mod particles;
mod segment;
pub mod skin;
pub mod sloped;
mod smaller;
mod smooth;
mod trajectory;
pub mod unseen;
pub mod weighing;

pub use crate::filter::Blend;
pub use cues::region::Region;
pub use cues::{CueName, Picture};
pub use figure::{Figure, Part};
pub use filter::BodyFilter;
pub use joints::{Group, KEY_JOINTS, KEYPOINTS};
pub use method::{BodyLayer, BodyMethod, Diffusion, FilterMethod, MixtureMethod, Mover, ParticleMethod};
pub use momentum::Momentum;
pub use smaller::Smaller;
pub use unseen::Unseen;
