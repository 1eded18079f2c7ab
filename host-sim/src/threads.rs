//! The threads that weigh a filter's candidates.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::Arc;

/// A pool of threads as an executor of the filter; none of its own by default.
#[derive(Debug, Clone, Default)]
pub struct Threads(Option<Arc<ThreadPool>>);

impl Threads {
    /// As many threads; a single one is the caller's own.
    ///
    /// # Errors
    /// The system does not have them.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build());
        pool.transpose().map(|pool| Self(pool.map(Arc::new)))
    }
}

impl scphd::Executor for Threads {
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        match &self.0 {
            None => scphd::Serial.run(jobs, work),
            Some(pool) => pool.scope(|scope| {
                let work = &work;
                jobs.for_each(|job| scope.spawn(move |_| work(job)));
            }),
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
