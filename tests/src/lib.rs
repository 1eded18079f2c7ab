//! Checks that cross crate borders; the tests themselves are in `tests/`. Here is what they share.

pub mod fuzz;

use std::panic;
use std::thread;

/// Stack of [`with_roomy_stack`], bytes. It takes memory only as it is touched.
const STACK_BYTES: usize = 512 << 20;

pub use scphd_shared_data::find as data_folder;

/// Calls `work` in a thread with room for any filter: a state is tens of MB, and an unoptimised build makes it on the
/// stack before it moves to the heap. A panic passes through.
///
/// # Panics
/// The system has no thread for it, or `work` panics.
pub fn with_roomy_stack<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    thread::scope(|scope| {
        // Under the name of the test that it belongs to.
        let name = thread::current().name().unwrap_or("unnamed").to_owned();
        let thread = thread::Builder::new().name(name).stack_size(STACK_BYTES);
        let handle = thread.spawn_scoped(scope, work).expect("a thread");
        handle.join().unwrap_or_else(|payload| panic::resume_unwind(payload))
    })
}
