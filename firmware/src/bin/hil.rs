//! The target of `scphd-sim hil`: receives a stream over the serial port, record by record, runs the filter of a black box on it,
//! and answers with pose, covariance, digest and cost. With the feature `joint` the filter is the joint map. Links only if no
//! panic is reachable.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use cortex_m::Peripherals;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use scphd_firmware::clock::{Clock, LOOP_INSTRUCTIONS, round};
use scphd_firmware::uart::{self, Uart};
use scphd_link::{Gaps, Target, Unit};
#[cfg(not(feature = "joint"))]
use scphd_stream::planar::BlackBox as Kind;
#[cfg(feature = "joint")]
use scphd_stream::planar::BlackBoxJoint as Kind;
use scphd_stream::{Aboard, Monitor, ScanCost, Seen};
use static_cell::ConstStaticCell;

/// Greatest size of a frame, bytes: a map of a hundred features.
const IN: usize = 8192;
/// Greatest size of an answer, bytes.
const OUT: usize = 256;

static MEMORY: ConstStaticCell<<Kind as Aboard<f32>>::Memory> = ConstStaticCell::new(<Kind as Aboard<f32>>::MEMORY);
static TARGET: ConstStaticCell<Target<IN, OUT>> = ConstStaticCell::new(Target::new(Gaps::Refused));

/// Measures the time, in cycles on a board and in instructions in an emulator.
struct Watch {
    clock: Clock,
    started: u64,
    /// Ticks of the clock during a loop with a known number of instructions.
    ticks: u64,
}

impl Watch {
    fn start(peripherals: &mut Peripherals) -> Self {
        let clock = Clock::start(peripherals);
        Self { clock, started: 0, ticks: clock.of_known_loop().max(1) }
    }

    fn unit(&self) -> Unit {
        match self.clock {
            Clock::Dwt => Unit::Cycles,
            Clock::SysTick => Unit::Instructions,
        }
    }
}

impl Monitor for Watch {
    fn start(&mut self) {
        self.started = self.clock.now();
    }

    fn elapsed(&mut self) -> u64 {
        let elapsed = self.clock.since(self.started);
        match self.clock {
            Clock::Dwt => elapsed,
            Clock::SysTick => elapsed.saturating_mul(u64::from(LOOP_INSTRUCTIONS)) / self.ticks.max(1),
        }
    }

    fn scanned(&mut self, _: &ScanCost, _: &Seen, _: u64) {}
}

#[entry]
fn main() -> ! {
    if let (Some(memory), Some(target), Some(mut peripherals)) =
        (MEMORY.try_take(), TARGET.try_take(), Peripherals::take())
    {
        let mut watch = Watch::start(&mut peripherals);
        let mut line = Uart::start(&mut peripherals.NVIC);
        // The loop ends only with the serial line, which has no end.
        let _ = target.serve::<Kind, f32, _>(&mut line, memory, watch.unit(), &mut watch);
    }
    loop {
        cortex_m::asm::wfi();
    }
}

#[exception]
fn SysTick() {
    round();
}

#[exception]
unsafe fn DefaultHandler(irq: i16) {
    if irq == uart::IRQ {
        uart::received();
    }
}

#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

unsafe extern "C" {
    safe fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    a_panic_is_reachable()
}
