//! The distance cue: skin-coloured blobs, given to the head and the hands, and how far the model's are from them.

use serde::{Deserialize, Serialize};

/// Who wears skin: the order of everything here.
pub const WEARERS: [&str; 3] = ["head", "left_hand", "right_hand"];

/// Where the blob of each wearer is, px; none where it was not seen.
pub type Blobs = [Option<[f64; 2]>; 3];

/// Gives blobs to wearers by distance to where they were expected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// How far from where it was expected a blob may be, m.
    pub gate_m: f64,
    /// For how many frames in a row each wearer has not been seen.
    unseen: [u32; 3],
}

/// A wearer that was not seen may be farther off, by this share of the gate a frame, up to [`WIDEST`] gates.
const WIDENING: f64 = 0.15;
const WIDEST: f64 = 3.0;

impl Assignment {
    /// All seen so far.
    pub fn new(gate_m: f64) -> Self {
        Self { gate_m, unseen: [0; 3] }
    }

    /// As many wearers as possible get a blob within their gate; among those choices, the one of least total distance.
    pub fn assign(&mut self, candidates: &[[f64; 2]], expected: &[[f64; 2]; 3], px_per_m: f64) -> Blobs {
        let distance = |wearer: usize, blob: usize| {
            let [u, v] = [0, 1].map(|d| candidates[blob][d] - expected[wearer][d]);
            (u * u + v * v).sqrt()
        };
        let gate =
            |wearer: usize| self.gate_m * px_per_m * (1.0 + WIDENING * f64::from(self.unseen[wearer])).min(WIDEST);
        let none = candidates.len();
        let choices = |wearer: usize| {
            let mut near: Vec<usize> = (0..none).filter(|blob| distance(wearer, *blob) <= gate(wearer)).collect();
            // The others can take two of them at most: the best choice is among its three nearest.
            if near.len() > 3 {
                near.sort_by(|a, b| distance(wearer, *a).total_cmp(&distance(wearer, *b)));
                near.truncate(3);
                near.sort_unstable();
            }
            near.into_iter().chain([none]).collect::<Vec<_>>()
        };
        let near = [choices(0), choices(1), choices(2)];
        let mut best = ([none; 3], (4, f64::INFINITY));
        for &head in &near[0] {
            for &left in near[1].iter().filter(|b| **b == none || **b != head) {
                for &right in near[2].iter().filter(|b| **b == none || (**b != head && **b != left)) {
                    let choice = [head, left, right];
                    let missing = choice.iter().filter(|b| **b == none).count();
                    let total = (0..3).filter(|w| choice[*w] != none).map(|w| distance(w, choice[w])).sum::<f64>();
                    if (missing, total) < best.1 {
                        best = (choice, (missing, total));
                    }
                }
            }
        }
        let blobs = best.0.map(|b| candidates.get(b).copied());
        for (unseen, blob) in self.unseen.iter_mut().zip(&blobs) {
            *unseen = if blob.is_some() { 0 } else { *unseen + 1 };
        }
        blobs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_together_not_one_by_one() {
        let mut assignment = Assignment::new(0.5);
        // The left hand is nearest to both hands' blobs; only together is it right.
        let expected = [[50.0, 10.0], [20.0, 50.0], [40.0, 50.0]];
        let blobs = assignment.assign(&[[30.0, 50.0], [5.0, 50.0], [52.0, 12.0]], &expected, 100.0);
        assert_eq!(blobs, [Some([52.0, 12.0]), Some([5.0, 50.0]), Some([30.0, 50.0])]);
    }

    #[test]
    fn many_blobs_are_no_more_work() {
        let blob = |i: u32| [f64::from(i % 71) + 15.0, f64::from(i % 53) + 10.0];
        let many: Vec<[f64; 2]> = (0..3763).map(blob).collect();
        let expected = [[50.0, 10.2], [20.1, 50.0], [40.0, 50.3]];
        let began = std::time::Instant::now();
        let blobs = Assignment::new(5.0).assign(&many, &expected, 100.0);
        assert_eq!(blobs, [Some([50.0, 10.0]), Some([20.0, 50.0]), Some([40.0, 50.0])]);
        // Every choice of three would take an hour.
        assert!(began.elapsed().as_secs() < 60);
    }

    #[test]
    fn what_is_too_far_is_left_out_until_the_gate_has_widened() {
        let mut assignment = Assignment::new(0.1);
        let expected = [[50.0, 10.0], [20.0, 50.0], [80.0, 50.0]];
        let candidates = [[50.0, 11.0], [34.0, 50.0]];
        assert_eq!(assignment.assign(&candidates, &expected, 100.0), [Some([50.0, 11.0]), None, None]);
        for _ in 0..3 {
            assignment.assign(&[], &expected, 100.0);
        }
        assert_eq!(assignment.assign(&candidates, &expected, 100.0)[1], Some([34.0, 50.0]));
    }
}
