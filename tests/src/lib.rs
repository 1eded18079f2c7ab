//! Tests across crates; the tests are in `tests/`, and the code that they share is here.

pub mod fuzz;

use std::panic;
use std::thread;

/// Stack of [`with_roomy_stack`], bytes. Memory is allocated only for the part that is used.
const STACK_BYTES: usize = 512 << 20;

pub use scphd_shared_data::find as data_folder;

/// Calls `work` in a thread with a stack for any filter: a state has tens of MB, and an unoptimised build constructs it on the
/// stack before it is moved to the heap. A panic is passed on.
pub fn with_roomy_stack<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    thread::scope(|scope| {
        // The thread has the name of the test.
        let name = thread::current().name().unwrap_or("unnamed").to_owned();
        let thread = thread::Builder::new().name(name).stack_size(STACK_BYTES);
        let handle = thread.spawn_scoped(scope, work).expect("a thread");
        handle.join().unwrap_or_else(|payload| panic::resume_unwind(payload))
    })
}
