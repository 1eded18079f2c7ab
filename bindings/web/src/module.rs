//! The functions that the page calls. A module has one thread and imports nothing, so that no call begins before the last has ended.

use crate::{Session, Surroundings, Wish};
use core::cell::UnsafeCell;

struct Only(UnsafeCell<Session>);

// SAFETY: WebAssembly without shared memory has one thread.
unsafe impl Sync for Only {}

static ONLY: Only = Only(UnsafeCell::new(Session::NEW));

/// Has something done with the session.
fn with<T>(work: impl FnOnce(&mut Session) -> T) -> T {
    // SAFETY: this is the only reference. There is one thread, `work` never comes back here, and no function of this file hands a
    // reference out.
    work(unsafe { &mut *ONLY.0.get() })
}

/// Starts the world of a seed with so many particles. 0: done; 1: refused.
#[unsafe(no_mangle)]
extern "C" fn start(seed: u32, particles: u32) -> u32 {
    let particles = usize::try_from(particles).unwrap_or(0);
    with(|session| u32::from(session.start(u64::from(seed), particles).is_err()))
}

/// Drives to the next scan and takes it in, as [`Session::step`]: automatically where `automatic` is not 0, and the filter is told how
/// the sensor sees where `told` is not 0. 0: done; 1: refused.
#[unsafe(no_mangle)]
extern "C" fn step(automatic: u32, speed_mps: f32, rate_radps: f32, clutter: f32, detection: f32, told: u32) -> u32 {
    let wish = if automatic == 0 { Wish::Manual { speed_mps, rate_radps } } else { Wish::Automatic };
    let around = Surroundings { clutter, detection };
    with(|session| u32::from(session.step(wish, around, told != 0).is_err()))
}

/// Where the numbers of the view lie; they are valid until the next call of another function than this one and [`numbers`].
#[unsafe(no_mangle)]
extern "C" fn view() -> *const f32 {
    with(|session| session.view().numbers().as_ptr())
}

/// How many there are.
#[unsafe(no_mangle)]
extern "C" fn numbers() -> u32 {
    with(|session| u32::try_from(session.view().numbers().len()).unwrap_or(0))
}

/// The digest of the filter's state.
#[unsafe(no_mangle)]
extern "C" fn digest() -> u64 {
    with(|session| session.digest())
}

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable: where one were, the module would ask the page for a function that it does not have.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
