//! Chapter 7: an underwater vehicle with a stereo camera, in three dimensions.
//!
//! The same as the planar part of the simulator, for logs in which a vehicle moves in space and sees pixels: logs
//! ([`log`], [`tank`]), settings, filters behind one trait ([`slam`]) and sessions. Scores, JSON keys and
//! Monte Carlo studies are shared with it.

mod joint;
pub mod lockstep;
pub mod log;
pub mod plot;
pub mod record;
pub mod session;
pub mod settings;
pub mod slam;
pub mod tables;
pub mod tank;
pub mod timeline;
pub mod truth;

use log::Log;

/// Names of the scenarios, each with a line about it.
pub const SCENARIOS: &[(&str, &str)] = &[(
    "girona-tank",
    "chapter 7: an AUV surveys the floor of an 8 x 8 x 5 m tank in two crossed lawnmowers, stereo camera, 10 frames a second, 20 false keypoints a frame",
)];

/// The scenario of that name.
#[must_use]
pub fn by_name(name: &str, seed: u64) -> Option<Log> {
    (name == "girona-tank").then(|| tank::girona_tank(seed))
}
