//! Sorting in bounded time without recursion, memory or a panic.

/// Distances at which items are compared, largest first (M. Ciura 2001).
const GAPS: [usize; 10] = [3690, 1636, 701, 301, 132, 57, 23, 10, 4, 1];

/// Sorts in place so that no item `comes_before` its predecessor: Shell's sort, which for the few hundred items of a map takes
/// half as many steps as a heap, about n^(4/3) at worst. Not stable, so that `comes_before` must tell any two items apart
/// whose order matters.
///
/// The standard library's unstable sort may panic where the order is not total.
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

/// Buckets of a [`bucket_sort`].
pub(crate) const BUCKETS: usize = 256;

/// Writes `items` to `sorted`, which must be as long, in the order of their buckets, below [`BUCKETS`]; within a bucket they stay in
/// the order they came in. Linear.
pub(crate) fn bucket_sort<I: Copy>(
    items: impl Iterator<Item = I> + Clone,
    bucket: impl Fn(&I) -> usize,
    sorted: &mut [I],
) {
    let mut next = [0_u16; BUCKETS];
    for item in items.clone() {
        if let Some(count) = next.get_mut(bucket(&item)) {
            *count += 1;
        }
    }
    let mut sum = 0;
    for place in &mut next {
        let count = *place;
        *place = sum;
        sum += count;
    }
    for item in items {
        let Some(place) = next.get_mut(bucket(&item)) else { continue };
        if let Some(slot) = sorted.get_mut(usize::from(*place)) {
            *slot = item;
        }
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{BUCKETS, bucket_sort, shell_sort};
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
    fn buckets_come_in_order_and_keep_theirs() {
        let items: Vec<(usize, usize)> = (0..300_usize).map(|k| (k * 7919 % BUCKETS, k)).collect();
        let mut sorted = items.clone();
        bucket_sort(items.iter().copied(), |item| item.0, &mut sorted);
        let mut expected = items;
        expected.sort_by_key(|item| item.0);
        assert_eq!(sorted, expected);
    }
}
