//! The interrupts of QEMU's boards mps2-an386 and mps2-an500 that the images use; otherwise part of a vendor's `-pac` crate.

use cortex_m::interrupt::InterruptNumber;

/// Number of priority bits of the boards' processors.
pub const NVIC_PRIO_BITS: u8 = 3;

/// Interrupt numbers, from Arm's application notes 386 and 500.
#[allow(non_camel_case_types)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// Receive interrupt of the third serial port. No image uses the port; the interrupt is pended by software.
    UART2_RX = 4,
    /// The first timer has expired.
    TIMER0 = 8,
    /// The second timer has expired.
    TIMER1 = 9,
    /// The dual timer. No image starts it; the interrupt is pended by software.
    DUAL_TIMER = 10,
}

/// The name that the attribute `interrupt` and RTIC expect.
pub use Interrupt as interrupt;
pub use cortex_m_rt::interrupt;

// SAFETY: the boards have these interrupts, and the numbers do not change.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    fn UART2_RX();
    fn TIMER0();
    fn TIMER1();
    fn DUAL_TIMER();
}

/// An entry of the vector table: the handler of an interrupt, or none.
type Handler = Option<unsafe extern "C" fn()>;

/// Number of entries.
const INTERRUPTS: usize = 32;

/// The board's part of the vector table, with the name and the section that `cortex-m-rt` expects.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [Handler; INTERRUPTS] = {
    let mut table: [Handler; INTERRUPTS] = [None; INTERRUPTS];
    table[Interrupt::UART2_RX as usize] = Some(UART2_RX);
    table[Interrupt::TIMER0 as usize] = Some(TIMER0);
    table[Interrupt::TIMER1 as usize] = Some(TIMER1);
    table[Interrupt::DUAL_TIMER as usize] = Some(DUAL_TIMER);
    table
};
