//! Consistency of pool and tables, for tests.

use super::Maps;
use crate::{Dim, Packed, Real};
use std::vec;

/// Every page is held as often as its count says, and is free if and only if nobody holds it.
pub(crate) fn check<T: Real, const N: usize, const D: usize>(maps: &Maps<'_, T, N, D>, particles: usize)
where
    Dim<N>: Packed,
{
    let pool = &maps.pool;
    let mut holders = vec![0_u16; pool.capacity()];
    for map in 0..particles {
        maps.table.pages(map).iter().for_each(|id| holders[id.index()] += 1);
    }
    let used = holders.iter().filter(|&&count| count > 0).count();
    assert_eq!(pool.free(), pool.capacity() - used, "pages leaked or freed twice");
    for (index, &count) in holders.iter().enumerate() {
        assert_eq!(pool.reference_counts()[index], count, "page {index}");
    }
}
