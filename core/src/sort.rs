//! Sorting in bounded time without recursion, memory or a panic.

/// Sorts in place so that no item `comes_before` its predecessor: heapsort, O(n log n) at worst. Not stable, so that
/// `comes_before` must tell any two items apart whose order matters.
///
/// The standard library's unstable sort may panic where the order is not total.
pub(crate) fn heap_sort<I: Copy>(items: &mut [I], comes_before: impl Fn(&I, &I) -> bool) {
    let len = items.len();
    for root in (0..len / 2).rev() {
        sift_down(items, root, &comes_before);
    }
    for end in (1..len).rev() {
        swap(items, 0, end);
        if let Some(heap) = items.get_mut(..end) {
            sift_down(heap, 0, &comes_before);
        }
    }
}

/// Restores the heap below `root`, where the parent of no item comes before it.
fn sift_down<I: Copy>(heap: &mut [I], mut root: usize, comes_before: &impl Fn(&I, &I) -> bool) {
    loop {
        let left = 2 * root + 1;
        let (Some(&item), Some(&left_item)) = (heap.get(root), heap.get(left)) else { return };
        let (child, child_item) = match heap.get(left + 1) {
            Some(&right_item) if comes_before(&left_item, &right_item) => (left + 1, right_item),
            _ => (left, left_item),
        };
        if !comes_before(&item, &child_item) {
            return;
        }
        swap(heap, root, child);
        root = child;
    }
}

/// The standard library's swap has a panic that the compiler cannot always see to be out of reach.
fn swap<I: Copy>(items: &mut [I], a: usize, b: usize) {
    let (Some(&first), Some(&second)) = (items.get(a), items.get(b)) else { return };
    if let Some(slot) = items.get_mut(a) {
        *slot = second;
    }
    if let Some(slot) = items.get_mut(b) {
        *slot = first;
    }
}

/// Buckets of a [`bucket_sort`].
pub(crate) const BUCKETS: usize = 256;

/// Where the items of every bucket begin in the sorted order, and past the last one its length.
pub(crate) type Starts = [u16; BUCKETS + 1];

/// Writes `items` to `sorted`, which must be as long, in the order of their buckets, below [`BUCKETS`]; within a bucket they stay in
/// the order they came in. Linear.
pub(crate) fn bucket_sort<I: Copy>(
    items: impl Iterator<Item = I> + Clone,
    bucket: impl Fn(&I) -> usize,
    sorted: &mut [I],
) -> Starts {
    let mut starts = [0; BUCKETS + 1];
    for item in items.clone() {
        if let Some(count) = starts.get_mut(bucket(&item) + 1) {
            *count += 1;
        }
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    let mut next = starts;
    for item in items {
        let Some(place) = next.get_mut(bucket(&item)) else { continue };
        if let Some(slot) = sorted.get_mut(usize::from(*place)) {
            *slot = item;
        }
        *place += 1;
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::{BUCKETS, bucket_sort, heap_sort};
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
            heap_sort(&mut items, |a, b| a < b);
            assert_eq!(items, expected);
        }
    }

    #[test]
    fn buckets_come_in_order_and_keep_theirs() {
        let items: Vec<(usize, usize)> = (0..300_usize).map(|k| (k * 7919 % BUCKETS, k)).collect();
        let mut sorted = items.clone();
        let starts = bucket_sort(items.iter().copied(), |item| item.0, &mut sorted);
        let mut expected = items;
        expected.sort_by_key(|item| item.0);
        assert_eq!(sorted, expected);
        assert_eq!((starts[0], starts[BUCKETS]), (0, 300));
        for (bucket, pair) in starts.windows(2).enumerate() {
            assert!(sorted[usize::from(pair[0])..usize::from(pair[1])].iter().all(|item| item.0 == bucket));
        }
    }
}
