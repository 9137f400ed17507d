//! A smoothed frame of an arm, averaged with what the mixture said of it ([`crate::averaged`]).

use crate::arm::memory::Kept;
use crate::arm::state::{POSITION, WRIST};
use crate::averaged::{Averaged, FILTERED};
use crate::estimate::{Estimate, Point};
use crate::particles::Summary;
use nalgebra::Matrix3;

/// A mixture whose band is wider than so many times that of what is smoothed has less than its share.
const AS_SURE: f64 = 2.0;

/// What is smoothed, and that with what the mixture says of the same places; the former alone where that must not be believed.
pub(super) fn averaged(smoothed: Estimate, kept: &Kept) -> Averaged {
    let both = kept.filtered.as_ref().map(|filtered| together(&smoothed, filtered));
    [smoothed.clone(), both.unwrap_or(smoothed)]
}

/// Both; of the state it is the position that the mixture has a say in.
fn together(smoothed: &Estimate, filtered: &[Point]) -> Estimate {
    let [alone, other] = [&smoothed.places[WRIST], &filtered[WRIST]];
    let share = FILTERED * (AS_SURE * alone.sd.norm() / other.sd.norm()).powi(2).min(1.0);
    let place = |(alone, other): (&Point, &Point)| {
        let both = Point::together(&[(1.0 - share, alone), (share, other)]);
        Point { mode: alone.mode, ..both }
    };
    let mut state = smoothed.state.clone();
    let off = other.mean - alone.mean;
    let spread = Matrix3::from_diagonal(&other.sd.component_mul(&other.sd)) + off * off.transpose() * (1.0 - share);
    let rest = state.covariance.nrows() - 3;
    state.covariance.view_mut((POSITION, 3), (3, rest)).scale_mut(1.0 - share);
    state.covariance.view_mut((3, POSITION), (rest, 3)).scale_mut(1.0 - share);
    let mut position = state.covariance.fixed_view_mut::<3, 3>(POSITION, POSITION);
    position.copy_from(&(&position * (1.0 - share) + spread * share));
    Estimate { state, places: smoothed.places.iter().zip(filtered).map(place).collect(), ..smoothed.clone() }
}

/// Its state put where it has the wrist.
pub(super) fn at_its_wrist(estimate: Estimate) -> Estimate {
    let wrist = &estimate.places[WRIST];
    let Summary { mut mean, covariance, .. } = estimate.state;
    mean.fixed_rows_mut::<3>(POSITION).copy_from(&wrist.mean);
    Estimate { state: wrist.with_state(mean, covariance), ..estimate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector, Vector3};

    fn point(mean: Vector3<f64>, sd: Vector3<f64>) -> Point {
        Point { mean, mode: mean, sd, lo: mean - 1.96 * sd, hi: mean + 1.96 * sd }
    }

    /// Position and two columns more that go with it.
    fn smoothed(sd: Vector3<f64>) -> Estimate {
        let root = DMatrix::from_fn(5, 5, |i, j| if i == j { 1.0 } else { 0.1 * (i + 2 * j) as f64 });
        let mut covariance = &root * root.transpose();
        let scale = DVector::from_fn(5, |d, _| if d < 3 { sd[d] / covariance[(d, d)].sqrt() } else { 1.0 });
        covariance = DMatrix::from_diagonal(&scale) * covariance * DMatrix::from_diagonal(&scale);
        let wrist = point(Vector3::new(0.1, 0.2, 0.3), sd);
        Estimate {
            time_s: 1.0,
            state: wrist.with_state(DVector::from_vec(vec![0.1, 0.2, 0.3, 4.0, 5.0]), covariance),
            places: vec![wrist.clone(), wrist],
            ess: None,
            log_evidence: None,
            doubt: None,
            blobs: [None; 3],
        }
    }

    const SD: Vector3<f64> = Vector3::new(0.01, 0.05, 0.03);
    const OFF: Vector3<f64> = Vector3::new(0.01, -0.1, 0.02);

    fn with(times: f64) -> (Estimate, Estimate) {
        let alone = smoothed(SD);
        let other = point(alone.places[WRIST].mean + OFF, SD * times);
        let both = together(&alone, &[other.clone(), other]);
        (alone, both)
    }

    /// As a mixture of both: mean, spread with what they are apart, nothing of the other columns, and still a covariance.
    #[test]
    fn the_wrist_and_its_column_agree() {
        let (alone, both) = with(1.0);
        let found = at_its_wrist(both);
        let wrist = &found.places[WRIST];
        assert!((wrist.mean - alone.places[WRIST].mean - OFF * FILTERED).norm() < 1e-12);
        for d in 0..3 {
            let variance = SD[d].powi(2) + FILTERED * (1.0 - FILTERED) * OFF[d].powi(2);
            assert!((wrist.sd[d].powi(2) - variance).abs() < 1e-12);
            assert!((found.state.covariance[(d, d)] - variance).abs() < 1e-12);
            assert_eq!(found.state.mean[d], wrist.mean[d]);
            assert_eq!((found.state.bands[d].lo, found.state.bands[d].hi), (wrist.lo[d], wrist.hi[d]));
        }
        assert_eq!(found.state.mean.rows(3, 2), alone.state.mean.rows(3, 2));
        assert_eq!(found.state.covariance.view((3, 3), (2, 2)), alone.state.covariance.view((3, 3), (2, 2)));
        assert!(found.state.covariance.symmetric_eigenvalues().min() > 0.0);
    }

    #[test]
    fn who_is_less_sure_has_less_of_a_say() {
        let moved = |times| {
            let (alone, both) = with(times);
            (both.places[WRIST].mean - alone.places[WRIST].mean).norm() / OFF.norm()
        };
        assert!((moved(0.1) - FILTERED).abs() < 1e-9 && (moved(2.0) - FILTERED).abs() < 1e-9);
        assert!((moved(8.0) - FILTERED / 16.0).abs() < 1e-9);
    }
}
