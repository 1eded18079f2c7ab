//! Replays a stream in double precision and reports every scan.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use defmt_semihosting as _;
use scphd_firmware::{clock, images, report};
use scphd_stream::{Memory, memory};
use static_cell::ConstStaticCell;

/// The filter: all zero, so that it takes no flash.
static MEMORY: ConstStaticCell<Memory<f64>> = ConstStaticCell::new(memory());

#[entry]
fn main() -> ! {
    images::replay_and_report(MEMORY.try_take())
}

#[exception]
fn SysTick() {
    clock::round();
}

#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    report::fault()
}

#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    report::panicked()
}
