//! The boards' eight lights, as output pins. They can be read back, so that an interrupt sees which stage of a scan it is in,
//! as a logic analyser would.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use scphd::diagnostics::Stage;

/// The lights' register of the system controller.
const LIGHTS: *mut u32 = 0x4002_f004 as *mut u32;

/// One light.
#[derive(Debug)]
pub struct Led {
    bit: u32,
}

impl Led {
    /// The lights of the five stages of a scan, in their order.
    ///
    /// # Safety
    /// To be called once, and what comes of it stays in one task: to switch a light is to read and write the register of all.
    #[must_use]
    pub unsafe fn of_stages() -> [Self; 5] {
        Stage::ALL.map(|stage| Self { bit: 1 << stage as u32 })
    }
}

impl ErrorType for Led {
    type Error = Infallible;
}

impl OutputPin for Led {
    fn set_low(&mut self) -> Result<(), Infallible> {
        // SAFETY: a register of the board, which one task alone writes.
        unsafe { LIGHTS.write_volatile(LIGHTS.read_volatile() & !self.bit) };
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        // SAFETY: as above.
        unsafe { LIGHTS.write_volatile(LIGHTS.read_volatile() | self.bit) };
        Ok(())
    }
}

/// The stage that the lights show, the inner one of two; none between scans.
#[must_use]
pub fn stage() -> Option<Stage> {
    // SAFETY: a register of the board; reading it changes nothing.
    let lights = unsafe { LIGHTS.read_volatile() };
    Stage::ALL.into_iter().rev().find(|&stage| lights & 1 << stage as u32 != 0)
}
