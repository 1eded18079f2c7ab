//! The library's example of a robot with a lidar, a radar and satellite fixes, on a board: its final state is that on the host.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use defmt_semihosting as _;
use scphd_firmware::{board, report};
use static_cell::ConstStaticCell;

#[path = "../../../core/examples/robot/drive.rs"]
mod drive;

static MEMORY: ConstStaticCell<drive::Memory> = ConstStaticCell::new(drive::Memory::NEW);

#[entry]
fn main() -> ! {
    let Some(memory) = MEMORY.try_take() else { report::failed() };
    match drive::drive(memory) {
        Ok(drive::Outcome { rmse_m: [mixture, joint], dead_reckoning_m, digests: [of_mixture, of_joint] }) => {
            defmt::println!(
                "end mixture {=f32} joint {=f32} dead_reckoning {=f32} digests {=u64:016x} {=u64:016x} stack {=usize}",
                mixture,
                joint,
                dead_reckoning_m,
                of_mixture,
                of_joint,
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

scphd_firmware::failure_handlers!();
