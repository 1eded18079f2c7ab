//! Counts cycles on a board and instructions in QEMU.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DWT, SYST};

/// SysTick counts down from here.
const RELOAD: u32 = 0x00ff_ffff;

/// How often SysTick has started over.
static ROUNDS: AtomicU32 = AtomicU32::new(0);

/// A clock that counts up, if with a step of several instructions in QEMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Cycles, by the unit that boards have for it.
    Dwt,
    /// Ticks of SysTick: QEMU has no cycle counter, but with `-icount shift=0` its time is that of the instructions.
    SysTick,
}

impl Clock {
    /// Starts the cycle counter or, where it does not count, SysTick.
    #[must_use]
    pub fn start(peripherals: &mut Peripherals) -> Self {
        peripherals.DCB.enable_trace();
        peripherals.DWT.enable_cycle_counter();
        let before = DWT::cycle_count();
        cortex_m::asm::delay(16);
        if DWT::cycle_count() != before {
            return Self::Dwt;
        }
        let timer = &mut peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        // It stands at zero until its first tick, as it does at the end of a round. One that does not tick is not waited for.
        for _ in 0..RELOAD {
            if SYST::get_current() != 0 {
                break;
            }
        }
        Self::SysTick
    }

    /// The time now; only differences mean something. Cycles come around every 2³² of them.
    #[must_use]
    pub fn now(self) -> u64 {
        match self {
            Self::Dwt => u64::from(DWT::cycle_count()),
            // Twice at most: a second round cannot end at once after a first.
            Self::SysTick => loop {
                let rounds = ROUNDS.load(Ordering::Relaxed);
                let left = SYST::get_current();
                // A round that ends between the two would count for nothing or twice.
                if rounds == ROUNDS.load(Ordering::Relaxed) {
                    break u64::from(rounds) * (u64::from(RELOAD) + 1) + u64::from(RELOAD - left);
                }
            },
        }
    }

    /// The time since `then`.
    #[must_use]
    pub fn since(self, then: u64) -> u64 {
        match self {
            Self::Dwt => u64::from(DWT::cycle_count().wrapping_sub(then as u32)),
            Self::SysTick => self.now() - then,
        }
    }

    /// What the clock counts while [`LOOP_INSTRUCTIONS`] instructions run.
    #[must_use]
    pub fn of_known_loop(self) -> u64 {
        let then = self.now();
        // SAFETY: counts a register down to zero, touches nothing else.
        unsafe {
            core::arch::asm!("2: subs {n}, {n}, #1", "bne 2b", n = inout(reg) LOOP_INSTRUCTIONS / 2 => _,
                options(nomem, nostack));
        }
        self.since(then)
    }

    /// Its name in the report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Dwt => "dwt",
            Self::SysTick => "systick",
        }
    }
}

/// Instructions of the loop that tells how many of them a tick is.
pub const LOOP_INSTRUCTIONS: u32 = 2_000_000;

/// To be called by the image's SysTick handler.
pub fn round() {
    // One core, and nothing else writes.
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}
