//! Checks that cross crate borders; the tests themselves are in `tests/`. Here is what they share.

use std::panic;
use std::path::PathBuf;
use std::thread;

/// Stack of [`with_roomy_stack`], bytes. It takes memory only as it is touched.
const STACK_BYTES: usize = 512 << 20;

/// The path of the published log `name`, or a note that its check is skipped: the logs are not part of this
/// repository. The environment variable `SCPHD_DATA` says where they are, if not in `shared/data` next to it.
#[must_use]
pub fn data_folder(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("SCPHD_DATA")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")), PathBuf::from);
    let path = root.join(name);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: no {}", path.display());
    None
}

/// Calls `work` in a thread with room for any filter: a state is tens of MB, and an unoptimised build makes it on the
/// stack before it moves to the heap. A panic passes through.
///
/// # Panics
/// The system has no thread for it, or `work` panics.
pub fn with_roomy_stack<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    thread::scope(|scope| {
        let thread = thread::Builder::new().stack_size(STACK_BYTES);
        let handle = thread.spawn_scoped(scope, work).expect("a thread");
        handle.join().unwrap_or_else(|payload| panic::resume_unwind(payload))
    })
}
