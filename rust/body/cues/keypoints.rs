//! Joints against a detector's points in the picture.
//!
//! Not in the paper. A detector's point is a few pixels off, or somewhere else altogether; and what it calls a shoulder is not
//! quite the skeleton's. Both are in the spread, and a wild point ends up saying nothing.

use super::super::figure::Figure;
use super::super::joints::{Group, KEYPOINTS};
use super::super::sloped::{Rows, Sloped};
use super::super::weighing::{Cue, Posed};
use crate::error::{MOST_PX, require, require_pixel};
use crate::parameters::{Parameters, require_positive};
use crate::projection::Projected;
use crate::{Error, Result};
use nalgebra::{Matrix2xX, Vector2};
use serde::{Deserialize, Serialize};

/// A point of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Keypoint {
    /// px.
    pub pixel: [f64; 2],
    /// Standard deviation along each axis, px.
    pub sd_px: f64,
}

/// One person's points, in the order of [`KEYPOINTS`]; none where it was not seen.
pub type Person = [Option<Keypoint>; KEYPOINTS.len()];

/// How much keypoints count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KeypointParameters {
    /// How many times the spread of a single frame: errors of neighbouring frames are much alike.
    pub inflation: f64,
    /// Beyond about so many standard deviations a point says nothing more.
    pub reach: f64,
}

/// People of a table `(P, 9, 3)` of u, v and standard deviation, px; a point with a NaN was not seen.
///
/// # Errors
/// [`Error::Size`] for another number of points or values.
pub fn people([count, points, values]: [usize; 3], table: &[f64]) -> Result<Vec<Person>> {
    for (name, got, expected) in [("keypoints", points, KEYPOINTS.len()), ("values of a keypoint", values, 3)] {
        if got != expected {
            return Err(Error::Size { name, got, unit: "entries", expected });
        }
    }
    let point = |person: usize, k: usize| {
        let [u, v, sd_px] = [0, 1, 2].map(|d| table[(person * points + k) * values + d]);
        let is_seen = !(u.is_nan() || v.is_nan() || sd_px.is_nan());
        is_seen.then_some(Keypoint { pixel: [u, v], sd_px })
    };
    Ok((0..count).map(|person| std::array::from_fn(|k| point(person, k))).collect())
}

/// Check every number of some people's points.
///
/// # Errors
/// [`Error::NotFinite`], [`Error::Parameter`].
pub fn check(people: &[Person], time_s: f64) -> Result<()> {
    for keypoint in people.iter().flatten().flatten() {
        require_pixel("keypoint", time_s, keypoint.pixel)?;
        let sd_px = keypoint.sd_px;
        require((0.0..=MOST_PX).contains(&sd_px), "spread of a keypoint", sd_px, "0 px or more")?;
    }
    Ok(())
}

/// Squared distances in standard deviations, each levelling off.
pub struct KeypointDistance<'a> {
    /// Who is followed.
    pub person: &'a Person,
    /// Groups whose points count.
    pub groups: &'a [Group],
    /// How much they count.
    pub parameters: KeypointParameters,
}

/// What a point that is seen at `seen` loses.
fn loss(seen: Projected, keypoint: Keypoint, mismatch_m: f64, parameters: KeypointParameters) -> f64 {
    let most = (-0.5 * parameters.reach * parameters.reach).exp();
    let [du, dv] = [seen.u - keypoint.pixel[0], seen.v - keypoint.pixel[1]];
    let spread = parameters.spread(keypoint, mismatch_m, seen.px_per_m);
    let squared = (du * du + dv * dv) / (spread * spread);
    // Behind the camera it is nowhere.
    let explained = if squared.is_finite() { (-0.5 * squared).exp() } else { 0.0 };
    (1.0 + most).ln() - (explained + most).ln()
}

/// How far a point is from where one state has it.
pub struct Off {
    /// Of the figure.
    pub point: usize,
    /// px.
    pub residual: Vector2<f64>,
    /// Standard deviation along each axis, px.
    pub spread: f64,
    /// How what the state has moves with it, `(2, D)`.
    pub slope: Matrix2xX<f64>,
}

impl KeypointParameters {
    /// Of a method's `keypoint_inflation` and `keypoint_reach`.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        Ok(Self { inflation: from.get("keypoint_inflation")?, reach: from.get("keypoint_reach")? })
    }

    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_positive("keypoint_inflation", self.inflation, "a positive number")?;
        require_positive("keypoint_reach", self.reach, "a positive number")
    }

    fn spread(self, keypoint: Keypoint, mismatch_m: f64, px_per_m: f64) -> f64 {
        self.inflation * keypoint.sd_px.hypot(mismatch_m * px_per_m)
    }
}

