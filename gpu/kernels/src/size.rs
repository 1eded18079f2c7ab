//! The two sizes of filters on a device: one for many at once, one for a single large one.

use crate::motion::Vehicle;
use core::fmt::Debug;
use nalgebra::Vector2;
use scphd::errors::SetupError;
use scphd::models::Unicycle;
use scphd::storage::Capacities;
use scphd::{Config, ScPhd, memory};

/// Room for particles of each of many filters.
pub const PARTICLES: usize = 32;
/// Room for particles of a large filter.
pub const LARGE_PARTICLES: usize = 16_384;
/// Room for samples of each particle.
pub const SAMPLES: usize = 2;
/// Pages of moving features of all maps of a large filter, and as many of static ones: the most that can be counted.
const LARGE_PAGES: usize = 65_535;
/// Pages of static features of all maps of one of many filters.
const PAGES: usize = 640;
/// Pages of moving features, likewise.
const MOVING_PAGES: usize = 448;

memory! {
    /// What one of many filters knows, whatever moves its vehicle: a state is of a pose, and all vehicles in the plane have the same.
    pub type Memory: Unicycle<f32> {
        particles: PARTICLES, samples: SAMPLES,
        features { pages: PAGES, pages_per_map: 64, in_view: 768 },
        moving { pages: MOVING_PAGES, pages_per_map: 48, in_view: 384 },
    }
}

memory! {
    /// What a large filter knows: maps as large as those of one of many.
    pub type LargeMemory: Unicycle<f32> {
        particles: LARGE_PARTICLES, samples: SAMPLES,
        features { pages: LARGE_PAGES, pages_per_map: 64, in_view: 768 },
        moving { pages: LARGE_PAGES, pages_per_map: 48, in_view: 384 },
    }
}

/// The memory of one filter, with its capacities.
pub trait Size: Capacities<Position = Vector2<f32>> + Debug + Sized + 'static {
    /// What the names of its kernels begin with.
    const NAME: &'static str;
    /// Particles that it has room for.
    const PARTICLES: usize;
    /// Pages of static features.
    const PAGES: usize;
    /// Pages of moving features.
    const MOVING_PAGES: usize;
    /// All zero.
    const EMPTY: Self;

    /// A filter over this memory.
    ///
    /// # Errors
    /// The configuration does not fit it, or what it holds does not.
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
