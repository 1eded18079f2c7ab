//! Replays the remaining records of a planar vehicle's black box in single precision, with either filter, and reports every scan.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use defmt_semihosting as _;
use scphd_stream::Aboard;
use scphd_stream::planar::{BlackBox, BlackBoxJoint};
use static_cell::ConstStaticCell;

static MIXTURE: ConstStaticCell<<BlackBox as Aboard<f32>>::Memory> =
    ConstStaticCell::new(<BlackBox as Aboard<f32>>::MEMORY);
static JOINT: ConstStaticCell<<BlackBoxJoint as Aboard<f32>>::Memory> =
    ConstStaticCell::new(<BlackBoxJoint as Aboard<f32>>::MEMORY);

#[entry]
fn main() -> ! {
    scphd_firmware::images::replay_black_box::<f32>(MIXTURE.try_take(), JOINT.try_take())
}

scphd_firmware::handlers!();
