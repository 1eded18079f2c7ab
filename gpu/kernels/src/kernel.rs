//! The entry points of the device.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::large;
use crate::room::{Large, large_bytes};
use crate::slot::Slot;
use crate::thread::{Launch, thread};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use nalgebra::Vector2;

/// The place of this thread in a grid of one dimension.
fn place() -> usize {
    // SAFETY: they read registers of the thread.
    let [block, size, thread] = unsafe { [_block_idx_x(), _block_dim_x(), _thread_idx_x()] };
    block as usize * size as usize + thread as usize
}

/// Takes the runs on, one a thread.
///
/// # Safety
/// As of [`thread`].
#[unsafe(no_mangle)]
#[expect(clippy::too_many_arguments, reason = "a kernel's arguments are plain values")]
pub unsafe extern "ptx-kernel" fn scphd_runs(
    runs: *const Run,
    scans: *const Scan,
    predictions: *const Prediction,
    measurements: *const Vector2<f32>,
    slots: *mut Slot,
    statuses: *mut Status,
    results: *mut ScanResult,
    features: *mut Feature,
    movers: *mut Mover,
    threads: u32,
    first_scan: u32,
    take_scans: u32,
    digest_every: u32,
) {
    let launch = Launch {
        runs,
        scans,
        predictions,
        measurements,
        slots,
        statuses,
        results,
        features,
        movers,
        threads,
        first_scan,
        take_scans,
        digest_every,
    };
    // SAFETY: the caller's word; every thread of a grid has a place of its own.
    unsafe { thread(place(), &launch) }
}

/// Entry points of the launches of a large filter.
macro_rules! launches {
    ($($name:ident: $body:path),* $(,)?) => { $(
        #[doc = "A launch of a large filter.\n\n# Safety\nAs of [`open`](large::open)."]
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(large: *const Large, scan: u32, digest_every: u32) {
            // SAFETY: the caller's word; every thread of a grid has a place of its own.
            unsafe { $body(place(), &*large, scan, digest_every) }
        }
    )* };
}

launches! {
    scphd_large_start: large::start,
    scphd_large_desks: large::desks,
    scphd_large_predict: large::predict,
    scphd_large_sample: large::sample,
    scphd_large_open: large::open,
    scphd_large_drift: large::drift,
    scphd_large_propose: large::propose,
    scphd_large_weigh: large::weigh,
    scphd_large_select: large::select,
    scphd_large_make: large::make,
    scphd_large_store: large::store,
    scphd_large_fill: large::fill,
    scphd_large_close: large::close,
}

/// Writes the [bytes](large_bytes) of what the buffers of a large filter are made of, as this module's compiler has laid it out.
///
/// # Safety
/// The pointer leads to as many numbers.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn scphd_large_bytes(bytes: *mut [u64; 5]) {
    if place() == 0 {
        // SAFETY: the caller's word, and one thread alone writes.
        unsafe { bytes.write(large_bytes()) };
    }
}

/// Writes the bytes of a slot, and what it must be aligned to, as this module's compiler has laid it out.
///
/// # Safety
/// The pointer leads to two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn scphd_slot(bytes_and_alignment: *mut u64) {
    if place() == 0 {
        // SAFETY: the caller's word, and one thread alone writes.
        unsafe {
            bytes_and_alignment.write(size_of::<Slot>() as u64);
            bytes_and_alignment.add(1).write(align_of::<Slot>() as u64);
        }
    }
}

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable: where one were, the module would need a function that is nowhere.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
