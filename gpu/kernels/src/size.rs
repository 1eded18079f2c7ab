//! The two sizes of filters with particles: one for many filters at once, one for a large one.

use crate::kind::{Kind, Particles};
use crate::room::Room;
use scphd::errors::SetupError;
use scphd::models::{PlanarMotion, Unicycle};
use scphd::storage::UpdateMemory;
use scphd::{Config, ScPhd, memory};

/// Capacity for particles of each of many filters.
pub const PARTICLES: usize = 32;
/// Capacity for particles of a large filter.
pub const LARGE_PARTICLES: usize = 16_384;
/// Capacity for samples of each particle.
pub const SAMPLES: usize = 2;
/// Number of pages of a large filter, of static and of moving features each: the greatest that a `u16` can count.
const LARGE_PAGES: usize = 65_535;
/// Number of pages of static features of each of many filters.
const PAGES: usize = 640;
/// Number of pages of moving features of each of many filters.
const MOVING_PAGES: usize = 448;

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

/// Implements the traits for a memory with particles.
macro_rules! with_particles {
    ($memory:ty, $name:literal, $pages:expr, $moving_pages:expr) => {
        impl Kind for $memory {
            const NAME: &'static str = $name;
            const PAGES: usize = $pages;
            const MOVING_PAGES: usize = $moving_pages;
            type Room = Room<Self>;
            type Desk = UpdateMemory<Self, 1>;
        }

        impl Particles for $memory {
            const EMPTY: Self = Self::new();

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

with_particles!(Memory, "scphd_many", PAGES, MOVING_PAGES);
with_particles!(LargeMemory, "scphd_large", LARGE_PAGES, LARGE_PAGES);

#[cfg(test)]
mod tests {
    use super::Memory;
    use core::mem::MaybeUninit;

    type Slot = crate::slot::Slot<Memory>;

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
