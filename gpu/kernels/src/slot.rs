//! The device memory of one filter.

use crate::size::Size;
use core::mem::MaybeUninit;
use nalgebra::{Vector2, Vector4};
use scphd::numerics::Noise;
use scphd::{Component, DetectorMemory};

/// Capacity for measurements of a scan.
pub const MEASUREMENTS: usize = 128;
/// Capacity for estimated features of a scan.
pub const FEATURES: usize = 192;
/// Capacity for estimated moving features of a scan.
pub const MOVERS: usize = 64;

/// The scratch of the sensor.
pub(crate) type Scratch = DetectorMemory<Vector2<f32>, MEASUREMENTS>;

/// The working memory of one filter. It starts as zeros, and no part of it is on a thread's stack.
#[derive(Debug)]
pub struct Slot<M> {
    pub(crate) memory: M,
    pub(crate) scratch: Scratch,
    pub(crate) features: [Component<Vector2<f32>>; FEATURES],
    pub(crate) movers: [Component<Vector4<f32>>; MOVERS],
}

impl<M: Size> Slot<M> {
    /// An empty slot, all zero.
    pub const fn new() -> Self {
        Self {
            memory: M::EMPTY,
            scratch: Scratch::new(),
            features: [Component::ZERO; FEATURES],
            movers: [Component::ZERO; MOVERS],
        }
    }
}

impl<M: Size> Default for Slot<M> {
    fn default() -> Self {
        Self::new()
    }
}

// All of a slot is numbers except this option, whose `None` must be zero for the compiler of the device as well.
const _: () = {
    // SAFETY: either variant is valid, and a random stream is numbers.
    let zero: Option<Noise> = unsafe { MaybeUninit::zeroed().assume_init() };
    assert!(zero.is_none(), "a slot does not begin as zeros");
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Memory;

    type Slot = super::Slot<Memory>;

    #[test]
    fn zeros_are_a_new_slot() {
        let mut zeros: Box<MaybeUninit<Slot>> = Box::new(MaybeUninit::uninit());
        // SAFETY: the memory has the same size; its values are compared with those of a new slot.
        let zeros = unsafe {
            zeros.as_mut_ptr().cast::<u8>().write_bytes(0, size_of::<Slot>());
            zeros.assume_init_ref()
        };
        static NEW: Slot = Slot::new();
        assert_eq!(format!("{zeros:?}"), format!("{NEW:?}"));
    }

    #[test]
    fn a_slot_has_at_most_the_documented_size() {
        // docs/gpu.md has 535 096 bytes, of one compiler.
        assert!(size_of::<Slot>() <= 536_000, "{}", size_of::<Slot>());
    }
}
