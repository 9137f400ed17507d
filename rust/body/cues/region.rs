//! Skin and foreground as regions: what should be on them is, and what they show is explained by a limb.
//!
//! Not in the paper, whose blobs are centres: where a hand meets another hand, a bare forearm or the face, its blob is merged
//! with theirs, and the centre is no hand. A mask tells all the same where hands and forearms are, and that each patch of it
//! belongs to somebody. Both directions count (a chamfer distance: Barrow et al., IJCAI 1977), each capped, since masks
//! have holes and spots.

use super::super::figure::Figure;
use super::super::joints::{Group, KEY_JOINTS};
use super::super::smaller::Smaller;
use super::super::weighing::{Cue, Posed};
use crate::parameters::{Parameters, require_not_negative, require_positive};
use crate::projection::Projected;
use crate::{Error, Result, error::require};
use serde::{Deserialize, Serialize};

/// A mask: how far every pixel is from it, and some of its pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    width: usize,
    height: usize,
    distance: Vec<f32>,
    points: Vec<[f64; 2]>,
    smaller: Smaller,
}

/// How much regions count, and how far off a place may be before it is as bad as any.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RegionParameters {
    /// Log-likelihood lost by hands and forearms off the skin, and by skin that nobody wears.
    pub skin_loss: f64,
    /// The same of limbs and the foreground.
    pub foreground_loss: f64,
    /// As bad as any, m.
    pub reach_m: f64,
}

impl RegionParameters {
    /// Of a method's `skin_loss`, `foreground_loss` and `region_reach_m`.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn read(from: &Parameters) -> Result<Self> {
        let [skin_loss, foreground_loss] = [from.get("skin_loss")?, from.get("foreground_loss")?];
        Ok(Self { skin_loss, foreground_loss, reach_m: from.get("region_reach_m")? })
    }

    /// Check every range.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        require_not_negative("skin_loss", self.skin_loss, "0 or more")?;
        require_not_negative("foreground_loss", self.foreground_loss, "0 or more")?;
        require_positive("region_reach_m", self.reach_m, "a positive length in metres")
    }
}

/// Skin and foreground, where each is given, against the limbs.
pub struct Regions<'a> {
    /// Skin.
    pub skin: Option<&'a Region>,
    /// The person.
    pub foreground: Option<&'a Region>,
    /// Groups whose limbs may be amiss.
    pub groups: &'a [Group],
    /// How much they count.
    pub parameters: RegionParameters,
    /// How bare the forearms are, 0 to 1.
    pub bare: f64,
}

impl Cue for Regions<'_> {
    fn score(&self, posed: &Posed<'_>, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let seen = &posed.seen(i)[..posed.figure.drawn];
            *out = self.loss(posed.figure, seen);
        }
    }
}

impl Regions<'_> {
    /// What is lost by a posed figure, `seen` in the picture.
    fn loss(&self, figure: &Figure, seen: &[Projected]) -> f64 {
        let Self { skin, foreground, groups, parameters, bare } = *self;
        let px_per_m = seen[0].px_per_m;
        if !px_per_m.is_finite() || !seen.iter().all(|point| point.u.is_finite() && point.v.is_finite()) {
            return 2.0 * (parameters.skin_loss + parameters.foreground_loss);
        }
        let capped = 1.0 / (parameters.reach_m * px_per_m);
        let arms = || groups.iter().filter(|group| **group != Group::Torso);
        let count = arms().count() as f64;
        let mut lost = 0.0;
        if let Some(skin) = skin.filter(|skin| parameters.skin_loss > 0.0 && count > 0.0 && !skin.points.is_empty()) {
            let off: f64 = arms().map(|group| off_skin(skin, seen, *group, bare, capped)).sum();
            let worn = skin_wearers(figure, seen, bare, px_per_m);
            lost +=
                parameters.skin_loss * (OFF * off / count + unexplained(&skin.points, &worn, capped, f64::INFINITY));
        }
        if let Some(foreground) = foreground.filter(|mask| parameters.foreground_loss > 0.0 && !mask.points.is_empty())
        {
            let off: f64 = arms().map(|group| off_foreground(foreground, seen, *group, capped)).sum();
            let limbs = all_limbs(figure, seen, px_per_m);
            // The model has no legs: what is below the hips says nothing.
            let lowest = seen[0].v;
            lost += parameters.foreground_loss
                * (OFF * off / count.max(1.0) + unexplained(&foreground.points, &limbs, capped, lowest));
        }
        lost
    }
}

