//! The version of the interface.

use crate::scphd_status;

/// The version of this interface. It changes whenever a program that was compiled with another header would not work.
pub const SCPHD_ABI_VERSION: u32 = 5;

/// The interface version of the library; `SCPHD_ABI_VERSION` is that of the header.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_abi_version() -> u32 {
    SCPHD_ABI_VERSION
}

/// Fails if the caller's header is of another version.
pub(crate) fn check(of_header: u32) -> Result<(), scphd_status> {
    if of_header == SCPHD_ABI_VERSION { Ok(()) } else { Err(scphd_status::WrongVersion) }
}
