//! Chapter 7: an underwater vehicle with a stereo camera, in three dimensions: its logs ([`log`], [`tank`]), its settings, and what its
//! instruments say when.

pub mod log;
pub mod models;
pub mod settings;
pub mod tank;
pub mod timeline;

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
