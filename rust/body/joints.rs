//! Names: groups of channels, the joints that are reported, the joints that a detector may see.

use serde::{Deserialize, Serialize};

/// Which of the body a column or a part belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Group {
    /// Everything but the arms.
    Torso,
    /// What hangs on the left clavicle.
    LeftArm,
    /// What hangs on the right clavicle.
    RightArm,
}

/// The joints whose error Li & Kulić report, in the order of every estimate: (name, bone, along it).
pub const KEY_JOINTS: [(&str, &str, f64); 8] = [
    ("root", "root", 0.0),
    ("head", "head", 1.0),
    ("left_shoulder", "lhumerus", 0.0),
    ("right_shoulder", "rhumerus", 0.0),
    ("left_elbow", "lhumerus", 1.0),
    ("right_elbow", "rhumerus", 1.0),
    ("left_wrist", "lwrist", 1.0),
    ("right_wrist", "rwrist", 1.0),
];

/// The joints that a detector may see: name, group, and how far a detector's is from the skeleton's, m (measured on clips of
/// people: shoulders, elbows and wrists 1 to 2 cm; hips and head are called so by convention only).
pub const KEYPOINTS: [(&str, Group, f64); 9] = [
    ("head", Group::Torso, 0.05),
    ("left_shoulder", Group::Torso, 0.02),
    ("right_shoulder", Group::Torso, 0.02),
    ("left_elbow", Group::LeftArm, 0.02),
    ("right_elbow", Group::RightArm, 0.02),
    ("left_wrist", Group::LeftArm, 0.02),
    ("right_wrist", Group::RightArm, 0.02),
    ("left_hip", Group::Torso, 0.05),
    ("right_hip", Group::Torso, 0.05),
];
