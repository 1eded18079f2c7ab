//! Sorting in bounded time without recursion, additional memory or panics.

use crate::numerics::work;
use core::array::from_fn;

/// Gaps between compared items, largest first (M. Ciura 2001).
const GAPS: [usize; 10] = [3690, 1636, 701, 301, 132, 57, 23, 10, 4, 1];

/// Sorts in place so that no item `comes_before` its predecessor, with Shell's sort: for the some hundred items of a map it takes
/// half as many steps as a heap, about n^(4/3) in the worst case. It is not stable: `comes_before` must distinguish any two items
/// whose order matters.
///
/// The standard library's unstable sort may panic if the order is not total.
pub(crate) fn shell_sort<I: Copy>(items: &mut [I], comes_before: impl Fn(&I, &I) -> bool) {
    let len = items.len();
    for gap in GAPS.into_iter().filter(|&gap| gap < len) {
        for start in gap..len {
            let Some(&item) = items.get(start) else { break };
            let mut place = start;
            while let Some(before) = place.checked_sub(gap)
                && let Some(&other) = items.get(before)
                && comes_before(&item, &other)
            {
                work::round();
                if let Some(slot) = items.get_mut(place) {
                    *slot = other;
                }
                place = before;
            }
            if let Some(slot) = items.get_mut(place) {
                *slot = item;
            }
        }
    }
}

/// Number of buckets.
pub(crate) const BUCKETS: usize = 256;
const PER_ROW: usize = u32::BITS as usize;

/// A list of indices for every bucket, linked in the caller's memory. The cost is linear in the number of indices, independent of
/// empty buckets.
#[derive(Debug)]
pub(crate) struct Buckets {
    /// `None` without an occupied bucket.
    rows: [Option<Row>; BUCKETS / PER_ROW],
}

/// Consecutive buckets.
#[derive(Debug)]
struct Row {
    /// A bit for each bucket: whether it is occupied.
    occupied: u32,
    /// The first index of every occupied bucket.
    first: [u16; PER_ROW],
}

impl Buckets {
    #[inline]
    pub(crate) fn empty() -> Self {
        Self { rows: from_fn(|_| None) }
    }

    /// Inserts an index at the head of a bucket's list. Returns the next index in that list, if any.
    #[inline]
    pub(crate) fn push(&mut self, bucket: usize, place: u16) -> Option<u16> {
        let row = self.rows.get_mut(bucket / PER_ROW)?;
        let row = row.get_or_insert_with(|| Row { occupied: 0, first: [0; PER_ROW] });
        let first = row.first.get_mut(bucket % PER_ROW)?;
        let bit = 1 << (bucket % PER_ROW);
        let next = (row.occupied & bit != 0).then_some(*first);
        row.occupied |= bit;
        *first = place;
        next
    }

    /// Calls `visit` with the heads of all lists, in the order of the buckets.
    #[inline]
    pub(crate) fn heads(&self, mut visit: impl FnMut(u16)) {
        for row in self.rows.iter().flatten() {
            let mut left = row.occupied;
            while left != 0 {
                if let Some(&first) = row.first.get(left.trailing_zeros() as usize) {
                    visit(first);
                }
                left &= left - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BUCKETS, Buckets, shell_sort};
    use std::vec::Vec;

    #[test]
    fn sorts_like_the_standard_library() {
        let mut state = 1_u32;
        for len in 0..200 {
            let mut items: Vec<u32> = (0..len)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    state >> 25
                })
                .collect();
            let mut expected = items.clone();
            expected.sort_unstable();
            shell_sort(&mut items, |a, b| a < b);
            assert_eq!(items, expected);
        }
    }

    #[test]
    fn buckets_are_in_order_and_keep_the_order_of_insertion() {
        for count in [0, 1, 40, 300_usize] {
            let bucket = |place: usize| place * 7919 % BUCKETS;
            let mut buckets = Buckets::empty();
            let mut next = std::vec![None; count];
            for place in (0..count).rev() {
                next[place] = buckets.push(bucket(place), place as u16);
            }
            let list = |first| core::iter::successors(Some(first), |&place: &u16| next[usize::from(place)]);
            let mut found = Vec::new();
            buckets.heads(|first| found.extend(list(first)));
            let mut expected: Vec<u16> = (0..count as u16).collect();
            expected.sort_by_key(|&place| bucket(usize::from(place)));
            assert_eq!(found, expected);
        }
    }
}
