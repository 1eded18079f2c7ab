//! What tasks of different priorities count.

use crate::leds;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use scphd::diagnostics::Stage;

/// Counts that any task may read.
#[derive(Debug)]
pub struct Tally {
    /// Odometry interrupts in each stage of a scan, in the order of [`Stage::ALL`].
    preempted: [AtomicU32; Stage::ALL.len()],
    /// The longest that an odometry interrupt has waited for its task, ticks.
    waited: AtomicU32,
    /// The most that has waited in the queue of odometry.
    deepest: AtomicU32,
    /// Odometry samples for which there was no room.
    lost_odometry: AtomicU32,
    /// Scans for which there was no room.
    lost_scans: AtomicU32,
    /// Whether the last scan has arrived.
    ended: AtomicBool,
}

/// The counts of this image.
pub static TALLY: Tally = Tally {
    preempted: [const { AtomicU32::new(0) }; Stage::ALL.len()],
    waited: AtomicU32::new(0),
    deepest: AtomicU32::new(0),
    lost_odometry: AtomicU32::new(0),
    lost_scans: AtomicU32::new(0),
    ended: AtomicBool::new(false),
};

impl Tally {
    /// An odometry interrupt came, and its task began so many ticks later.
    pub fn interrupted(&self, waited: u32) {
        self.waited.fetch_max(waited, Ordering::Relaxed);
        if let Some(count) = leds::stage().and_then(|stage| self.preempted.get(stage as usize)) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// So many samples wait in the queue of odometry.
    pub fn waiting(&self, samples: usize) {
        self.deepest.fetch_max(samples as u32, Ordering::Relaxed);
    }

    /// There was no room for an odometry sample.
    pub fn lost_odometry(&self) {
        self.lost_odometry.fetch_add(1, Ordering::Relaxed);
    }

    /// There was no room for a scan.
    pub fn lost_scan(&self) {
        self.lost_scans.fetch_add(1, Ordering::Relaxed);
    }

    /// Whether something was lost so far: odometry samples, scans.
    #[must_use]
    pub fn lost(&self) -> (u32, u32) {
        (self.lost_odometry.load(Ordering::Relaxed), self.lost_scans.load(Ordering::Relaxed))
    }

    /// How often odometry has interrupted each stage of a scan.
    #[must_use]
    pub fn preempted(&self) -> [u32; Stage::ALL.len()] {
        self.preempted.each_ref().map(|count| count.load(Ordering::Relaxed))
    }

    /// The longest that an odometry interrupt has waited, ticks, and the most that has waited in its queue.
    #[must_use]
    pub fn worst(&self) -> (u32, u32) {
        (self.waited.load(Ordering::Relaxed), self.deepest.load(Ordering::Relaxed))
    }

    /// The last scan has arrived.
    pub fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Whether it has.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }
}
