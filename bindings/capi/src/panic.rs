//! The panic handler of the archive. No panic is reachable: where one were, the archive would ask for a function that does not exist, and
//! `cargo xtask capi` would find it.

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
