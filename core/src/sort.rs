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

#[cfg(test)]
mod tests {
    use super::heap_sort;
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
}
