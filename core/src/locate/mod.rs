//! Where is the vehicle in a map of an earlier drive? The vehicle maps from where it stands, in a frame of its own, and the
//! landmarks that it finds are laid over those of the map. `docs/locate.md` has the equations.
//!
//! A landmark speaks once, however often it was detected: scans that show the same ones again say nothing new of where the
//! vehicle is, and a vehicle that is somewhere else would see them as often.

mod config;
mod evidence;
mod laying;
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
