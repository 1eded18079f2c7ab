//! The threads that weigh a filter's candidates and update its maps.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// A pool of threads as an executor of the filter; none of its own by default.
#[derive(Debug, Clone, Default)]
pub struct Threads(Option<Arc<ThreadPool>>);

impl Threads {
    /// As many threads, of which one is the caller's own.
    ///
    /// # Errors
    /// The system does not have them.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads - 1).build());
        pool.transpose().map(|pool| Self(pool.map(Arc::new)))
    }

    /// Whether there is more than one.
    #[must_use]
    pub fn are_several(&self) -> bool {
        self.0.is_some()
    }
}

impl scphd::Executor for Threads {
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        match &self.0 {
            None => scphd::Serial.run(jobs, work),
            // Whoever is free takes the next job: the caller at once, the others as they wake.
            Some(pool) => {
                let jobs = Mutex::new(jobs);
                let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
                let take_jobs = || std::iter::from_fn(next).for_each(&work);
                pool.in_place_scope(|scope| {
                    (0..pool.current_num_threads()).for_each(|_| scope.spawn(|_| take_jobs()));
                    take_jobs();
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::Executor;

    #[test]
    fn every_job_is_done_once() {
        for threads in [1, 2, 5] {
            let mut done = [0; 23];
            Threads::new(threads).unwrap().run(done.iter_mut().enumerate(), |(index, slot)| *slot += index);
            assert!(done.iter().enumerate().all(|(index, &found)| found == index));
        }
    }
}
