//! Results that several steps need and that one run makes once.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// What was made, or why it could not be made.
type Made<V> = Arc<OnceLock<Result<V, String>>>;

/// What was made so far, by key.
pub struct Once<K, V>(Mutex<BTreeMap<K, Made<V>>>);

impl<K: Ord, V: Clone> Once<K, V> {
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    /// The result for a key, which is made if it is needed for the first time. Who needs it while it is being made waits for it.
    pub fn get(&self, key: K, make: impl FnOnce() -> Result<V, String>) -> Result<V, String> {
        let place = Arc::clone(self.0.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default());
        place.get_or_init(make).clone()
    }
}
