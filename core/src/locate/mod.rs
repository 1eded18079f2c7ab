//! Global localisation in the map of an earlier drive. The vehicle maps in a frame of its own, from where it starts, and its
//! landmarks are aligned with those of the map. `docs/locate.md` has the equations.
//!
//! Each landmark counts once, however often it was detected: repeated scans of the same landmarks have no new information on the
//! pose, because a vehicle elsewhere would detect its landmarks as often.

mod alignment;
mod config;
mod evidence;
mod locator;
mod pairs;
mod search;
mod state;
#[cfg(test)]
mod tests;
mod views;

pub use config::LocatorConfig;
pub use locator::{Located, Locator, LocatorReport};
pub use state::LocatorState;
