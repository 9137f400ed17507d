//! The particles that share memory, a thread and a random stream: their columns, read or changed.

use crate::rng::BLOCK;

/// The particles of one block, read.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    pub(super) data: &'a [f64],
    pub(super) len: usize,
}

impl<'a> Block<'a> {
    /// How many particles.
    pub fn len(self) -> usize {
        self.len
    }

    /// Never: a block holds at least one particle.
    pub fn is_empty(self) -> bool {
        self.len == 0
    }

    /// Column `d` of the state, one value a particle.
    pub fn column(self, d: usize) -> &'a [f64] {
        &self.data[d * BLOCK..d * BLOCK + self.len]
    }

    /// Columns `d..d + K`.
    pub fn columns<const K: usize>(self, d: usize) -> [&'a [f64]; K] {
        std::array::from_fn(|k| self.column(d + k))
    }
}

/// The particles of one block, changed in place.
#[derive(Debug)]
pub struct BlockMut<'a> {
    pub(super) data: &'a mut [f64],
    pub(super) len: usize,
}

impl BlockMut<'_> {
    /// The same block, for a callee that takes it by value.
    pub fn reborrow(&mut self) -> BlockMut<'_> {
        BlockMut { data: self.data, len: self.len }
    }

    /// How many particles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Never: a block holds at least one particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Column `d` of the state.
    pub fn column_mut(&mut self, d: usize) -> &mut [f64] {
        &mut self.data[d * BLOCK..d * BLOCK + self.len]
    }

    /// The `K` columns named, in that order.
    ///
    /// # Panics
    /// When two are the same or one is not there.
    pub fn columns_mut<const K: usize>(&mut self, columns: [usize; K]) -> [&mut [f64]; K] {
        let len = self.len;
        let ranges = columns.map(|d| d * BLOCK..d * BLOCK + len);
        self.data.get_disjoint_mut(ranges).expect("columns differ and lie inside the block")
    }
}
