//! The functions that the page calls. The module has one thread and imports nothing, so that calls cannot overlap.

use crate::{MEASUREMENTS, Refused, Session, Surroundings, Wish};
use core::cell::UnsafeCell;
use nalgebra::Vector2;
use scphd_vehicle::{Control, Description, Measurements};

/// The session, and the numbers that the page writes.
struct Only(UnsafeCell<(Session, Input)>);
type Input = [f64; INPUT];

/// Number of numbers of the longer of a description and a scan.
const INPUT: usize = {
    let [description, scan] = [Description::<f32>::NUMBERS, 2 * MEASUREMENTS];
    if description > scan { description } else { scan }
};

// SAFETY: WebAssembly without shared memory has one thread.
unsafe impl Sync for Only {}

static ONLY: Only = Only(UnsafeCell::new((Session::NEW, [0.0; INPUT])));

/// Calls a function with the session and the input.
fn with<T>(work: impl FnOnce(&mut Session, &mut Input) -> T) -> T {
    // SAFETY: this is the only reference. There is one thread, `work` does not call this function, and no function of this file
    // returns a reference.
    let (session, input) = unsafe { &mut *ONLY.0.get() };
    work(session, input)
}

/// 0, or 1 if refused.
fn status<T>(work: impl FnOnce(&mut Session, &mut Input) -> Result<T, Refused>) -> u32 {
    with(|session, input| u32::from(work(session, input).is_err()))
}

/// Starts the world of a seed, with this number of particles, or 0 for a joint map. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn start(seed: u32, particles: u32) -> u32 {
    let particles = usize::try_from(particles).unwrap_or(0);
    status(|session, _| session.start(u64::from(seed), particles))
}

/// Drives to the next scan and processes it, as [`Session::step`]. The vehicle is driven automatically if `automatic` is not 0;
/// the filter knows the true clutter and detection probability if `told` is not 0. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn step(automatic: u32, speed_mps: f32, rate_radps: f32, clutter: f32, detection: f32, told: u32) -> u32 {
    let wish = if automatic == 0 { Wish::Manual { speed_mps, rate_radps } } else { Wish::Automatic };
    let around = Surroundings { clutter, detection };
    status(|session, _| session.step(wish, around, told != 0))
}

/// Address of the numbers of the view. They are valid until the next call of a function other than this one and [`numbers`].
#[unsafe(no_mangle)]
extern "C" fn view() -> *const f32 {
    with(|session, _| session.view().numbers().as_ptr())
}

/// Number of numbers in the view.
#[unsafe(no_mangle)]
extern "C" fn numbers() -> u32 {
    with(|session, _| u32::try_from(session.view().numbers().len()).unwrap_or(0))
}

/// The digest of the filter's state.
#[unsafe(no_mangle)]
extern "C" fn digest() -> u64 {
    with(|session, _| session.digest())
}

/// Address of the numbers for [`describe`] and [`scan`]. They are valid as long as the module.
#[unsafe(no_mangle)]
extern "C" fn input() -> *mut f64 {
    with(|_, input| input.as_mut_ptr())
}

/// Starts the filter of the description with the numbers in the input, without a world. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn describe() -> u32 {
    status(|session, input| session.describe(input))
}

/// Predicts, as `Slam::predict`. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn predict(speed_mps: f32, left_mps: f32, turn: f32, dt_s: f32) -> u32 {
    let control = Control { speed_mps, left_mps, turn };
    status(|session, _| session.filter()?.services().predict(control, dt_s).map_err(|_| Refused))
}

/// Updates the filter with a scan: so many ranges, m, each with its bearing, rad, in the input. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn scan(sensor: u32, measurements: u32) -> u32 {
    let [sensor, count] = [sensor, measurements].map(|number| usize::try_from(number).unwrap_or(usize::MAX));
    status(|session, input| {
        let mut all = [Vector2::zeros(); MEASUREMENTS];
        let pairs = input.as_chunks().0.iter().map(|&[range, bearing]| Vector2::new(range as f32, bearing as f32));
        all.iter_mut().zip(pairs).for_each(|(slot, pair)| *slot = pair);
        let measurements = Measurements::RangeBearing(all.get(..count).ok_or(Refused)?);
        session.filter()?.services().scan(sensor, measurements).map_err(|_| Refused)
    })
}

/// Updates the filter with a measured position, m. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn observe_position(x_m: f32, y_m: f32) -> u32 {
    status(|session, _| session.filter()?.services().observe_position(x_m, y_m).map_err(|_| Refused))
}

/// Updates the filter with a measured heading, rad. Returns 0, or 1 if refused.
#[unsafe(no_mangle)]
extern "C" fn observe_heading(heading_rad: f32) -> u32 {
    status(|session, _| session.filter()?.services().observe_heading(heading_rad).map_err(|_| Refused))
}

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable: a reachable one would make the module import a function that the page does not have.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
