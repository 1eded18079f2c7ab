//! The two sizes of filters on a device: one for many filters at once, one for a single large filter.

use crate::motion::Vehicle;
use core::fmt::Debug;
use nalgebra::Vector2;
use scphd::errors::SetupError;
use scphd::models::Unicycle;
use scphd::storage::Capacities;
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

/// The memory of one filter, with its capacities.
pub trait Size: Capacities<Position = Vector2<f32>> + Debug + Sized + 'static {
    /// Prefix of the names of its kernels.
    const NAME: &'static str;
    /// Capacity for particles.
    const PARTICLES: usize;
    /// Number of pages of static features.
    const PAGES: usize;
    /// Number of pages of moving features.
    const MOVING_PAGES: usize;
    /// An empty memory, all zero.
    const EMPTY: Self;

    /// A filter over this memory.
    ///
    /// # Errors
    /// The memory has no capacity for the configuration, or has an invalid content.
    fn filter(&mut self, vehicle: Vehicle, config: Config<f32>) -> Result<ScPhd<'_, Vehicle>, SetupError>;
}

impl Size for Memory {
    const NAME: &'static str = "scphd_many";
    const PARTICLES: usize = PARTICLES;
    const PAGES: usize = PAGES;
    const MOVING_PAGES: usize = MOVING_PAGES;
    const EMPTY: Self = Self::new();

    fn filter(&mut self, vehicle: Vehicle, config: Config<f32>) -> Result<ScPhd<'_, Vehicle>, SetupError> {
        ScPhd::new(vehicle, config, self)
    }
}

impl Size for LargeMemory {
    const NAME: &'static str = "scphd_large";
    const PARTICLES: usize = LARGE_PARTICLES;
    const PAGES: usize = LARGE_PAGES;
    const MOVING_PAGES: usize = LARGE_PAGES;
    const EMPTY: Self = Self::new();

    fn filter(&mut self, vehicle: Vehicle, config: Config<f32>) -> Result<ScPhd<'_, Vehicle>, SetupError> {
        ScPhd::new(vehicle, config, self)
    }
}
