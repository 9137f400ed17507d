//! The reproducibility contract: which random stream a draw comes from.
//!
//! A result depends on the inputs, the method and the seed, never on the number of threads. So there is no
//! generator that lives from call to call: each block of [`BLOCK`] particles draws from a stream of its own,
//! named by (seed, step, layer, block), and so does each resampling. The generator is `Xoshiro256PlusPlus`,
//! whose values `rand` promises to keep.

use rand::SeedableRng;
pub use rand::rngs::Xoshiro256PlusPlus as Stream;

/// Particles that share one stream (and one piece of memory, see [`crate::particles`]).
pub const BLOCK: usize = 256;

/// The block number that resampling draws from, beyond any real block.
const RESAMPLING: u64 = u64::MAX;

/// The streams of one layer at one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Streams {
    key: u64,
}

impl Streams {
    /// Name the streams of `layer` at `step` of a filter seeded with `seed`.
    pub fn new(seed: u64, step: u64, layer: u64) -> Self {
        Self { key: mix(mix(mix(seed) ^ step) ^ layer) }
    }

    /// The stream of block `block` of the particle set.
    pub fn block(self, block: usize) -> Stream {
        Stream::seed_from_u64(mix(self.key ^ block as u64))
    }

    /// The stream that resampling after this layer draws from.
    pub fn resampling(self) -> Stream {
        Stream::seed_from_u64(mix(self.key ^ RESAMPLING))
    }
}

/// The seed of the `k`-th of several filters that run side by side; the first has the seed itself.
pub fn branch(seed: u64, k: u64) -> u64 {
    if k == 0 { seed } else { mix(mix(seed) ^ mix(!k)) }
}

/// SplitMix64's finaliser: a bijection of `u64` without fixed structure, so that near keys give far streams.
fn mix(key: u64) -> u64 {
    let mut z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use std::collections::HashSet;

    #[test]
    fn streams_of_neighbours_differ() {
        let mut first = HashSet::new();
        for seed in 0..5 {
            for step in 0..20 {
                for layer in 0..3 {
                    let streams = Streams::new(seed, step, layer);
                    for block in 0..10 {
                        assert!(first.insert(streams.block(block).random::<u64>()));
                    }
                    assert!(first.insert(streams.resampling().random::<u64>()));
                }
            }
        }
    }

    #[test]
    fn branches_differ() {
        let seeds: HashSet<u64> = (0..100).flat_map(|seed| (0..20).map(move |k| branch(seed, k))).collect();
        assert_eq!(seeds.len(), 2000);
        assert_eq!(branch(7, 0), 7);
    }

    #[test]
    fn values_are_pinned() {
        let draw: u64 = Streams::new(7, 0, 0).block(0).random();
        assert_eq!(draw, Streams::new(7, 0, 0).block(0).random::<u64>());
        assert_eq!(draw, PINNED, "a changed stream changes every published result");
    }
    const PINNED: u64 = 6_697_313_628_202_591_112;
}
