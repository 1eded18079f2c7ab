//! A list of bounded length in descending order of a logarithm.

use crate::Real;

/// The elements with the greatest logarithms; of equal ones the earlier comes first.
pub(super) struct Best<E, T, const CAPACITY: usize> {
    list: [(E, T); CAPACITY],
    len: usize,
    most: usize,
}

impl<E: Copy, T: Real, const CAPACITY: usize> Best<E, T, CAPACITY> {
    /// An empty list for at most `most` elements; `none` fills the rest of the memory.
    pub(super) fn new(most: usize, none: E) -> Self {
        Self { list: [(none, T::NEG_INFINITY); CAPACITY], len: 0, most: most.min(CAPACITY) }
    }

    /// Adds an element whose logarithm is finite. Returns the logarithm of the one for which there is no room.
    pub(super) fn add(&mut self, element: E, ln: T) -> Option<T> {
        // Written so that NaN is left out.
        if !(ln > T::NEG_INFINITY && ln < T::INFINITY) {
            return None;
        }
        let place = self.all().iter().position(|&(_, other)| ln > other).unwrap_or(self.len);
        let full = self.len == self.most;
        self.len = (self.len + 1).min(self.most);
        let mut moved = (element, ln);
        for slot in self.all_mut().iter_mut().skip(place) {
            core::mem::swap(slot, &mut moved);
        }
        full.then_some(moved.1)
    }

    pub(super) fn shorten(&mut self, len: usize) {
        self.len = self.len.min(len);
    }

    pub(super) fn all(&self) -> &[(E, T)] {
        self.list.get(..self.len).unwrap_or(&[])
    }

    pub(super) fn all_mut(&mut self) -> &mut [(E, T)] {
        self.list.get_mut(..self.len).unwrap_or(&mut [])
    }
}
