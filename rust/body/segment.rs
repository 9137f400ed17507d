//! The pieces of a sub-model: joints that the state moves, with all that hangs still on them.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

/// Where a number of a segment comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum Source {
    Fixed(f64),
    /// Column of the state.
    Free(usize),
}

/// An angle of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum Turn {
    /// Sine and cosine of one that stays.
    Fixed(f64, f64),
    /// Column of the state.
    Free(usize),
}

/// A joint that moves, and all that hangs on it up to the next that does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Segment {
    /// The segment that it hangs on; `None` for the root.
    pub parent: Option<usize>,
    /// Its joint's place in the parent's frame, m; for the root, in the world, from the state.
    pub origin: [Source; 3],
    /// The joint's frame within the parent's; `None` where it is the same, as those of an arm's bones are.
    pub frame: Option<Matrix3<f64>>,
    /// Turns, the last applied first: axis and angle.
    pub turns: Vec<(usize, Turn)>,
}
