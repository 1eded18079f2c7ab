//! The body of the images that replay a stream.

use crate::board;
use crate::clock::{Clock, LOOP_INSTRUCTIONS};
use crate::report::{self, Report};
use cortex_m::Peripherals;
use scphd::Real;
use scphd_stream::{CAPACITIES, Memory, ram_parts, replay};

/// Replays the stream that was loaded, tells of every scan, and ends the program.
pub fn replay_and_report<T: Real>(memory: Option<&'static mut Memory<T>>) -> ! {
    let (Some(memory), Some(mut peripherals)) = (memory, Peripherals::take()) else {
        defmt::error!("started twice");
        report::failed()
    };
    let clock = Clock::start(&mut peripherals);
    defmt::println!(
        "clock {=str} instructions {=u32} ticks {=u64}",
        clock.name(),
        LOOP_INSTRUCTIONS,
        clock.of_known_loop()
    );
    defmt::println!(
        "capacity candidates {=usize} particles {=usize} components {=usize} in_all {=usize} measurements {=usize}",
        CAPACITIES.candidates,
        CAPACITIES.particles,
        CAPACITIES.components,
        CAPACITIES.components_in_all,
        CAPACITIES.measurements,
    );
    defmt::println!("ram total {=usize}", size_of::<Memory<T>>());
    for part in ram_parts::<T>() {
        defmt::println!("ram {=str} {=usize}", part.name, part.bytes);
    }
    match replay(board::stream(), memory, u32::MAX, &mut Report::new(clock)) {
        Ok(totals) => {
            defmt::println!(
                "end scans {=u32} features {=usize} stack {=usize}",
                totals.scans,
                totals.features,
                board::stack_used()
            );
            report::done()
        }
        Err(error) => {
            defmt::error!("{}", error);
            report::failed()
        }
    }
}
