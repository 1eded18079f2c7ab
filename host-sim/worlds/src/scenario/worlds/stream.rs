//! The random numbers of a world.

use scphd_log::noise::Noise;

/// A separate random number generator for each purpose, so that switching one error does not change the others.
pub(crate) fn stream(seed: u64, purpose: u64) -> Noise {
    Noise::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ purpose.wrapping_mul(0xd1b5_4a32_d192_ed03))
}
