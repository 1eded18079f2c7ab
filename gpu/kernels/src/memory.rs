//! The memory of filters: of one of many with particles, of a large one, and of a joint map.

use core::mem::MaybeUninit;
use nalgebra::{Vector2, Vector4};
use scphd::errors::SetupError;
use scphd::models::{PlanarMotion, PlanarPose, Unicycle};
use scphd::numerics::Noise;
use scphd::storage::{Capacities, JointMovers};
use scphd::{Component, Config, DetectorMemory, ScPhd, joint_memory, memory};

/// Capacity for particles of each of many filters.
pub const PARTICLES: usize = 32;
/// Capacity for particles of a large filter.
pub const LARGE_PARTICLES: usize = 16_384;
/// Capacity for samples of each particle.
pub const SAMPLES: usize = 2;
/// Capacity for measurements of a scan.
pub const MEASUREMENTS: usize = 128;
/// Numbers of pages of static and of moving features of each of many filters.
const PAGES: usize = 640;
const MOVING_PAGES: usize = 448;
/// Number of pages of a large filter, of static and of moving features each: the greatest that a `u16` can count.
const LARGE_PAGES: usize = 65_535;
const _: () = assert!(PAGES >= PARTICLES && LARGE_PAGES >= LARGE_PARTICLES, "a thread for a page copies a particle");

memory! {
    /// The memory of one of many filters, for any vehicle: a state depends only on the pose, which all vehicles in the plane
    /// share.
    pub type Memory: Unicycle<f32> {
        particles: PARTICLES, samples: SAMPLES,
        features { pages: PAGES, pages_per_map: 64, in_view: 768 },
        moving { pages: MOVING_PAGES, pages_per_map: 48, in_view: 384 },
    }
}

memory! {
    /// The memory of a large filter. Its maps have the same capacity as those of one of many filters.
    pub type LargeMemory: Unicycle<f32> {
        particles: LARGE_PARTICLES, samples: SAMPLES,
        features { pages: LARGE_PAGES, pages_per_map: 64, in_view: 768 },
        moving { pages: LARGE_PAGES, pages_per_map: 48, in_view: 384 },
    }
}

joint_memory! {
    /// The memory of a joint map.
    pub type JointMemory: Unicycle<f32> { measurement: Vector2<f32>, features: 512, measurements: MEASUREMENTS }
}

/// The moving-object tracks of a joint map.
pub type JointTracks = JointMovers<PlanarPose<f32>, 256>;

/// The memory of one filter with particles.
pub trait Particles: Capacities<Position = Vector2<f32>> + core::fmt::Debug + Sized + 'static {
    /// Numbers of pages of static features and of moving ones.
    const PAGES: [usize; 2];

    /// A filter over this memory; an error if it has no capacity for the configuration, or has an invalid content.
    fn filter(
        &mut self,
        motion: PlanarMotion<f32>,
        config: Config<f32>,
    ) -> Result<ScPhd<'_, PlanarMotion<f32>>, SetupError>;
}

macro_rules! with_particles {
    ($memory:ty, $pages:expr) => {
        impl Particles for $memory {
            const PAGES: [usize; 2] = $pages;

            fn filter(
                &mut self,
                motion: PlanarMotion<f32>,
                config: Config<f32>,
            ) -> Result<ScPhd<'_, PlanarMotion<f32>>, SetupError> {
                ScPhd::new(motion, config, self)
            }
        }
    };
}

with_particles!(Memory, [PAGES, MOVING_PAGES]);
with_particles!(LargeMemory, [LARGE_PAGES; 2]);

/// Estimated features and moving features of a scan.
pub(crate) type Estimates = ([Component<Vector2<f32>>; 192], [Component<Vector4<f32>>; 64]);
/// The scratch of the sensor.
type Scratch = DetectorMemory<Vector2<f32>, MEASUREMENTS>;

/// The working memory of one filter. It starts as zeros, and no part of it is on a thread's stack.
#[derive(Debug)]
pub struct Slot<M> {
    pub(crate) memory: M,
    pub(crate) scratch: Scratch,
    /// Memory for the estimates of one scan.
    #[cfg_attr(not(target_arch = "nvptx64"), expect(dead_code, reason = "a host compares the state alone"))]
    pub(crate) estimates: Estimates,
}

// All of a memory is numbers except this option, whose `None` must be zero for the compiler of the device as well.
#[expect(unsafe_code, reason = "the memory of a device starts as zeros")]
const _: () = {
    // SAFETY: either variant is valid, and a random stream is numbers.
    let zero: Option<Noise> = unsafe { MaybeUninit::zeroed().assume_init() };
    assert!(zero.is_none(), "a slot does not begin as zeros");
};

#[cfg(test)]
mod tests {
    use super::{JointMemory, JointTracks, Memory, Scratch};
    use std::fmt::Debug;

    /// What zeros are as a value, shown.
    #[expect(unsafe_code, reason = "the memory of a device starts as zeros")]
    fn zeros<T: Debug>() -> String {
        let mut zeros = Box::<T>::new_uninit();
        // SAFETY: the value is compared with a new one; numbers and arrays of numbers may be zero.
        let zeros = unsafe {
            zeros.as_mut_ptr().write_bytes(0, 1);
            zeros.assume_init_ref()
        };
        format!("{zeros:?}")
    }

    #[test]
    fn zeros_are_new_memory() {
        static NEW: Memory = Memory::new();
        static NEW_JOINT: JointMemory = JointMemory::new();
        assert!(zeros::<Memory>() == format!("{NEW:?}"));
        assert!(zeros::<Scratch>() == format!("{:?}", Scratch::new()));
        assert!(zeros::<JointMemory>() == format!("{NEW_JOINT:?}"));
        assert!(zeros::<JointTracks>() == format!("{:?}", JointTracks::new()));
    }
}
