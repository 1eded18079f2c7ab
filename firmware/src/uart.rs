//! The serial port of QEMU's boards: Arm's CMSDK UART. An interrupt receives bytes, so that none are lost while the filter runs.

use core::cell::RefCell;
use core::convert::Infallible;
use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::NVIC;
use embedded_io::{ErrorType, Read, Write};
use heapless::Deque;

/// Base address of the first UART, on mps2-an500 and mps2-an386.
const BASE: usize = 0x4000_4000;
const DATA: *mut u32 = BASE as *mut u32;
const STATE: *mut u32 = (BASE + 0x04) as *mut u32;
const CONTROL: *mut u32 = (BASE + 0x08) as *mut u32;
const INTERRUPT: *mut u32 = (BASE + 0x0c) as *mut u32;
const DIVIDER: *mut u32 = (BASE + 0x10) as *mut u32;

const TRANSMITTER_FULL: u32 = 1;
const RECEIVER_FULL: u32 = 2;
const BOTH_WAYS: u32 = 3;
const INTERRUPT_ON_RECEIPT: u32 = 8;
const RECEIVED: u32 = 2;

/// Number of the port's receive interrupt.
pub const IRQ: i16 = 0;
/// Capacity for received bytes: two scans with the maximum number of measurements.
const WAITING: usize = 2048;
/// Divider of 25 MHz for 115 200 baud.
const BAUD_DIVIDER: u32 = 217;

static ARRIVED: Mutex<RefCell<Deque<u8, WAITING>>> = Mutex::new(RefCell::new(Deque::new()));

/// The interrupt, for the NVIC.
#[derive(Debug, Clone, Copy)]
struct Interrupt;

// SAFETY: the boards have this interrupt, and the number does not change.
unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        IRQ as u16
    }
}

/// The port.
#[derive(Debug)]
pub struct Uart(());

impl Uart {
    /// Sets the port up, at 115 200 baud. The image must have an interrupt handler that calls [`received`].
    pub fn start(_nvic: &mut NVIC) -> Self {
        // SAFETY: registers of the board with one owner. The handler shares the queue only in critical sections.
        unsafe {
            DIVIDER.write_volatile(BAUD_DIVIDER);
            CONTROL.write_volatile(BOTH_WAYS | INTERRUPT_ON_RECEIPT);
            NVIC::unmask(Interrupt);
        }
        Self(())
    }
}

/// To be called by the image's handler of [`IRQ`]. Bytes beyond the capacity are lost; their frame is then reported as damaged.
pub fn received() {
    // SAFETY: registers of the board; reading the data removes the byte.
    unsafe {
        INTERRUPT.write_volatile(RECEIVED);
        while STATE.read_volatile() & RECEIVER_FULL != 0 {
            let byte = DATA.read_volatile() as u8;
            free(|token| {
                if let Ok(mut arrived) = ARRIVED.borrow(token).try_borrow_mut() {
                    let _ = arrived.push_back(byte);
                }
            });
        }
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Read for Uart {
    /// Waits until there is at least one byte.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let Some((first, _)) = buffer.split_first_mut() else { return Ok(0) };
        loop {
            let byte = free(|token| {
                let byte = ARRIVED.borrow(token).try_borrow_mut().ok().and_then(|mut arrived| arrived.pop_front());
                if byte.is_none() {
                    // An interrupt that arrives before this instruction is pending, and ends the wait at once.
                    cortex_m::asm::wfi();
                }
                byte
            });
            if let Some(byte) = byte {
                *first = byte;
                return Ok(1);
            }
        }
    }
}

impl Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            // SAFETY: registers of the board.
            unsafe {
                while STATE.read_volatile() & TRANSMITTER_FULL != 0 {}
                DATA.write_volatile(u32::from(byte));
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
