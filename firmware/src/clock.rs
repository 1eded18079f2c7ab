//! Counts cycles on a board and instructions in QEMU.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DWT, SYST};

/// Start value of SysTick, which counts down.
const RELOAD: u32 = 0x00ff_ffff;

/// Number of times that SysTick has wrapped around.
static ROUNDS: AtomicU32 = AtomicU32::new(0);

/// A clock that counts up; in QEMU its resolution is several instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Cycles of the DWT unit, on boards.
    Dwt,
    /// Ticks of SysTick: QEMU has no cycle counter, but with `-icount shift=0` its time is the number of instructions.
    SysTick,
}

impl Clock {
    /// Starts the cycle counter or, if it does not count, SysTick.
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
        // SysTick is zero until its first tick. The wait is bounded, in case it does not tick.
        for _ in 0..RELOAD {
            if SYST::get_current() != 0 {
                break;
            }
        }
        Self::SysTick
    }

    /// The present time; only differences are meaningful. Cycles wrap around after 2³².
    pub fn now(self) -> u64 {
        match self {
            Self::Dwt => u64::from(DWT::cycle_count()),
            // At most two iterations: a wrap-around cannot follow directly after another.
            Self::SysTick => loop {
                let rounds = ROUNDS.load(Ordering::Relaxed);
                let left = SYST::get_current();
                // A wrap-around between the two reads would be missed or counted twice.
                if rounds == ROUNDS.load(Ordering::Relaxed) {
                    break u64::from(rounds) * (u64::from(RELOAD) + 1) + u64::from(RELOAD - left);
                }
            },
        }
    }

    /// The time since `then`.
    pub fn since(self, then: u64) -> u64 {
        match self {
            Self::Dwt => u64::from(DWT::cycle_count().wrapping_sub(then as u32)),
            Self::SysTick => self.now() - then,
        }
    }

    /// Ticks of the clock during [`LOOP_INSTRUCTIONS`] instructions.
    pub fn of_known_loop(self) -> u64 {
        let then = self.now();
        // SAFETY: decrements a register to zero; no other effect.
        unsafe {
            core::arch::asm!("2: subs {n}, {n}, #1", "bne 2b", n = inout(reg) LOOP_INSTRUCTIONS / 2 => _,
                options(nomem, nostack));
        }
        self.since(then)
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dwt => "dwt",
            Self::SysTick => "systick",
        }
    }
}

/// Number of instructions of the loop that determines the duration of a tick.
pub const LOOP_INSTRUCTIONS: u32 = 2_000_000;

/// Counts a wrap-around; to be called by the image's SysTick handler.
pub fn round() {
    // There is one core and no other writer.
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}