/// A limb in the picture: a line with round ends, px.
#[derive(Debug, Clone, Copy)]
struct Capsule {
    from: [f64; 2],
    along: [f64; 2],
    per_length2: f64,
    radius: f64,
}

/// Half-width of a hand, m; and how much wider than its limb skin may be taken to be, m.
const HAND_M: f64 = 0.05;
const SLACK_M: f64 = 0.02;
/// A limb off its mask counts this share of what a mask counts that no limb explains: hands are overlooked more often than seen
/// where there are none.
const OFF: f64 = 0.25;
/// An outer shape has six limbs; hands besides.
const MOST_LIMBS: usize = 16;
/// Where along a forearm, from elbow to wrist, and an upper arm, from shoulder to elbow, it is looked.
const ON_FOREARM: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
const ON_UPPER_ARM: [f64; 3] = [0.4, 0.7, 1.0];

impl Region {
    /// `distance` `(height, width)` in px, 0 on the mask; `points` on it.
    ///
    /// # Errors
    /// [`Error::Size`], [`Error::Parameter`].
    pub fn new(width: usize, height: usize, distance: Vec<f32>, points: Vec<[f64; 2]>) -> Result<Self> {
        require((1..=16384).contains(&width), "region width", width as f64, "1 to 16384 px")?;
        require((1..=16384).contains(&height), "region height", height as f64, "1 to 16384 px")?;
        if distance.len() != width * height {
            return Err(Error::Size { name: "region", got: distance.len(), unit: "pixels", expected: width * height });
        }
        // Without leaving early it is many pixels at once.
        let is_odd = |d: &f32| d.is_nan() || *d < 0.0;
        if distance.iter().fold(false, |odd, d| odd | is_odd(d)) {
            let odd = distance.iter().copied().find(is_odd).map_or(f64::NAN, f64::from);
            require(false, "distance to a region", odd, "0 px or more")?;
        }
        if let Some(odd) = points.iter().flatten().find(|x| x.is_nan() || x.abs() > 16384.0) {
            require(false, "point of a region", *odd, "a pixel")?;
        }
        Ok(Self { width, height, distance, points, smaller: Smaller::default() })
    }

    /// Found in a picture made smaller, whose pixels it was given in: from here on all is in the frame's.
    pub fn of_smaller(mut self, smaller: Smaller) -> Self {
        self.points.iter_mut().for_each(|point| *point = smaller.in_frame(*point));
        Self { smaller, ..self }
    }

    /// Distance of a place from the mask, px; none outside the picture, where nothing is known.
    #[inline]
    pub fn distance(&self, place: [f64; 2]) -> Option<f64> {
        let [x, y] = self.smaller.within(place).map(|x| x + 0.5);
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        is_inside.then(|| self.smaller.times() * f64::from(self.distance[y as usize * self.width + x as usize]))
    }
}

impl Capsule {
    fn new(a: Projected, b: Projected, radius: f64) -> Self {
        let along = [b.u - a.u, b.v - a.v];
        let length2 = along[0] * along[0] + along[1] * along[1];
        Self { from: [a.u, a.v], along, per_length2: 1.0 / length2.max(1e-9), radius }
    }

    /// Squared distance of a place from its line, px².
    #[inline(always)]
    fn distance2(&self, [u, v]: [f64; 2]) -> f64 {
        let (x, y) = (u - self.from[0], v - self.from[1]);
        let at = ((x * self.along[0] + y * self.along[1]) * self.per_length2).clamp(0.0, 1.0);
        let (x, y) = (x - at * self.along[0], y - at * self.along[1]);
        x * x + y * y
    }
}

