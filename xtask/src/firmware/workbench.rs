//! Folders to build images in, as many as there are cores: linking one keeps a single core busy for most of its time.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread;

use crate::process;
use crate::toolchain::Toolchain;

/// Numbers of the folders that something is being built in.
static TAKEN: Mutex<BTreeSet<usize>> = Mutex::new(BTreeSet::new());
static GIVEN_BACK: Condvar = Condvar::new();

/// A number that nobody else has, until it is dropped.
struct Number(usize);

impl Number {
    /// The least that is free, so that one build after the other is in the same folder and finds what the one before it has left.
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

/// Does `work` with a folder in which nothing else is built meanwhile.
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
    fn no_two_have_one_number() {
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
