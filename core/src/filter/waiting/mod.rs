//! Births that wait: what nothing explains stays the measurement that it is, until a scan tells whether it is seen again.
//!
//! Most of those births are of clutter. Each is a component in the map of every particle, and every candidate of the next scan looks at
//! it, only to find that no measurement is near. But they are the same measurements for all particles, with nearly the same weight, and
//! sit at h⁻¹(z, x) of each particle's pose: so the next scan asks once for all particles which of them it may have seen again. Those
//! [enter](enter::enter) the maps. The others are missed by every particle; they add −p_D w to its ln L and would be pruned for what is left of
//! their weights.

pub(crate) mod enter;
mod meet;
pub(crate) mod memory;
mod walk;
