//! Folders for building images, as many as there are builds side by side.

use crate::{process, toolchain};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

static TAKEN: Mutex<BTreeSet<usize>> = Mutex::new(BTreeSet::new());

/// A number that is reserved until it is dropped.
struct Number(usize);

impl Number {
    /// The smallest free number, so that consecutive builds use the same folder and its build products.
    fn take() -> Self {
        let mut taken = TAKEN.lock().unwrap_or_else(PoisonError::into_inner);
        let number = (0..=taken.len()).find(|&number| taken.insert(number));
        Self(number.expect("one more number than are taken"))
    }
}

impl Drop for Number {
    fn drop(&mut self) {
        TAKEN.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
    }
}

/// Calls `work` with a folder for its exclusive use.
pub fn with<R>(work: impl FnOnce(&Path) -> Result<R, String>) -> Result<R, String> {
    let number = Number::take();
    work(&process::own_target_dir(&format!("firmware-{}-{}", toolchain::find()?.key(), number.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_use_are_unique() {
        let numbers: Vec<u32> = (0..40).collect();
        let held = Mutex::new(BTreeSet::new());
        let hold = |_: &u32| {
            let number = Number::take();
            assert!(held.lock().unwrap().insert(number.0), "{} twice", number.0);
            std::thread::yield_now();
            held.lock().unwrap().remove(&number.0);
            Ok(())
        };
        assert!(process::side_by_side(&numbers, hold).is_ok());
    }
}
