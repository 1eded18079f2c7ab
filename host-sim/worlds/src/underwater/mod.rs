//! Chapter 7: an underwater vehicle with a stereo camera, in three dimensions: the tank of the thesis ([`tank`]), and random
//! worlds ([`worlds`]).

mod stereo;
pub mod tank;
pub mod worlds;

use scphd_log::underwater::Log;
use worlds::{Kind, world};

/// Names of the scenarios, each with a description.
pub const SCENARIOS: &[(&str, &str)] = &[
    (
        "girona-tank",
        "chapter 7: an AUV surveys the floor of an 8 x 8 x 5 m tank in two crossed lawnmowers, stereo camera, 10 frames a second, 20 false keypoints a frame",
    ),
    (
        "worlds-space",
        "a random world under water for every seed (4 to 40 m, 2.5 to 4 min), stereo camera, that states its data sheets and misbehaves as real ones do",
    ),
    (
        "worlds-space-exact",
        "a random world under water for every seed that states all of its noise, 3 to 10 false keypoints a frame",
    ),
];

/// The scenarios with a different world for every seed.
pub const WORLDS: [&str; 2] = ["worlds-space", "worlds-space-exact"];

pub fn by_name(name: &str, seed: u64) -> Option<Log> {
    match name {
        "girona-tank" => Some(tank::girona_tank(seed)),
        "worlds-space" => Some(world(Kind::DataSheet, seed)),
        "worlds-space-exact" => Some(world(Kind::Exact, seed)),
        _ => None,
    }
}
