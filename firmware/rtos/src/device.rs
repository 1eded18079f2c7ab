//! The interrupts of QEMU's boards mps2-an386 and mps2-an500, as far as the images need them: what a vendor's `-pac` crate has.

use cortex_m::interrupt::InterruptNumber;

/// Bits of an interrupt's priority that the boards' processors have.
pub const NVIC_PRIO_BITS: u8 = 3;

/// Interrupts by their numbers, of Arm's application notes 386 and 500.
#[allow(non_camel_case_types)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// A byte has come at the third serial port. No image has one: it is pended by software.
    UART2_RX = 4,
    /// The first timer has come to zero.
    TIMER0 = 8,
    /// The second one.
    TIMER1 = 9,
    /// The double timer. No image starts it: it is pended by software.
    DUAL_TIMER = 10,
}

/// By this name the attribute `interrupt` and RTIC look for them.
pub use Interrupt as interrupt;
pub use cortex_m_rt::interrupt;

// SAFETY: the boards have these, and the numbers do not change.
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

/// An entry of the table: an interrupt's handler, or nothing.
type Handler = Option<unsafe extern "C" fn()>;

/// How many entries the table has.
const INTERRUPTS: usize = 32;

/// The part of the table of vectors that belongs to the board. Its name and its place are those that `cortex-m-rt` expects.
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
