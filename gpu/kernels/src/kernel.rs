//! The entry points of the device.

use crate::room::{Filters, bytes};
use crate::size::{LargeMemory, Memory};
use crate::stages::Stage;
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
    ($size:ty, $bytes:ident, $($name:ident: $stage:ident),* $(,)?) => {
        $(
            #[doc = "A launch.\n\n# Safety\nAs of [`Stage::run`]."]
            #[unsafe(no_mangle)]
            pub unsafe extern "ptx-kernel" fn $name(filters: *const Filters<$size>, scan: u32, digest_every: u32) {
                // SAFETY: the caller's word; every thread of a grid has a place of its own.
                unsafe { const { Stage::<$size>::$stage }.run(place(), &*filters, scan, digest_every) }
            }
        )*

        #[doc = "Writes the bytes of the buffers.\n\n# Safety\nThe pointer leads to as many numbers."]
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $bytes(to: *mut [u64; 7]) {
            if place() == 0 {
                // SAFETY: the caller's word, and one thread alone writes.
                unsafe { to.write(bytes::<$size>()) };
            }
        }
    };
}

kernels! {
    Memory, scphd_many_bytes,
    scphd_many_start: START,
    scphd_many_desks: DESKS,
    scphd_many_predict: PREDICT,
    scphd_many_sample: SAMPLE,
    scphd_many_open: OPEN,
    scphd_many_drift: DRIFT,
    scphd_many_propose: PROPOSE,
    scphd_many_weigh: WEIGH,
    scphd_many_products: PRODUCTS,
    scphd_many_evidence: EVIDENCE,
    scphd_many_multiply: MULTIPLY,
    scphd_many_rest: REST,
    scphd_many_cumulate: CUMULATE,
    scphd_many_decide: DECIDE,
    scphd_many_draw: DRAW,
    scphd_many_runs: RUNS,
    scphd_many_settle: SETTLE,
    scphd_many_assign: ASSIGN,
    scphd_many_make: MAKE,
    scphd_many_claim: CLAIM,
    scphd_many_unheld: UNHELD,
    scphd_many_add_up: ADD_UP,
    scphd_many_judge: JUDGE,
    scphd_many_commit: COMMIT,
    scphd_many_list: LIST,
    scphd_many_take: TAKE,
    scphd_many_fill: FILL,
    scphd_many_share: SHARE,
    scphd_many_sum: SUM,
    scphd_many_centre: CENTRE,
    scphd_many_sum_centre: SUM_CENTRE,
    scphd_many_spread: SPREAD,
    scphd_many_sum_spread: SUM_SPREAD,
    scphd_many_close: CLOSE,
    scphd_many_digest: DIGEST,
}

kernels! {
    LargeMemory, scphd_large_bytes,
    scphd_large_start: START,
    scphd_large_desks: DESKS,
    scphd_large_predict: PREDICT,
    scphd_large_sample: SAMPLE,
    scphd_large_open: OPEN,
    scphd_large_drift: DRIFT,
    scphd_large_propose: PROPOSE,
    scphd_large_weigh: WEIGH,
    scphd_large_products: PRODUCTS,
    scphd_large_evidence: EVIDENCE,
    scphd_large_multiply: MULTIPLY,
    scphd_large_rest: REST,
    scphd_large_cumulate: CUMULATE,
    scphd_large_decide: DECIDE,
    scphd_large_draw: DRAW,
    scphd_large_runs: RUNS,
    scphd_large_settle: SETTLE,
    scphd_large_assign: ASSIGN,
    scphd_large_make: MAKE,
    scphd_large_claim: CLAIM,
    scphd_large_unheld: UNHELD,
    scphd_large_add_up: ADD_UP,
    scphd_large_judge: JUDGE,
    scphd_large_commit: COMMIT,
    scphd_large_list: LIST,
    scphd_large_take: TAKE,
    scphd_large_fill: FILL,
    scphd_large_share: SHARE,
    scphd_large_sum: SUM,
    scphd_large_centre: CENTRE,
    scphd_large_sum_centre: SUM_CENTRE,
    scphd_large_spread: SPREAD,
    scphd_large_sum_spread: SUM_SPREAD,
    scphd_large_close: CLOSE,
    scphd_large_digest: DIGEST,
}

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable: where one were, the module would need a function that is nowhere.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
