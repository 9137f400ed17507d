//! Elbows, wrists and hands against the torso's core (Li & Kulić IV-C1: "limb penetration").

use super::super::joints::Group;
use super::super::weighing::{Cue, Posed};

/// How deep a hand may be in the torso, m; and how much of the torso's half-width is surely torso.
const PENETRATION_SD: f64 = 0.02;
const TORSO_DEPTH: f64 = 0.6;
/// Elbows, wrists and hands among the points of the figure.
const OUTSIDE: [usize; 6] = [4, 5, 6, 7, 10, 12];

/// Half the sum of squares of how deep each is, in standard deviations.
pub struct Penetration;

impl Cue for Penetration {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let Some(torso) = posed.figure.limbs.iter().find(|limb| limb.group == Group::Torso) else { return };
        let radius = TORSO_DEPTH * torso.half_width_m[0].min(torso.half_width_m[1]);
        for (i, out) in out.iter_mut().enumerate() {
            let (a, b) = (posed.at(i, torso.start), posed.at(i, torso.end));
            let axis = [0, 1, 2].map(|d| b[d] - a[d]);
            let length2 = axis.iter().map(|x| x * x).sum::<f64>().max(1e-12);
            for p in OUTSIDE {
                let q = posed.at(i, p);
                let along = ((0..3).map(|d| (q[d] - a[d]) * axis[d]).sum::<f64>() / length2).clamp(0.0, 1.0);
                let apart = (0..3).map(|d| (q[d] - a[d] - along * axis[d]).powi(2)).sum::<f64>().sqrt();
                let deep = ((radius - apart) / PENETRATION_SD).max(0.0);
                *out += 0.5 * deep * deep;
            }
        }
    }
}
