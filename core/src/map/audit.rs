//! Consistency of pool and tables, for tests.

use super::{MapTable, Pool};
use crate::{Dim, Packed, Real};
use std::vec;

/// Every page is held as often as its count says, and is free if and only if nobody holds it.
pub(crate) fn check<T: Real, const N: usize, const D: usize>(
    pool: &Pool<'_, T, N, D>,
    tables: &[(&MapTable<'_>, usize)],
) where
    Dim<N>: Packed,
{
    let mut holders = vec![0_u16; pool.capacity()];
    for (table, maps) in tables {
        for map in 0..*maps {
            table.pages(map).iter().for_each(|id| holders[id.index()] += 1);
        }
    }
    let used = holders.iter().filter(|&&count| count > 0).count();
    assert_eq!(pool.free(), pool.capacity() - used, "pages leaked or freed twice");
    for (index, &count) in holders.iter().enumerate() {
        assert_eq!(pool.reference_counts()[index], count, "page {index}");
    }
}
