//! The entry points of the device.

use crate::room::{Filters, bytes};
use crate::size::{LargeMemory, Memory};
use crate::stages::{Stage, launches};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};

/// The index of this thread in a one-dimensional grid.
fn place() -> usize {
    // SAFETY: the functions read registers of the thread.
    let [block, size, thread] = unsafe { [_block_idx_x(), _block_dim_x(), _thread_idx_x()] };
    block as usize * size as usize + thread as usize
}

/// The entry points for filters of one size: one for each launch, and one that writes the [bytes](bytes) of the buffers' elements
/// as this module's compiler laid them out.
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
                    // SAFETY: the caller guarantees what `Stage::run` requires; every thread of a grid has its own place.
                    unsafe { const { Stage::<$size>::$stage }.run(place(), &*filters, scan, digest_every) }
                }
            )+)+

            #[unsafe(export_name = concat!($prefix, "bytes"))]
            unsafe extern "ptx-kernel" fn write_bytes(to: *mut [u64; 7]) {
                if place() == 0 {
                    // SAFETY: the caller guarantees that the pointer leads to that many numbers; only one thread writes.
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

/// No panic is reachable. Otherwise the module would need a function that is not defined anywhere.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