impl KeypointDistance<'_> {
    /// Of every point that the state has before the camera.
    pub fn off(&self, at: &Sloped<'_>) -> Vec<Off> {
        // One scale for all: a spread that shrank with the distance would draw every joint away from the camera.
        let px_per_m = at.projection.see(at.at(0).into()).px_per_m;
        if !px_per_m.is_finite() {
            return Vec::new();
        }
        let off = |(point, keypoint, mismatch_m): (usize, Keypoint, f64)| {
            let (seen, slope) = at.seen(point)?;
            let residual = Vector2::new(keypoint.pixel[0] - seen.u, keypoint.pixel[1] - seen.v);
            Some(Off { point, residual, spread: self.parameters.spread(keypoint, mismatch_m, px_per_m), slope })
        };
        self.points(at.figure).filter_map(off).collect()
    }

    fn points<'a>(&'a self, figure: &'a Figure) -> impl Iterator<Item = (usize, Keypoint, f64)> + 'a {
        let named = KEYPOINTS.iter().zip(self.person).zip(&figure.keypoints);
        named
            .filter(|(((_, group, _), _), _)| self.groups.contains(group))
            .filter_map(|(((_, _, mismatch_m), keypoint), point)| Some(((*point)?, (*keypoint)?, *mismatch_m)))
    }
}

impl Cue for KeypointDistance<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let seen = posed.seen(i);
            let points = self.points(posed.figure);
            *out = points
                .map(|(point, keypoint, mismatch_m)| loss(seen[point], keypoint, mismatch_m, self.parameters))
                .sum();
        }
    }

    /// A wild point's spread grows with how far off it is (Geman & McClure), so that it ends up saying nothing; farther than it
    /// may be where the state itself is uncertain.
    fn linearise(&self, at: &Sloped<'_>, rows: &mut Rows) {
        for Off { residual, spread, slope, .. } in self.off(at) {
            let expected = spread * spread + at.variance(&slope);
            let wild = 1.0 + residual.norm_squared() / (expected * self.parameters.reach * self.parameters.reach);
            rows.push_pixel(residual, &slope, (spread * wild).powi(2));
        }
    }

    fn reads(&self, figure: &Figure) -> usize {
        figure.model.len()
    }
}

/// Pairs of [`KEYPOINTS`] that a detector may take for one another.
const SIDES: [[usize; 2]; 4] = [[1, 2], [3, 4], [5, 6], [7, 8]];
/// A person may have moved since the last frame, and a first pose may be rough: so many times as far as a point usually is off.
const ANYWHERE: f64 = 4.0;
/// The same where it is asked which side is which.
const SIDEWAYS: f64 = 2.0;
/// By so much, in log units, must points explain a figure better with left and right exchanged.
const EXCHANGED: f64 = 4.0;

/// The same with left and right exchanged, as detectors do from one frame to the next.
fn exchanged(person: &Person) -> Person {
    let mut other = *person;
    for [left, right] in SIDES {
        other.swap(left, right);
    }
    other
}

/// The person whose points lie nearest to where the figure's are expected, left and right as the figure has them; none where
/// no point of any is within reach.
pub fn nearest(
    people: &[Person],
    figure: &Figure,
    seen: &[Projected],
    parameters: KeypointParameters,
) -> Option<Person> {
    let gained = |person: &Person, wider: f64| {
        let parameters = KeypointParameters { inflation: wider * parameters.inflation, ..parameters };
        let most = 0.5 * parameters.reach * parameters.reach;
        let points = KEYPOINTS.iter().zip(person).zip(&figure.keypoints);
        let each = points.filter_map(|(((_, _, mismatch_m), keypoint), point)| {
            Some(most - loss(seen[(*point)?], (*keypoint)?, *mismatch_m, parameters))
        });
        each.sum::<f64>()
    };
    let either = |person: &Person| gained(person, ANYWHERE).max(gained(&exchanged(person), ANYWHERE));
    let best = people.iter().map(|person| (either(person), person)).max_by(|a, b| a.0.total_cmp(&b.0));
    let (_, person) = best.filter(|(gained, _)| *gained > 1.0)?;
    let other = exchanged(person);
    let is_exchanged = gained(&other, SIDEWAYS) > gained(person, SIDEWAYS) + EXCHANGED;
    Some(if is_exchanged { other } else { *person })
}
