//! Another archive in Rust, as a firmware may have one: with a panic handler of its own.
#![no_std]

/// A division, which panics where there is nothing to divide by.
#[unsafe(no_mangle)]
pub extern "C" fn other_share(all: u32, parts: u32) -> u32 {
    all / parts
}

#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
