//! The device memory of one filter.

use crate::kind::Particles;
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

impl<M: Particles> Slot<M> {
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

impl<M: Particles> Default for Slot<M> {
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
