//! Upper arms against gravity: of two ways to look alike, the one that holds the arm lower is the likelier.
//!
//! Not in the paper. One camera hardly tells whether a limb leans towards it or away, and joints that bend one way only make
//! the mean lean forwards. People let their upper arms hang where nothing asks for more: the loss is in proportion to how
//! high an elbow is held above where it would hang, as is the work that was done to lift it.

use super::super::joints::Group;
use super::super::sloped::{Rows, Sloped};
use super::super::weighing::{Cue, Posed};
use crate::Result;
use crate::parameters::{Parameters, require_not_negative};
use serde::{Deserialize, Serialize};

/// Shoulder and elbow of either arm among the points of the figure.
const ARMS: [(Group, usize, usize); 2] = [(Group::LeftArm, 2, 4), (Group::RightArm, 3, 5)];

/// An arm is held so much of its length higher than it is: where it hangs the slope of a square root would have no end.
const HANGING: f64 = 1e-4;

/// How much it counts how arms are held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EffortParameters {
    /// Log-likelihood lost by an upper arm that is held out level.
    pub loss: f64,
}

impl EffortParameters {
    /// Of a method's `effort_loss`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self { loss: from.get("effort_loss")? })
    }

    /// Check its range.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_not_negative("effort_loss", self.loss, "0 or more")
    }
}

/// What the arms of some groups lose.
pub struct Effort<'a> {
    /// Groups whose arms count.
    pub groups: &'a [Group],
    /// How much they count.
    pub parameters: EffortParameters,
}

impl Cue for Effort<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        out.fill(0.0);
        for (_, shoulder, elbow) in ARMS.into_iter().filter(|(group, ..)| self.groups.contains(group)) {
            for (i, out) in out.iter_mut().enumerate() {
                let (near, far) = (posed.at(i, shoulder), posed.at(i, elbow));
                let reach = [0, 1, 2].map(|d| far[d] - near[d]);
                let length = reach.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
                // y is up: nothing where it hangs, all where it is level, twice as much overhead.
                *out += self.parameters.loss * (1.0 + reach[1] / length);
            }
        }
    }

    /// As the square of a number that is zero where the arm hangs.
    fn linearise(&self, at: &Sloped<'_>, rows: &mut Rows) {
        let loss = self.parameters.loss;
        if loss == 0.0 {
            return;
        }
        for (_, shoulder, elbow) in ARMS.into_iter().filter(|(group, ..)| self.groups.contains(group)) {
            let reach = at.at(elbow) - at.at(shoulder);
            let length = reach.norm().max(1e-9);
            let held = (2.0 * loss * (1.0 + reach.y / length + HANGING)).sqrt();
            let rise = (at.slope(elbow).row(1) - at.slope(shoulder).row(1)).transpose() / length;
            rows.push(-held, rise * (loss / held), 1.0);
        }
    }
}
