//! Built-in simulated scenarios.
//!
//! The landmarks, the trajectory and the tracks of a scenario never change (except in the random `worlds`); its seed changes the
//! noise, the missed detections and the clutter. The same seed gives the same log, bit for bit, on every machine (see
//! [`scphd_log::noise`]).

mod car;
mod faults;
mod landmarks;
mod mover;
mod simulation;
mod survey;
#[cfg(test)]
mod tests;
mod thesis_compare;
mod thesis_dynamic;
mod two_sensors;
pub mod worlds;

pub use faults::faults;
pub use survey::{survey, survey_fixes};
pub use thesis_compare::thesis_compare;
pub use thesis_dynamic::thesis_dynamic;
pub use two_sensors::two_sensors;

use scphd_log::log::Log;
use worlds::{Kind, world};

/// Names of the scenarios, each with a description.
pub const SCENARIOS: &[(&str, &str)] = &[
    (
        "survey",
        "a car drives two laps of a rounded rectangle (29 x 23 m, 64 s) among 60 landmarks, 20 false measurements a scan",
    ),
    ("survey-fixes", "survey again, with a fix of the position every 10 s, good to 1 m, as of a satellite receiver"),
    (
        "two-sensors",
        "the way and the landmarks of survey, seen by a lidar ahead and a radar behind, with other views, noise and times",
    ),
    (
        "thesis-dynamic",
        "section 5.3.1: a loop (39 x 37 m, 30 s) among 45 landmarks and 6 that move, 20 false measurements a scan",
    ),
    (
        "thesis-compare",
        "section 5.3.2: a trefoil (44 x 41 m, 40 s) among 60 landmarks, strong noise, 5 false measurements a scan",
    ),
    (
        "faults",
        "the loop of thesis-dynamic twice (60 s), 4 false measurements a scan, and faults of sensor and odometry, one after the other",
    ),
    (
        "worlds",
        "a random world for every seed (12 to 96 m, 4 to 5 min) that states its data sheet and misbehaves as real ones do",
    ),
    ("worlds-mounted", "the worlds again, with the sensor elsewhere than where the vehicle's pose is, and turned"),
    ("worlds-moving", "the worlds again, and three to seven others move among the landmarks, slower and faster"),
    ("worlds-exact", "a random world for every seed that states all of its noise, 3 to 10 false measurements a scan"),
];

/// The scenarios with a different world for every seed.
pub const WORLDS: [&str; 4] = ["worlds", "worlds-mounted", "worlds-moving", "worlds-exact"];

pub fn by_name(name: &str, seed: u64) -> Option<Log> {
    match name {
        "survey" => Some(survey(seed)),
        "survey-fixes" => Some(survey_fixes(seed)),
        "two-sensors" => Some(two_sensors(seed)),
        "thesis-dynamic" => Some(thesis_dynamic(seed)),
        "thesis-compare" => Some(thesis_compare(seed)),
        "faults" => Some(faults(seed)),
        "worlds" => Some(world(Kind::DataSheet, seed)),
        "worlds-mounted" => Some(world(Kind::Mounted, seed)),
        "worlds-moving" => Some(world(Kind::Moving, seed)),
        "worlds-exact" => Some(world(Kind::Exact, seed)),
        _ => None,
    }
}

/// Whether a scenario is one of the thesis, run with its recursion; the others are run like a user's log.
pub fn is_of_thesis(name: &str) -> bool {
    !WORLDS.contains(&name) && name != "two-sensors"
}

/// Parameters of the thesis for runs of a scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThesisRun {
    /// Particles N.
    pub particles: usize,
    /// Samples M of every particle in a prediction.
    pub samples: usize,
    /// Resample below this N_eff / N.
    pub resample_threshold: f64,
    pub moving: bool,
    /// Number of runs with each input of a Monte Carlo study.
    pub runs_per_input: usize,
}

/// The thesis's parameters for runs of this scenario, if there are any (5.3.1); `faults` has the vehicle and the moving landmarks
/// of 5.3.1.
pub fn thesis_run(name: &str) -> Option<ThesisRun> {
    let as_in_5_3_1 =
        ThesisRun { particles: 32, samples: 2, resample_threshold: 0.05, moving: true, runs_per_input: 4 };
    matches!(name, "thesis-dynamic" | "faults").then_some(as_in_5_3_1)
}
