//! Threads for weighing a filter's candidates and updating its maps.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder, Yield};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time for which a thread without work does not sleep: longer than the time between rounds of jobs within a scan. A round may be
/// shorter than the time to wake a sleeping thread.
const AWAKE: Duration = Duration::from_millis(1);

/// A pool of threads as an executor for the filter; the default has none.
#[derive(Debug, Clone, Default)]
pub struct Threads(Option<Arc<ThreadPool>>);

impl Threads {
    /// A pool with this number of threads, including the calling one.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads - 1).build());
        pool.transpose().map(|pool| Self(pool.map(Arc::new)))
    }

    /// Whether there is more than one.
    pub fn are_several(&self) -> bool {
        self.0.is_some()
    }
}

impl scphd::storage::Executor for Threads {
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        match &self.0 {
            None => scphd::storage::Serial.run(jobs, work),
            // Each free thread takes the next job: the caller immediately, the others when they are ready.
            Some(pool) => {
                let jobs = Mutex::new(jobs);
                let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
                let take_jobs = || std::iter::from_fn(next).for_each(&work);
                let others = AtomicUsize::new(pool.current_num_threads());
                pool.in_place_scope(|scope| {
                    for _ in 0..pool.current_num_threads() {
                        scope.spawn(|_| {
                            take_jobs();
                            // It ends as soon as it finds work, which is a part of the next round; after that round it is spawned
                            // again.
                            rayon::spawn(|| stay_awake_while(|| rayon::yield_now() == Some(Yield::Idle)));
                            others.fetch_sub(1, Ordering::Relaxed);
                        });
                    }
                    take_jobs();
                    stay_awake_while(|| others.load(Ordering::Relaxed) > 0);
                });
            }
        }
    }
}

/// Keeps the thread awake while it is idle, for a limited time.
fn stay_awake_while(is_idle: impl Fn() -> bool) {
    let since = Instant::now();
    while is_idle() && since.elapsed() < AWAKE {
        thread::yield_now();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::storage::Executor;

    /// Checks that a round does every job once.
    fn round(threads: &Threads) {
        let mut done = [0; 23];
        threads.run(done.iter_mut().enumerate(), |(index, slot)| *slot += index);
        assert!(done.iter().enumerate().all(|(index, &found)| found == index));
    }

    #[test]
    fn every_job_is_done_once() {
        for threads in [1, 2, 5].map(|threads| Threads::new(threads).unwrap()) {
            (0..100).for_each(|_| round(&threads));
            // The other threads are asleep by now.
            thread::sleep(3 * AWAKE);
            round(&threads);
        }
    }

    #[test]
    fn a_pool_serves_several_callers_and_its_own_threads() {
        for threads in [2, 3].map(|threads| Threads::new(threads).unwrap()) {
            thread::scope(|scope| {
                for _ in 0..4 {
                    let threads = threads.clone();
                    scope.spawn(move || (0..20).for_each(|_| threads.run(0..4, |_| round(&threads))));
                }
            });
        }
    }

    #[test]
    #[should_panic(expected = "a job fails")]
    fn a_failing_job_ends_the_round() {
        Threads::new(2).unwrap().run(0..8, |job| assert!(job < 5, "a job fails"));
    }
}
