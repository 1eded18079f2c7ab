//! The boards' eight lights, as output pins. They can be read back, so that an interrupt can determine the present stage of a
//! scan, as a logic analyser would.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use scphd::diagnostics::Stage;

/// The register of the lights, in the system controller.
const LIGHTS: *mut u32 = 0x4002_f004 as *mut u32;

/// A light.
#[derive(Debug)]
pub struct Led {
    bit: u32,
}

impl Led {
    /// The lights of the five stages of a scan, in order.
    ///
    /// # Safety
    /// Must be called once, and the lights must stay in one task: switching a light reads and writes the register of all.
    pub unsafe fn of_stages() -> [Self; 5] {
        Stage::ALL.map(|stage| Self { bit: 1 << stage as u32 })
    }
}

impl ErrorType for Led {
    type Error = Infallible;
}

impl OutputPin for Led {
    fn set_low(&mut self) -> Result<(), Infallible> {
        // SAFETY: a register of the board that only one task writes.
        unsafe { LIGHTS.write_volatile(LIGHTS.read_volatile() & !self.bit) };
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        // SAFETY: as above.
        unsafe { LIGHTS.write_volatile(LIGHTS.read_volatile() | self.bit) };
        Ok(())
    }
}

/// The stage shown by the lights, the inner one of nested stages; `None` between scans.
pub fn stage() -> Option<Stage> {
    // SAFETY: a register of the board; reading it has no side effects.
    let lights = unsafe { LIGHTS.read_volatile() };
    Stage::ALL.into_iter().rev().find(|&stage| lights & 1 << stage as u32 != 0)
}
