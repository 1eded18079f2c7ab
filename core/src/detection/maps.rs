//! The maps of a filter by kind of features.

use crate::map::Maps;
use crate::{Dynamic, PositionOf, Static};

/// Maps of static features.
pub(crate) type StaticMaps<'s, P> = Maps<'s, Static<PositionOf<P>>>;
/// Maps of moving features.
pub(crate) type DynamicMaps<'s, P> = Maps<'s, Dynamic<PositionOf<P>>>;
