//! The maps of a vehicle, by kind.

use crate::map::Maps;
use crate::{Dynamic, PositionOf, Static};

/// The maps of what stands still around a vehicle.
pub(crate) type StaticMaps<'s, P> = Maps<'s, Static<PositionOf<P>>>;
/// The maps of what moves around it.
pub(crate) type DynamicMaps<'s, P> = Maps<'s, Dynamic<PositionOf<P>>>;
