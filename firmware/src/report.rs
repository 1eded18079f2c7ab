//! Tells over defmt what a replay does, scan by scan.

use crate::clock::Clock;
use scphd_stream::{Monitor, ScanCost, Seen};

/// The exit code of a program that failed, as QEMU passes it on.
const FAILED: i32 = 1;
/// The exit code after a fault of the processor.
const FAULT: i32 = 102;
/// The exit code after a panic.
const PANIC: i32 = 101;

/// Keeps the time, and prints every scan.
#[derive(Debug)]
pub struct Report {
    clock: Clock,
    started: u64,
}

impl Report {
    /// A report by this clock.
    #[must_use]
    pub fn new(clock: Clock) -> Self {
        Self { clock, started: 0 }
    }
}

impl Monitor for Report {
    fn start(&mut self) {
        self.started = self.clock.now();
    }

    fn elapsed(&mut self) -> u64 {
        self.clock.since(self.started)
    }

    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, digest: u64) {
        defmt::println!(
            "scan {=u32} measurements {=u32} predictions {=u32} in_view {=u32} maps {=u32} pages {=u32} \
             health {=u16:04x} digest {=u64:016x}",
            cost.scan,
            cost.measurements,
            cost.predictions,
            seen.in_view,
            seen.maps_updated,
            seen.pages_used,
            seen.health,
            digest,
        );
        defmt::println!(
            "cost {=u32} predict {=u64} worst {=u64} update {=u64} estimate {=u64}",
            cost.scan,
            cost.predict,
            cost.predict_worst,
            cost.update,
            cost.estimate,
        );
    }
}

/// Ends the program where it was to end.
pub fn done() -> ! {
    semihosting::process::exit(0)
}

/// Ends the program for a reason that has been told.
pub fn failed() -> ! {
    semihosting::process::exit(FAILED)
}

/// Ends the program after a fault of the processor, an overflow of the stack among them.
pub fn fault() -> ! {
    semihosting::process::exit(FAULT)
}

/// Ends the program after a panic.
pub fn panicked() -> ! {
    semihosting::process::exit(PANIC)
}
