//! Another Rust archive with a panic handler of its own, as a firmware may have.
#![no_std]

/// A division, which panics if the divisor is zero.
#[unsafe(no_mangle)]
pub extern "C" fn other_share(all: u32, parts: u32) -> u32 {
    all / parts
}

#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
