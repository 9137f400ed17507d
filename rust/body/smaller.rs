//! Masks of a picture that was made smaller: where in them a pixel of the frame lies, and back.

use crate::{Result, error::require};

/// By how many whole times; pixel centres are at integers in both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smaller {
    times: f64,
    per_px: f64,
    offset: f64,
}

impl Default for Smaller {
    /// As large as the frame.
    fn default() -> Self {
        Self { times: 1.0, per_px: 1.0, offset: 0.0 }
    }
}

impl Smaller {
    /// Pixels of which each is the mean of `times` by `times` of the frame.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for none, or more than 64.
    pub fn new(times: usize) -> Result<Self> {
        require((1..=64).contains(&times), "shrunk", times as f64, "1 to 64 times")?;
        let per_px = 1.0 / times as f64;
        Ok(Self { times: times as f64, per_px, offset: 0.5 * per_px - 0.5 })
    }

    /// How many pixels of the frame are one.
    #[inline(always)]
    pub fn times(&self) -> f64 {
        self.times
    }

    /// Where a place of the frame is, px of the smaller picture.
    #[inline(always)]
    pub fn within(&self, place: [f64; 2]) -> [f64; 2] {
        place.map(|x| x * self.per_px + self.offset)
    }

    /// Where a place of the smaller picture is, px of the frame.
    #[inline(always)]
    pub fn in_frame(&self, place: [f64; 2]) -> [f64; 2] {
        place.map(|x| (x - self.offset) * self.times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_lies_in_the_middle_of_those_that_it_was_made_of() {
        let smaller = Smaller::new(4).unwrap();
        assert_eq!(smaller.within([1.5, 5.5]), [0.0, 1.0]);
        assert_eq!(smaller.in_frame([0.0, 1.0]), [1.5, 5.5]);
        assert_eq!(Smaller::new(1).unwrap(), Smaller::default());
        assert_eq!(Smaller::default().within([0.1, -7.3]), [0.1, -7.3]);
        assert!(Smaller::new(0).is_err() && Smaller::new(65).is_err());
    }
}
