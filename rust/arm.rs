//! Arm tracking: a wrist IMU, a colour patch seen by a camera, and the length of the upper arm.
//!
//! Tao & Hu, "A Novel Sensing and Data Fusion System for 3-D Arm Motion Tracking in Telerehabilitation",
//! IEEE Trans. Instrum. Meas. 57(5), 2008. Equation numbers here are theirs. The state is the wrist's position
//! and velocity (eq. 3); the elbow follows from the sensor's orientation (eqs 1, 2).
//!
//! | file | paper |
//! |---|---|
//! | [`state`] | eq. (3), with optional columns for bias and patch offset |
//! | [`motion`] | eqs (4)-(6), (8), (10): the motion of all IMU samples since the last frame, composed |
//! | [`timeline`] | which sample holds when; the orientation at a frame |
//! | [`process`] | not in the paper: what wanders slowly |
//! | [`posed`] | eqs (1), (2): where a state puts the arm, with slopes |
//! | [`cues`] | eqs (7), (9), (11), (15), (16): what a frame says of it, one file a cue |
//! | [`stillness`] | not in the paper: rest, told from the IMU |
//! | [`pause`] | not in the paper: where the arm may be after nothing was heard and seen |
//! | [`incoming`] | not in the paper: a stream without its patch, or whose IMU contradicts itself |
//! | [`alike`] | not in the paper: whether patch and sensor move alike |
//! | [`plausible`] | not in the paper: estimates that no arm can have, or that the picture contradicts |
//! | [`particle`] | eqs (12)-(14), (17), (18), III-E: lists of layers |
//! | [`ekf`] | the baselines: inertial only, EKF, EKF with the constraint |
//! | [`worn`] | not in the paper: the motion of a worn sensor, whose orientation is not quite right |
//! | [`mixture`] | not in the paper: a mixture of Gaussians over that state |
//! | [`setup`] | not in the paper: lengths and cameras as constants that are not quite known |
//! | [`memory`] | what is kept of a recording to smooth it |
//! | [`smooth`] | not in the paper: the same over a whole recording |
//! | [`frame`] | a camera frame, with what the IMU has said up to it |
//! | [`method`] | which filter, and what corrects it |
//! | [`filter`] | one of them, sample by sample and frame by frame |

pub mod alike;
pub mod cues;
pub mod ekf;
pub mod filter;
pub mod frame;
pub mod incoming;
pub mod memory;
pub mod method;
pub mod mixture;
pub mod motion;
pub mod particle;
pub mod pause;
pub mod plausible;
pub mod posed;
pub mod process;
pub mod setup;
pub mod smooth;
pub mod state;
pub mod stillness;
pub mod timeline;
pub mod worn;

pub use filter::ArmFilter;
pub use method::Method;
pub use state::{Arm, Noise, PLACES};
