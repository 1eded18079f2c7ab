//! The functions that the page calls. The module has one thread and imports nothing, so that calls cannot overlap.

use crate::{Session, Surroundings, Wish};
use core::cell::UnsafeCell;

struct Only(UnsafeCell<Session>);

// SAFETY: WebAssembly without shared memory has one thread.
unsafe impl Sync for Only {}

static ONLY: Only = Only(UnsafeCell::new(Session::NEW));

/// Calls a function with the session.
fn with<T>(work: impl FnOnce(&mut Session) -> T) -> T {
    // SAFETY: this is the only reference. There is one thread, `work` does not call this function, and no function of this file
    // returns a reference.
    work(unsafe { &mut *ONLY.0.get() })
}

/// Starts the world of a seed, with this number of particles. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn start(seed: u32, particles: u32) -> u32 {
    let particles = usize::try_from(particles).unwrap_or(0);
    with(|session| u32::from(session.start(u64::from(seed), particles).is_err()))
}

/// Drives to the next scan and processes it, as [`Session::step`]. The vehicle is driven automatically if `automatic` is not 0;
/// the filter knows the true clutter and detection probability if `told` is not 0. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn step(automatic: u32, speed_mps: f32, rate_radps: f32, clutter: f32, detection: f32, told: u32) -> u32 {
    let wish = if automatic == 0 { Wish::Manual { speed_mps, rate_radps } } else { Wish::Automatic };
    let around = Surroundings { clutter, detection };
    with(|session| u32::from(session.step(wish, around, told != 0).is_err()))
}

/// Address of the numbers of the view. They are valid until the next call of a function other than this one and [`numbers`].
#[unsafe(no_mangle)]
extern "C" fn view() -> *const f32 {
    with(|session| session.view().numbers().as_ptr())
}

/// Number of numbers in the view.
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

/// No panic is reachable: a reachable one would make the module import a function that the page does not have.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
