//! The entry points of the device.

use crate::joint::{HELPERS, Joint, help};
use crate::room::{Filters, bytes};
use crate::size::{LargeMemory, Memory};
use crate::stages::{Places, Stage, joint_launches, launches};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};

/// The block of this thread, the threads of a block, and the index of the thread in it.
fn position() -> [usize; 3] {
    // SAFETY: the functions read registers of the thread.
    unsafe { [_block_idx_x(), _block_dim_x(), _thread_idx_x()] }.map(|number| number as usize)
}

/// The index of this thread in a one-dimensional grid.
fn place() -> usize {
    let [block, size, thread] = position();
    block * size + thread
}

/// The entry points for filters of one kind: one for each launch, and one that writes the [bytes](bytes) of the buffers' elements
/// as this module's compiler laid them out.
macro_rules! kernels {
    ($module:ident, $kind:ty, $prefix:literal,
        $({ $($file:ident::$body:ident $places:ident;)* })+
    ) => {
        mod $module {
            use super::*;

            $($(
                #[unsafe(export_name = concat!($prefix, stringify!($body)))]
                unsafe extern "ptx-kernel" fn $body(filters: *const Filters<$kind>, scan: u32, digest_every: u32) {
                    // SAFETY: the caller guarantees what `Stage::run` requires; every thread of a grid has its own place, and a
                    // leader has helpers in its block.
                    unsafe {
                        const STAGE: Stage<$kind> =
                            Stage { name: "", places: Places::$places, body: crate::$file::$body };
                        threads!($places, STAGE, &*filters, scan, digest_every);
                    }
                }
            )*)+

            #[unsafe(export_name = concat!($prefix, "bytes"))]
            unsafe extern "ptx-kernel" fn write_bytes(to: *mut [u64; 7]) {
                if place() == 0 {
                    // SAFETY: the caller guarantees that the pointer leads to that many numbers; only one thread writes.
                    unsafe { to.write(bytes::<$kind>()) };
                }
            }
        }
    };
}

/// What one thread of a launch does.
macro_rules! threads {
    (Leader, $stage:expr, $filters:expr, $scan:ident, $digest_every:ident) => {{
        let ([block, _, thread], filters) = (position(), $filters);
        if (block as u64) < filters.count {
            if thread < HELPERS {
                help(thread, &filters.group(block));
            } else {
                $stage.run(block, filters, $scan, $digest_every);
            }
        }
    }};
    ($places:ident, $stage:expr, $filters:expr, $scan:ident, $digest_every:ident) => {
        $stage.run(place(), $filters, $scan, $digest_every)
    };
}

launches!(kernels! { many, Memory, "scphd_many_", });
launches!(kernels! { large, LargeMemory, "scphd_large_", });
joint_launches!(kernels! { joint, Joint, "scphd_joint_", });

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable. Otherwise the module would need a function that is not defined anywhere.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
