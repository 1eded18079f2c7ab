//! The panic handler of the archive. It calls a function that nobody defines, so that a reachable panic would be an unresolved
//! symbol in the archive, which `cargo xtask capi` would find.

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
