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