/// Ends of the limbs of an arm among the points of the model: (shoulder, elbow), (elbow, wrist), (wrist, hand).
fn arm(group: Group) -> [(usize, usize); 3] {
    let hand = KEY_JOINTS.len() + 2 * group.wearer();
    match group {
        Group::LeftArm => [(2, 4), (4, 6), (6, hand)],
        _ => [(3, 5), (5, 7), (7, hand)],
    }
}

fn between(seen: &[Projected], (a, b): (usize, usize), share: f64) -> [f64; 2] {
    [seen[a].u + share * (seen[b].u - seen[a].u), seen[a].v + share * (seen[b].v - seen[a].v)]
}

/// As many limbs as there are, without a heap.
struct Limbs {
    capsules: [Capsule; MOST_LIMBS],
    count: usize,
}

impl Limbs {
    fn of(capsules: impl Iterator<Item = Capsule>) -> Self {
        let none = Capsule { from: [0.0; 2], along: [0.0; 2], per_length2: 0.0, radius: 0.0 };
        let mut limbs = Self { capsules: [none; MOST_LIMBS], count: 0 };
        for capsule in capsules.take(MOST_LIMBS) {
            limbs.capsules[limbs.count] = capsule;
            limbs.count += 1;
        }
        limbs
    }
}

/// Of a hand and its forearm: mean capped distance from the skin, 0 to 1.
fn off_skin(skin: &Region, seen: &[Projected], group: Group, bare: f64, capped: f64) -> f64 {
    let [_, forearm, hand] = arm(group);
    let mut sum = 0.0;
    let mut weight = 0.0;
    let mut visit = |place: [f64; 2], counts: f64| {
        if let Some(distance) = skin.distance(place) {
            sum += counts * (distance * capped).min(1.0);
            weight += counts;
        }
    };
    visit(between(seen, hand, 1.0), 2.0);
    visit(between(seen, hand, 0.5), 1.0);
    for share in ON_FOREARM {
        visit(between(seen, forearm, share), bare);
    }
    if weight > 0.0 { sum / weight } else { 0.5 }
}

/// Of an arm: mean capped distance from the foreground, 0 to 1.
fn off_foreground(mask: &Region, seen: &[Projected], group: Group, capped: f64) -> f64 {
    let [upper_arm, forearm, hand] = arm(group);
    let upper = ON_UPPER_ARM.iter().map(|share| between(seen, upper_arm, *share));
    let places = upper.chain(ON_FOREARM.iter().map(|share| between(seen, forearm, *share)));
    let (mut sum, mut count) = (0.0, 0.0);
    for distance in places.chain([between(seen, hand, 1.0)]).filter_map(|place| mask.distance(place)) {
        sum += (distance * capped).min(1.0);
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.5 }
}

/// How far a place is beyond the nearest of some limbs, px; 0 within one.
#[inline(always)]
fn beyond(capsules: &[Capsule], point: [f64; 2]) -> f64 {
    let mut nearest = f64::MAX;
    for capsule in capsules {
        let distance2 = capsule.distance2(point);
        if distance2 <= capsule.radius * capsule.radius {
            return 0.0;
        }
        nearest = nearest.min(distance2.sqrt() - capsule.radius);
    }
    nearest
}

