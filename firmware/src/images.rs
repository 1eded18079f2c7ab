//! Images that replay a stream.

use crate::board;
use crate::clock::{Clock, LOOP_INSTRUCTIONS};
use crate::report::{self, Report};
use cortex_m::Peripherals;
use scphd::Real;
use scphd_stream::planar::{BlackBox, BlackBoxJoint, Planar};
use scphd_stream::{Aboard, Reader, replay};

/// Defines an image that replays streams of one kind in one precision and reports every scan. The filter's memory is all zero, so
/// that it takes no flash.
#[macro_export]
macro_rules! replay_image {
    ($kind:ty, $scalar:ty) => {
        use defmt_semihosting as _;

        static MEMORY: static_cell::ConstStaticCell<<$kind as scphd_stream::Aboard<$scalar>>::Memory> =
            static_cell::ConstStaticCell::new(<$kind as scphd_stream::Aboard<$scalar>>::MEMORY);

        #[cortex_m_rt::entry]
        fn main() -> ! {
            $crate::images::replay_and_report::<$kind, $scalar>(MEMORY.try_take())
        }

        $crate::handlers!();
    };
}

/// Defines the handlers of faults and panics, and of SysTick.
#[macro_export]
macro_rules! handlers {
    () => {
        #[cortex_m_rt::exception]
        fn SysTick() {
            $crate::clock::round();
        }

        $crate::failure_handlers!();
    };
}

/// Defines the handlers of faults and panics.
#[macro_export]
macro_rules! failure_handlers {
    () => {
        #[cortex_m_rt::exception]
        unsafe fn HardFault(_frame: &cortex_m_rt::ExceptionFrame) -> ! {
            $crate::report::fault()
        }

        #[panic_handler]
        fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
            $crate::report::panicked()
        }
    };
}

/// Replays a black box of a planar vehicle, complete or from a snapshot on, with the filter of its head.
pub fn replay_black_box<T: Real>(
    mixture: Option<&'static mut <BlackBox as Aboard<T>>::Memory>,
    joint: Option<&'static mut <BlackBoxJoint as Aboard<T>>::Memory>,
) -> ! {
    if Reader::<Planar>::open(board::stream()).is_ok_and(|reader| reader.is_of_joint_map()) {
        replay_and_report::<BlackBoxJoint, T>(joint)
    } else {
        replay_and_report::<BlackBox, T>(mixture)
    }
}

/// Replays the loaded stream, reports every scan, and ends the program.
pub fn replay_and_report<K: Aboard<T>, T: Real>(memory: Option<&'static mut K::Memory>) -> ! {
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
        K::CAPACITIES.candidates,
        K::CAPACITIES.particles,
        K::CAPACITIES.components,
        K::CAPACITIES.components_in_all,
        K::CAPACITIES.measurements,
    );
    defmt::println!("ram total {=usize}", size_of::<K::Memory>());
    for part in K::RAM_PARTS {
        defmt::println!("ram {=str} {=usize}", part.name, part.bytes);
    }
    match replay::<K, T>(board::stream(), memory, u32::MAX, &mut Report::new(clock)) {
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
