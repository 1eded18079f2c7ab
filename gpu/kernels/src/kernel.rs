//! The entry points of the device.

use crate::room::{Filters, bytes};
use crate::size::{LargeMemory, Memory};
use crate::stages::{Stage, launches};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};

/// The place of this thread in a grid of one dimension.
fn place() -> usize {
    // SAFETY: they read registers of the thread.
    let [block, size, thread] = unsafe { [_block_idx_x(), _block_dim_x(), _thread_idx_x()] };
    block as usize * size as usize + thread as usize
}

/// The entry points of filters of one size: a launch each, and one that writes the [bytes](bytes) of what its buffers are made of, as this
/// module's compiler has laid it out.
macro_rules! kernels {
    ($module:ident, $size:ty, $prefix:literal,
        $($(#[$about:meta])* $list:ident {
            $($(#[$does:meta])* $stage:ident = $name:literal, $places:ident, $body:path;)+
        })+
    ) => {
        #[expect(non_snake_case, reason = "a kernel has the name of its launch")]
        mod $module {
            use super::*;

            $($(
                #[unsafe(export_name = concat!($prefix, $name))]
                unsafe extern "ptx-kernel" fn $stage(filters: *const Filters<$size>, scan: u32, digest_every: u32) {
                    // SAFETY: the caller's word, as of `Stage::run`; every thread of a grid has a place of its own.
                    unsafe { const { Stage::<$size>::$stage }.run(place(), &*filters, scan, digest_every) }
                }
            )+)+

            #[unsafe(export_name = concat!($prefix, "bytes"))]
            unsafe extern "ptx-kernel" fn write_bytes(to: *mut [u64; 7]) {
                if place() == 0 {
                    // SAFETY: the caller's word that the pointer leads to as many numbers, and one thread alone writes.
                    unsafe { to.write(bytes::<$size>()) };
                }
            }
        }
    };
}

launches!(kernels! { many, Memory, "scphd_many_", });
launches!(kernels! { large, LargeMemory, "scphd_large_", });

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable: where one were, the module would need a function that is nowhere.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
