//! Delayed births: a measurement that comes from no known feature is stored until a scan may have detected it again.
//!
//! Most births come from clutter. As a component in the map of every particle, each would be compared with the measurements of the
//! next scan for every candidate, mostly without a match. But they are the same measurements for all particles, with almost the
//! same weight, at the same place as seen from the vehicle. The next scan, of any sensor, therefore decides once for all particles
//! which of them it may have detected again, or does not see. Those [enter](enter::enter) the maps. The others are missed
//! detections of every particle: they add −p_D w to its ln L, and are removed, because their remaining weight would be pruned.

pub(crate) mod enter;
mod meet;
pub(crate) mod memory;
mod walk;
