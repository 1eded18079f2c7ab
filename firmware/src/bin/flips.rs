//! Replays a planar vehicle's stream in single precision while bits of the filter's state flip, and reports the outcome of every
//! round of scans: with few informed particles or with a joint map, as the stream says.
#![no_std]
#![no_main]

use cortex_m::Peripherals;
use cortex_m_rt::entry;
use defmt_semihosting as _;
use scphd_firmware::clock::{Clock, LOOP_INSTRUCTIONS};
use scphd_firmware::report::{self, Report};
use scphd_firmware::{board, handlers};
use scphd_stream::planar::{Planar, PlanarJoint};
use scphd_stream::{Aboard, FLIP_SEEDS, Failing, Reader, Round, replay_with_flips};
use static_cell::ConstStaticCell;

/// Capacity for a snapshot, bytes.
const ROOM: usize = 256 << 10;

static MIXTURE: ConstStaticCell<<Planar as Aboard<f32>>::Memory> =
    ConstStaticCell::new(<Planar as Aboard<f32>>::MEMORY);
static JOINT: ConstStaticCell<<PlanarJoint as Aboard<f32>>::Memory> =
    ConstStaticCell::new(<PlanarJoint as Aboard<f32>>::MEMORY);
static SNAPSHOT: ConstStaticCell<[u8; ROOM]> = ConstStaticCell::new([0; ROOM]);

#[entry]
fn main() -> ! {
    let (Some(mixture), Some(joint), Some(room), Some(mut peripherals)) =
        (MIXTURE.try_take(), JOINT.try_take(), SNAPSHOT.try_take(), Peripherals::take())
    else {
        report::failed()
    };
    let clock = Clock::start(&mut peripherals);
    let ticks = clock.of_known_loop();
    defmt::println!("clock {=str} instructions {=u32} ticks {=u64}", clock.name(), LOOP_INSTRUCTIONS, ticks);
    let [of_mixture, of_joint] = FLIP_SEEDS;
    match Reader::<Planar>::open(board::stream()).map(|reader| reader.is_of_joint_map()) {
        Ok(true) => run::<PlanarJoint>("joint", joint, room, of_joint, clock),
        _ => run::<Planar>("mixture", mixture, room, of_mixture, clock),
    }
    defmt::println!("end stack {=usize}", board::stack_used());
    report::done()
}

fn run<A>(name: &str, memory: &mut A::Memory, room: &mut [u8], seed: u64, clock: Clock)
where
    A: Aboard<f32>,
    for<'m> A::Filter<'m>: Failing<A::Kind>,
{
    let tell = |told: &Round| {
        defmt::println!(
            "round {=u32} of {=str} flips {=u32} mended {=u32} isolated {=u32} refused {=u32} digest {=u64:016x}",
            told.round,
            name,
            told.flips,
            told.mended,
            told.isolated,
            told.refused,
            told.digest
        );
        defmt::println!("worst {=u64}", told.worst);
    };
    if let Err(error) = replay_with_flips::<A>(board::stream(), memory, room, seed, &mut Report::new(clock), tell) {
        defmt::error!("{}", error);
        report::failed()
    }
}

handlers!();
