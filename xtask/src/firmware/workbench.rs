//! Folders for building images, as many as there are cores, because linking an image uses one core.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread;

use crate::process;
use crate::toolchain::Toolchain;

/// Numbers of the folders in use.
static TAKEN: Mutex<BTreeSet<usize>> = Mutex::new(BTreeSet::new());
static GIVEN_BACK: Condvar = Condvar::new();

/// A number that is reserved until it is dropped.
struct Number(usize);

impl Number {
    /// The smallest free number, so that consecutive builds use the same folder and its build products.
    fn take() -> Self {
        let count = thread::available_parallelism().map_or(1, usize::from);
        let mut taken = TAKEN.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(number) = (0..count).find(|number| !taken.contains(number)) {
                taken.insert(number);
                return Self(number);
            }
            taken = GIVEN_BACK.wait(taken).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Drop for Number {
    fn drop(&mut self) {
        TAKEN.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
        GIVEN_BACK.notify_one();
    }
}

/// Calls `work` with a folder for its exclusive use.
pub fn with<R>(toolchain: &Toolchain, work: impl FnOnce(&Path) -> R) -> R {
    let number = Number::take();
    work(&folder(toolchain, number.0))
}

fn folder(toolchain: &Toolchain, number: usize) -> PathBuf {
    process::own_target_dir(&format!("firmware-{}-{number}", toolchain.key()))
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
            thread::yield_now();
            held.lock().unwrap().remove(&number.0);
        };
        assert!(process::side_by_side(&numbers, hold).is_ok());
    }
}
