//! Sums in sixteen interleaved parts: a fixed order, which vector instructions can follow.
//!
//! A running sum waits for its last addition; sixteen of them do not wait for each other. The order depends on nothing
//! but the length, so that the bits are the same on every processor and for any number of threads.

/// Parts of a sum.
const PARTS: usize = 16;

/// The parts, in a fixed order.
#[inline(always)]
fn whole(parts: [f64; PARTS]) -> f64 {
    parts.iter().sum()
}

/// Sum of `term` of every element of `a`.
#[inline(always)]
pub fn sum_of(a: &[f64], term: impl Fn(f64) -> f64) -> f64 {
    let mut parts = [0.0; PARTS];
    let (chunks, tail) = a.as_chunks::<PARTS>();
    for chunk in chunks {
        parts = std::array::from_fn(|p| parts[p] + term(chunk[p]));
    }
    whole(parts) + tail.iter().map(|x| term(*x)).sum::<f64>()
}

/// Sum of `a`.
#[inline(always)]
pub fn sum(a: &[f64]) -> f64 {
    sum_of(a, |x| x)
}

/// Sum of `a * b`, of equal length.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut parts = [0.0; PARTS];
    let ((a4, a_tail), (b4, b_tail)) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
    for (x, y) in a4.iter().zip(b4) {
        parts = std::array::from_fn(|p| parts[p] + x[p] * y[p]);
    }
    whole(parts) + a_tail.iter().zip(b_tail).map(|(x, y)| x * y).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_term_is_counted_once() {
        for len in 0..40_u32 {
            let a: Vec<f64> = (0..len).map(f64::from).collect();
            let n = f64::from(len);
            assert_eq!(sum(&a), n * (n - 1.0) / 2.0);
            assert_eq!(dot(&a, &a), n * (n - 1.0) * (2.0 * n - 1.0) / 6.0);
        }
    }
}
