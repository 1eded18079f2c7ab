//! Counts the iterations of loops whose bound depends on data, so that tests can compare them with the bound, and fail if a loop
//! does not end. Only in tests. `docs/performance.md` states the bounds.

#[cfg(test)]
pub(crate) use counted::{limited, round};

/// Marks an iteration of such a loop.
#[cfg(not(test))]
#[inline(always)]
pub(crate) fn round() {}

#[cfg(test)]
mod counted {
    use core::cell::Cell;

    std::thread_local! {
        static ROUNDS: Cell<u64> = const { Cell::new(0) };
        static LIMIT: Cell<u64> = const { Cell::new(u64::MAX) };
    }

    /// Counts an iteration of such a loop; panics beyond the limit of this thread.
    pub(crate) fn round() {
        let rounds = ROUNDS.get() + 1;
        ROUNDS.set(rounds);
        assert!(rounds <= LIMIT.get(), "a loop goes on beyond its bound of {} rounds", LIMIT.get());
    }

    /// Returns the result of `work` and its number of iterations, which must be at most `limit`.
    pub(crate) fn limited<R>(limit: u64, work: impl FnOnce() -> R) -> (R, u64) {
        ROUNDS.set(0);
        LIMIT.set(limit);
        let result = work();
        LIMIT.set(u64::MAX);
        (result, ROUNDS.get())
    }
}
