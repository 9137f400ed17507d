//! Eight numbers at a time, in code that reads like one: what the compiler turns into vector instructions.

use std::ops::{Add, Mul, Neg, Sub};

/// How many.
pub const LANES: usize = 8;

/// One number of each of [`LANES`] particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// The same number everywhere.
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i])))
    }

    /// Sine and cosine within 1e-15 for angles below a million radians: reduced by quarter turns (Cody & Waite 1980),
    /// then Taylor polynomials.
    #[inline(always)]
    pub fn sin_cos(self) -> (Self, Self) {
        const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it leaves the nearest whole number
        const HIGH: f64 = 1.570_796_326_734_125_6;
        const MIDDLE: f64 = 6.077_100_506_303_966e-11;
        const LOW: f64 = 2.022_266_248_795_950_6e-21;
        let shifted = self.map(|x| x * std::f64::consts::FRAC_2_PI + WHOLE);
        let k = shifted.map(|s| s - WHOLE);
        let r = self - k * Self::splat(HIGH) - k * Self::splat(MIDDLE) - k * Self::splat(LOW);
        let r2 = r * r;
        let sin = r + r
            * r2
            * polynomial(
                r2,
                [
                    -7.647_163_731_819_816e-13,
                    1.605_904_383_682_161_5e-10,
                    -2.505_210_838_544_172e-8,
                    2.755_731_922_398_589e-6,
                    -1.984_126_984_126_984e-4,
                    8.333_333_333_333_333e-3,
                    -1.666_666_666_666_666_6e-1,
                ],
            );
        let cos = Self::splat(1.0)
            + r2 * polynomial(
                r2,
                [
                    -1.147_074_559_772_972_5e-11,
                    2.087_675_698_786_81e-9,
                    -2.755_731_922_398_589e-7,
                    2.480_158_730_158_73e-5,
                    -1.388_888_888_888_889e-3,
                    4.166_666_666_666_666_4e-2,
                    -0.5,
                ],
            );
        // The low bits of `shifted` count quarter turns: odd ones swap sine and cosine, and some turn the sign. On bits,
        // because a choice per number would leave the vector.
        let quarter = shifted.0.map(f64::to_bits);
        let pick = |even: Self, odd: Self, signs: [u64; LANES]| {
            Self(std::array::from_fn(|i| {
                let swap = 0u64.wrapping_sub(quarter[i] & 1);
                let value = (even.0[i].to_bits() & !swap) | (odd.0[i].to_bits() & swap);
                f64::from_bits(value ^ ((signs[i] & 2) << 62))
            }))
        };
        (pick(sin, cos, quarter), pick(cos, sin, quarter.map(|q| q.wrapping_add(1))))
    }
}

/// Horner's scheme, highest power first.
#[inline(always)]
fn polynomial<const K: usize>(x: Lanes, coefficients: [f64; K]) -> Lanes {
    coefficients.iter().fold(Lanes::splat(0.0), |sum, c| sum * x + Lanes::splat(*c))
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine() {
        for i in -40_000..40_000 {
            let x = f64::from(i) * 0.003_7;
            let (s, c) = Lanes::splat(x).sin_cos();
            assert!((s.0[1] - x.sin()).abs() < 1e-14 && (c.0[2] - x.cos()).abs() < 1e-14, "{x}");
        }
        assert!(Lanes::splat(f64::NAN).sin_cos().0.0[0].is_nan());
    }
}
