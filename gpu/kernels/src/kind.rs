//! What the kinds of filters on a device have in common.

use core::fmt::Debug;
use nalgebra::Vector2;
use scphd::errors::SetupError;
use scphd::models::PlanarMotion;
use scphd::storage::Capacities;
use scphd::{Config, ScPhd};

/// A kind of filters.
pub trait Kind: Debug + Sized + 'static {
    /// Prefix of the names of its kernels.
    const NAME: &'static str;
    /// Number of pages of static features.
    const PAGES: usize;
    /// Number of pages of moving features.
    const MOVING_PAGES: usize;
    /// The memory of a filter, which starts as zeros.
    type Room: Debug;
    /// The memory for the update of one survivor's maps, which starts as zeros.
    type Desk: Debug;
}

/// The memory of one filter with particles.
pub trait Particles: Capacities<Position = Vector2<f32>> + Debug + Sized + 'static {
    /// An empty memory, all zero.
    const EMPTY: Self;

    /// A filter over this memory.
    ///
    /// # Errors
    /// The memory has no capacity for the configuration, or has an invalid content.
    fn filter(
        &mut self,
        motion: PlanarMotion<f32>,
        config: Config<f32>,
    ) -> Result<ScPhd<'_, PlanarMotion<f32>>, SetupError>;
}
