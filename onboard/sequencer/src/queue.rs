//! Queue of inputs.

use crate::PushError;
use crate::stamp::Key;
use heapless::Vec;

#[derive(Debug)]
struct Entry<X> {
    key: Key,
    input: X,
}

/// At most `N` inputs with different keys, in the order of arrival. Every operation visits each once.
#[derive(Debug)]
pub(crate) struct Queue<X, const N: usize> {
    entries: Vec<Entry<X>, N>,
}

impl<X, const N: usize> Queue<X, N> {
    pub(crate) const fn new() -> Self {
        Self { entries: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }

    pub(crate) fn insert(&mut self, key: Key, input: X) -> Result<(), PushError> {
        if self.get(key).is_some() {
            return Err(PushError::Duplicate);
        }
        self.entries.push(Entry { key, input }).map_err(|_| PushError::Full)
    }

    /// The input with the least key.
    pub(crate) fn first(&self) -> Option<(Key, &X)> {
        self.after(None)
    }

    /// The input with the next greater key.
    pub(crate) fn after(&self, key: Option<Key>) -> Option<(Key, &X)> {
        let later = self.entries.iter().filter(|entry| key.is_none_or(|key| entry.key > key));
        later.min_by_key(|entry| entry.key).map(|entry| (entry.key, &entry.input))
    }

    pub(crate) fn get(&self, key: Key) -> Option<&X> {
        self.entries.iter().find(|entry| entry.key == key).map(|entry| &entry.input)
    }

    pub(crate) fn remove(&mut self, key: Key) {
        self.entries.retain(|entry| entry.key != key);
    }

    /// Removes all inputs later than this time. Returns their number.
    pub(crate) fn forget_after(&mut self, time: u64) -> usize {
        let before = self.entries.len();
        self.entries.retain(|entry| entry.key.time <= time);
        before.saturating_sub(self.entries.len())
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }
}

#[cfg(test)]
mod tests {
    use super::{Key, Queue};
    use crate::PushError;

    const fn key(time: u64, source: u8, number: u32) -> Key {
        Key { time, source, number }
    }

    #[test]
    fn inputs_come_out_by_time_then_source_then_number() {
        let mut queue = Queue::<char, 5>::new();
        for (key, input) in
            [(key(2, 0, 0), 'e'), (key(1, 1, 0), 'c'), (key(1, 0, 9), 'b'), (key(1, 0, 2), 'a'), (key(1, 1, 1), 'd')]
        {
            assert_eq!(queue.insert(key, input), Ok(()));
        }
        assert_eq!(queue.insert(key(1, 1, 0), 'x'), Err(PushError::Duplicate));
        assert_eq!(queue.insert(key(0, 0, 0), 'x'), Err(PushError::Full));
        for expected in ['a', 'b', 'c', 'd', 'e'] {
            let (first, &input) = queue.first().unwrap();
            assert_eq!(input, expected);
            queue.remove(first);
        }
        assert!(queue.first().is_none());
    }
}
