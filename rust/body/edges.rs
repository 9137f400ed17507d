//! The edge cue, Li & Kulić eq. (4): which share of a part's projected outline meets no detected edge.

use super::smaller::Smaller;
use crate::projection::Projected;
use crate::{Error, Result};
use rayon::prelude::*;

/// Detected edges: a byte a pixel, 1 on an edge.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeImage {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
    smaller: Smaller,
}

/// Outlines that a thread takes at once.
const OUTLINES: usize = 128;

/// Fractions of a pixel in fixed-point coordinates.
const FRACTION: u32 = 16;

impl EdgeImage {
    /// From `(height, width)` bytes, row by row; any byte but zero is an edge.
    ///
    /// # Errors
    /// [`Error::Size`] when the bytes do not fill it, [`Error::Parameter`] when it has no pixel or a side beyond 16384.
    pub fn new(width: usize, height: usize, bytes: &[u8]) -> Result<Self> {
        let side = "1 to 16384 px";
        crate::error::require((1..=16384).contains(&width), "edges width", width as f64, side)?;
        crate::error::require((1..=16384).contains(&height), "edges height", height as f64, side)?;
        if bytes.len() != width * height {
            return Err(Error::Size { name: "edges", got: bytes.len(), unit: "pixels", expected: width * height });
        }
        let pixels = bytes.iter().map(|b| u8::from(*b != 0)).collect();
        Ok(Self { width, height, pixels, smaller: Smaller::default() })
    }

    /// Detected in a picture made smaller: outlines are given in the frame's pixels.
    pub fn of_smaller(self, smaller: Smaller) -> Self {
        Self { smaller, ..self }
    }

    /// Share of the outline's pixels that lie on no edge, 0 to 1: every pixel of the four sides is looked at. A pixel
    /// outside the image is a miss, and so is an outline that cannot be projected.
    pub fn missed(&self, corners: &[[f64; 2]; 4]) -> f64 {
        let corners = corners.map(|corner| self.smaller.within(corner));
        if !corners.iter().flatten().all(|x| x.abs() < 16384.0) {
            return 1.0;
        }
        let (mut hits, mut pixels) = (0, 0);
        for k in 0..4 {
            let (h, n) = self.walk(corners[k], corners[(k + 1) % 4]);
            hits += h;
            pixels += n;
        }
        1.0 - f64::from(hits) / f64::from(pixels)
    }

    /// [`EdgeImage::missed`] of many outlines, `out` one each; threads share them.
    ///
    /// # Panics
    /// When there are not as many values as outlines.
    pub fn missed_all(&self, outlines: &[[[f64; 2]; 4]], out: &mut [f64]) {
        assert_eq!(outlines.len(), out.len(), "one value an outline");
        let work = |(outlines, out): (&[[[f64; 2]; 4]], &mut [f64])| {
            for (outline, out) in outlines.iter().zip(out) {
                *out = self.missed(outline);
            }
        };
        outlines.par_chunks(OUTLINES).zip(out.par_chunks_mut(OUTLINES)).for_each(work);
    }

    /// Pixels on an edge along a line, and all its pixels: one a step of the longer axis.
    #[inline(always)]
    fn walk(&self, from: [f64; 2], to: [f64; 2]) -> (u32, u32) {
        let (du, dv) = (to[0] - from[0], to[1] - from[1]);
        // Adding a half and cutting rounds, without the library call that `round` is on older processors.
        let steps = ((du.abs().max(dv.abs()) + 0.5) as i32).max(1);
        let per_step = f64::from(1 << FRACTION) / f64::from(steps);
        let fixed = |x: f64| (x * f64::from(1 << FRACTION)) as i32;
        // Half a pixel more: pixel centres are at integers, and shifting rounds down.
        let (mut u, mut v) = (fixed(from[0] + 0.5), fixed(from[1] + 0.5));
        let (step_u, step_v) = ((du * per_step) as i32, (dv * per_step) as i32);
        let mut hits = 0;
        if self.is_inside(u, v) && self.is_inside(u + step_u * steps, v + step_v * steps) {
            for _ in 0..=steps {
                let at = (v >> FRACTION) as usize * self.width + (u >> FRACTION) as usize;
                hits += u32::from(self.pixels[at]);
                u += step_u;
                v += step_v;
            }
        } else {
            for _ in 0..=steps {
                if self.is_inside(u, v) {
                    hits += u32::from(self.pixels[(v >> FRACTION) as usize * self.width + (u >> FRACTION) as usize]);
                }
                u += step_u;
                v += step_v;
            }
        }
        (hits, steps as u32 + 1)
    }

