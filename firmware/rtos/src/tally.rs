//! Counters of tasks with different priorities.

use crate::leds;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use scphd::diagnostics::Stage;

/// Counts that any task may read.
#[derive(Debug)]
pub struct Tally {
    /// Odometry interrupts in each stage of a scan, in the order of [`Stage::ALL`].
    preempted: [AtomicU32; Stage::ALL.len()],
    /// Greatest latency of an odometry interrupt, ticks.
    waited: AtomicU32,
    /// Greatest number of samples in the queue of odometry.
    deepest: AtomicU32,
    /// Odometry samples that were lost because the queue was full.
    lost_odometry: AtomicU32,
    /// Scans that were lost because the queue was full.
    lost_scans: AtomicU32,
    /// Whether the last scan has arrived.
    ended: AtomicBool,
}

/// The counters of the image.
pub static TALLY: Tally = Tally {
    preempted: [const { AtomicU32::new(0) }; Stage::ALL.len()],
    waited: AtomicU32::new(0),
    deepest: AtomicU32::new(0),
    lost_odometry: AtomicU32::new(0),
    lost_scans: AtomicU32::new(0),
    ended: AtomicBool::new(false),
};

impl Tally {
    /// Counts an odometry interrupt, with the latency of its task, ticks.
    pub fn interrupted(&self, waited: u32) {
        self.waited.fetch_max(waited, Ordering::Relaxed);
        if let Some(count) = leds::stage().and_then(|stage| self.preempted.get(stage as usize)) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Records the number of samples in the queue of odometry.
    pub fn waiting(&self, samples: usize) {
        self.deepest.fetch_max(samples as u32, Ordering::Relaxed);
    }

    /// Counts a lost odometry sample.
    pub fn lost_odometry(&self) {
        self.lost_odometry.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a lost scan.
    pub fn lost_scan(&self) {
        self.lost_scans.fetch_add(1, Ordering::Relaxed);
    }

    /// Numbers of lost odometry samples and scans.
    pub fn lost(&self) -> (u32, u32) {
        (self.lost_odometry.load(Ordering::Relaxed), self.lost_scans.load(Ordering::Relaxed))
    }

    /// Numbers of odometry interrupts in each stage of a scan.
    pub fn preempted(&self) -> [u32; Stage::ALL.len()] {
        self.preempted.each_ref().map(|count| count.load(Ordering::Relaxed))
    }

    /// Greatest latency of an odometry interrupt, ticks, and greatest number of samples in its queue.
    pub fn worst(&self) -> (u32, u32) {
        (self.waited.load(Ordering::Relaxed), self.deepest.load(Ordering::Relaxed))
    }

    /// Records that the last scan has arrived.
    pub fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Whether the last scan has arrived.
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }
}
