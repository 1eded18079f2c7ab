//! Reports a replay over defmt, scan by scan.

use crate::clock::Clock;
use scphd::diagnostics::{Probe, Stage};
use scphd_stream::{Monitor, ScanCost, Seen};

/// Exit code of a program that failed; QEMU passes it on.
const FAILED: i32 = 1;
/// Exit code after a processor fault.
const FAULT: i32 = 102;
/// Exit code after a panic.
const PANIC: i32 = 101;

/// Number of stages of a scan.
const STAGES: usize = Stage::ALL.len();

/// Measures the time, and prints every scan.
#[derive(Debug)]
pub struct Report {
    clock: Clock,
    started: u64,
    stages: StageClock,
}

/// Sums the time of every stage of a scan.
#[derive(Debug)]
struct StageClock {
    clock: Clock,
    entered: [u64; STAGES],
    spent: [u64; STAGES],
}

impl Probe for StageClock {
    fn enter(&mut self, stage: Stage) {
        if let Some(entered) = self.entered.get_mut(stage as usize) {
            *entered = self.clock.now();
        }
    }

    fn leave(&mut self, stage: Stage) {
        if let (Some(&entered), Some(spent)) = (self.entered.get(stage as usize), self.spent.get_mut(stage as usize)) {
            *spent += self.clock.since(entered);
        }
    }
}

impl Report {
    /// A report with this clock.
    pub fn new(clock: Clock) -> Self {
        let stages = StageClock { clock, entered: [0; STAGES], spent: [0; STAGES] };
        Self { clock, started: 0, stages }
    }
}

impl Monitor for Report {
    fn start(&mut self) {
        self.started = self.clock.now();
    }

    fn elapsed(&mut self) -> u64 {
        self.clock.since(self.started)
    }

    fn probe(&mut self) -> impl Probe {
        &mut self.stages
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
        let [predict, weigh, resample, update, reduce] = core::mem::replace(&mut self.stages.spent, [0; STAGES]);
        defmt::println!(
            "stages {=u32} predict {=u64} weigh {=u64} resample {=u64} update {=u64} reduce {=u64}",
            cost.scan,
            predict,
            weigh,
            resample,
            // The stage of updates includes that of reductions.
            update.saturating_sub(reduce),
            reduce,
        );
    }
}

/// Ends the program after success.
pub fn done() -> ! {
    semihosting::process::exit(0)
}

/// Ends the program after an error that was reported.
pub fn failed() -> ! {
    semihosting::process::exit(FAILED)
}

/// Ends the program after a processor fault, such as a stack overflow.
pub fn fault() -> ! {
    semihosting::process::exit(FAULT)
}

/// Ends the program after a panic.
pub fn panicked() -> ! {
    semihosting::process::exit(PANIC)
}