/// Mean capped distance of points of a mask above `lowest` from the nearest limb, 0 to 1.
fn unexplained(points: &[[f64; 2]], limbs: &Limbs, capped: f64, lowest: f64) -> f64 {
    let capsules = &limbs.capsules[..limbs.count];
    let (mut sum, mut count) = (0.0, 0.0);
    for point in points.iter().filter(|point| point[1] <= lowest) {
        sum += (beyond(capsules, *point) * capped).min(1.0);
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Head, hands and as much of the forearms as is bare.
fn skin_wearers(figure: &Figure, seen: &[Projected], bare: f64, px_per_m: f64) -> Limbs {
    let radius = (HAND_M + SLACK_M) * px_per_m;
    let heads = figure.limbs.iter().filter(|limb| limb.group == Group::Torso).skip(1);
    let heads = heads
        .map(|head| Capsule::new(seen[head.start], seen[head.end], (head.half_width_m[0] + 2.0 * SLACK_M) * px_per_m));
    let arms = [Group::LeftArm, Group::RightArm].into_iter().flat_map(|group| {
        let [_, (elbow, wrist), (_, hand)] = arm(group);
        let [u, v] = between(seen, (wrist, elbow), bare);
        let forearm = Capsule::new(seen[wrist], Projected { u, v, ..seen[elbow] }, radius);
        [Capsule::new(seen[wrist], seen[hand], radius), forearm]
    });
    Limbs::of(heads.chain(arms))
}

fn all_limbs(figure: &Figure, seen: &[Projected], px_per_m: f64) -> Limbs {
    let radius = |half: [f64; 2]| (0.5 * (half[0] + half[1]) + SLACK_M) * px_per_m;
    let limbs =
        figure.limbs.iter().map(|limb| Capsule::new(seen[limb.start], seen[limb.end], radius(limb.half_width_m)));
    let hand = |group| {
        let [_, _, (wrist, hand)] = arm(group);
        Capsule::new(seen[wrist], seen[hand], (HAND_M + SLACK_M) * px_per_m)
    };
    // The torso explains most: it is asked first.
    Limbs::of(limbs.chain([hand(Group::LeftArm), hand(Group::RightArm)]))
}

/// How bare the forearms of a posed figure are: the share of places on them that lie on skin, 0 to 1; all of it where
/// no hand is seen.
pub fn bareness(skin: &Region, seen: &[Projected]) -> f64 {
    let on = |place| skin.distance(place).is_some_and(|distance| distance <= SLACK_M * seen[0].px_per_m);
    let arms = [Group::LeftArm, Group::RightArm].map(arm);
    if !arms.iter().any(|[_, _, hand]| on(between(seen, *hand, 1.0))) {
        return 1.0;
    }
    let places = arms.iter().flat_map(|[_, forearm, _]| ON_FOREARM.map(|share| on(between(seen, *forearm, share))));
    let (hits, count) = places.fold((0.0, 0.0), |(hits, count), hit| (hits + f64::from(u8::from(hit)), count + 1.0));
    hits / count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mask of one square, its distances counted by hand.
    fn square() -> Region {
        let (width, height) = (20_usize, 10_usize);
        let beside = |x: usize, low: usize, high: usize| (low as f64 - x as f64).max(x as f64 - high as f64).max(0.0);
        let distance =
            (0..width * height).map(|k| beside(k % width, 4, 8).hypot(beside(k / width, 2, 5)) as f32).collect();
        Region::new(width, height, distance, vec![[4.0, 2.0], [8.0, 5.0]]).unwrap()
    }

    #[test]
    fn distances_are_those_of_the_mask_and_outside_nothing_is_known() {
        let region = square();
        assert_eq!(region.distance([6.0, 3.0]), Some(0.0));
        assert_eq!(region.distance([11.0, 9.0]), Some(5.0));
        assert_eq!(region.distance([-1.0, 3.0]), None);
        assert_eq!(region.distance([19.4, 9.4]), Some(f64::from((11f32 * 11.0 + 16.0).sqrt())));
        assert!(Region::new(3, 3, vec![0.0; 8], Vec::new()).is_err());
        assert!(Region::new(1, 1, vec![f32::NAN], Vec::new()).is_err());
    }

    #[test]
    fn a_capsule_explains_what_is_within_it() {
        let at = |u: f64, v: f64| Projected { u, v, px_per_m: 100.0 };
        let limb = Capsule::new(at(10.0, 10.0), at(30.0, 10.0), 3.0);
        assert_eq!(beyond(&[limb], [20.0, 12.0]), 0.0);
        assert_eq!(beyond(&[limb], [20.0, 17.0]), 4.0);
        assert_eq!(beyond(&[limb], [36.0, 18.0]), 7.0);
        let points = [[20.0, 12.0], [20.0, 17.0], [20.0, 90.0]];
        let limbs = Limbs::of(std::iter::once(limb));
        assert!((unexplained(&points, &limbs, 0.1, f64::INFINITY) - (0.0 + 0.4 + 1.0) / 3.0).abs() < 1e-12);
        assert!((unexplained(&points, &limbs, 0.1, 50.0) - 0.2).abs() < 1e-12);
    }
}
