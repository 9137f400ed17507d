//! Forward kinematics of a sub-model's segments, [`LANES`] particles at a time.

use super::lanes::{LANES, Lanes};
use super::segment::{Segment, Source, Turn};
use multiversion::multiversion;
use nalgebra::{Matrix3, Vector3};

/// Rotation (rows) and origin of a segment.
#[derive(Debug, Clone, Copy)]
struct Frame {
    rotation: [[Lanes; 3]; 3],
    origin: [Lanes; 3],
}

impl Frame {
    fn world() -> Self {
        Self { rotation: constant(&Matrix3::identity()), origin: [Lanes::splat(0.0); 3] }
    }

    #[inline(always)]
    fn at(&self, point: &Vector3<f64>) -> [Lanes; 3] {
        std::array::from_fn(|r| {
            let [x, y, z] = self.rotation[r];
            self.origin[r] + x * Lanes::splat(point.x) + y * Lanes::splat(point.y) + z * Lanes::splat(point.z)
        })
    }

    /// A frame within this one, before its own turns.
    #[inline(always)]
    fn child(&self, frame: Option<&Matrix3<f64>>, origin: [Lanes; 3]) -> Self {
        let times = |[x, y, z]: [Lanes; 3], [a, b, c]: [Lanes; 3]| x * a + y * b + z * c;
        let turned = |m: &Matrix3<f64>| {
            let row = |row| std::array::from_fn(|c| times(row, std::array::from_fn(|k| Lanes::splat(m[(k, c)]))));
            self.rotation.map(row)
        };
        Self {
            rotation: frame.map_or(self.rotation, turned),
            origin: std::array::from_fn(|r| self.origin[r] + times(self.rotation[r], origin)),
        }
    }

    /// About one axis after the other: which ones is known to the compiler, so that nothing is indexed at run time.
    #[inline(always)]
    fn turned(self, axis: usize, turn: (Lanes, Lanes)) -> Self {
        match axis {
            0 => self.turned_about::<1, 2>(turn),
            1 => self.turned_about::<2, 0>(turn),
            _ => self.turned_about::<0, 1>(turn),
        }
    }

    #[inline(always)]
    fn turned_about<const J: usize, const K: usize>(mut self, (sin, cos): (Lanes, Lanes)) -> Self {
        for row in &mut self.rotation {
            (row[J], row[K]) = (row[J] * cos + row[K] * sin, row[K] * cos - row[J] * sin);
        }
        self
    }
}

/// The same matrix for every particle.
#[inline(always)]
fn constant(m: &Matrix3<f64>) -> [[Lanes; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| Lanes::splat(m[(r, c)])))
}

/// Forward kinematics of `count` particles, with the widest vectors that the processor has.
#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512vl+avx512dq+avx512bw+avx512cd", "x86_64+avx2"))]
pub(super) fn forward(
    segments: &[Segment],
    points: &[(usize, Vector3<f64>)],
    columns: &[&[f64]],
    count: usize,
    out: &mut [f64],
) {
    forward_by_lanes(segments, points, columns, count, out);
}

/// The same, [`LANES`] particles at a time, in whatever instructions the caller is built for.
#[inline(always)]
pub(super) fn forward_by_lanes(
    segments: &[Segment],
    points: &[(usize, Vector3<f64>)],
    columns: &[&[f64]],
    count: usize,
    out: &mut [f64],
) {
    let mut frames = vec![Frame::world(); segments.len()];
    for first in (0..count).step_by(LANES) {
        let wide = (count - first).min(LANES);
        let value = |source: Source| match source {
            Source::Fixed(x) => Lanes::splat(x),
            Source::Free(column) => {
                let numbers = &columns[column][first..first + wide];
                // The last few particles are computed with copies of the last.
                match <[f64; LANES]>::try_from(numbers) {
                    Ok(numbers) => Lanes(numbers),
                    Err(_) => Lanes(std::array::from_fn(|i| numbers[i.min(wide - 1)])),
                }
            }
        };
        for s in 0..segments.len() {
            let segment = &segments[s];
            let origin = segment.origin.map(value);
            let mut frame = match segment.parent {
                None => Frame { rotation: constant(&segment.frame.unwrap_or_else(Matrix3::identity)), origin },
                Some(parent) => frames[parent].child(segment.frame.as_ref(), origin),
            };
            for (axis, turn) in &segment.turns {
                let (sin, cos) = match turn {
                    Turn::Fixed(sin, cos) => (Lanes::splat(*sin), Lanes::splat(*cos)),
                    Turn::Free(column) => value(Source::Free(*column)).sin_cos(),
                };
                frame = frame.turned(*axis, (sin, cos));
            }
            frames[s] = frame;
        }
        for (p, (segment, place)) in points.iter().enumerate() {
            // Many a point is a joint: where its segment begins.
            let is_joint = *place == Vector3::zeros();
            let at = if is_joint { frames[*segment].origin } else { frames[*segment].at(place) };
            for (d, lanes) in at.iter().enumerate() {
                let start = (3 * p + d) * count + first;
                // A copy of known length is one store.
                match out[start..].first_chunk_mut::<LANES>() {
                    Some(whole) if wide == LANES => *whole = lanes.0,
                    _ => out[start..start + wide].copy_from_slice(&lanes.0[..wide]),
                }
            }
        }
    }
}