    #[inline(always)]
    fn is_inside(&self, u: i32, v: i32) -> bool {
        u >= 0 && v >= 0 && ((u >> FRACTION) as usize) < self.width && ((v >> FRACTION) as usize) < self.height
    }
}

/// Corners of the rectangle about a projected limb, of half-widths given in metres at either end. A limb that points at the
/// camera has no direction of its own and keeps its ends.
#[inline]
pub fn rectangle(start: Projected, end: Projected, half_width_m: [f64; 2]) -> [[f64; 2]; 4] {
    let (du, dv) = (end.u - start.u, end.v - start.v);
    let length = (du * du + dv * dv).sqrt();
    let (nu, nv) = if length > 1e-9 { (-dv / length, du / length) } else { (1.0, 0.0) };
    let (a, b) = (half_width_m[0] * start.px_per_m, half_width_m[1] * end.px_per_m);
    [
        [start.u + nu * a, start.v + nv * a],
        [end.u + nu * b, end.v + nv * b],
        [end.u - nu * b, end.v - nv * b],
        [start.u - nu * a, start.v - nv * a],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn image(is_edge: impl Fn(i64, i64) -> bool) -> EdgeImage {
        let bytes: Vec<u8> = (0..60 * 80).map(|i| u8::from(is_edge(i % 80, i / 80)) * 255).collect();
        EdgeImage::new(80, 60, &bytes).unwrap()
    }

    #[test]
    fn an_outline_on_edges_misses_nothing_and_elsewhere_all() {
        let drawn = image(|u, v| {
            ((10..=40).contains(&u) && (v == 20 || v == 30)) || ((20..=30).contains(&v) && (u == 10 || u == 40))
        });
        let corners = [[10.0, 20.0], [40.0, 20.0], [40.0, 30.0], [10.0, 30.0]];
        assert_eq!(drawn.missed(&corners), 0.0);
        assert_eq!(drawn.missed(&corners.map(|[u, v]| [u + 3.0, v + 3.0])), 1.0 - 2.0 / 84.0);
        assert_eq!(drawn.missed(&corners.map(|[u, v]| [u - 300.0, v])), 1.0);
        assert_eq!(drawn.missed(&[[f64::NAN; 2]; 4]), 1.0);
    }

    #[test]
    fn edges_of_a_smaller_picture_are_met_by_the_frames_outlines() {
        let drawn = image(|u, v| (10..=40).contains(&u) && v == 20).of_smaller(Smaller::new(3).unwrap());
        assert_eq!(drawn.missed(&[[31.0, 61.0], [121.0, 61.0], [121.0, 61.0], [31.0, 61.0]]), 0.0);
        assert_eq!(drawn.missed(&[[31.0, 63.0], [121.0, 63.0], [121.0, 63.0], [31.0, 63.0]]), 1.0);
    }

    #[test]
    fn a_limb_towards_the_camera_keeps_its_ends() {
        let at = Projected { u: 40.0, v: 30.0, px_per_m: 100.0 };
        let corners = rectangle(at, at, [0.1, 0.05]);
        assert_eq!(corners, [[50.0, 30.0], [45.0, 30.0], [35.0, 30.0], [30.0, 30.0]]);
        assert!(image(|_, v| v == 30).missed(&corners) < 1e-12);
    }

    proptest! {
        /// Against a walk by rounding each point of the line.
        #[test]
        fn every_pixel_of_the_line_is_looked_at(
            from in prop::array::uniform2(-20.0..90.0f64),
            to in prop::array::uniform2(-20.0..90.0f64),
        ) {
            let drawn = image(|u, v| (u / 3 + v / 2) % 2 == 0);
            let (hits, count) = drawn.walk(from, to);
            let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).round().max(1.0);
            prop_assert_eq!(f64::from(count), steps + 1.0);
            let (mut expected, mut doubtful) = (0_i64, 0_i64);
            for k in 0..count {
                let [u, v] = [0, 1].map(|d| from[d] + (to[d] - from[d]) * f64::from(k) / steps);
                let near = |x: f64| ((x + 0.5) - (x + 0.5).round()).abs() < 0.01;
                doubtful += i64::from(near(u) || near(v));
                let inside = u >= -0.5 && v >= -0.5 && u < 79.5 && v < 59.5;
                expected += i64::from(inside && ((u + 0.5).floor() as i64 / 3 + (v + 0.5).floor() as i64 / 2) % 2 == 0);
            }
            prop_assert!((expected - i64::from(hits)).abs() <= doubtful);
        }
    }
}
