//! The figures of chapters 5 and 7 of the thesis that show results, made from scenarios and runs of this program.

pub mod densities;
mod errors;
mod maps;
mod space;

pub use errors::{comparison, long_run, mean_errors};
pub use maps::{estimate, measurements, scenario, tracks};
pub use space::{plan_and_section, space_maps, squared_errors, trajectories};

/// Numbers of the figures, each with a description.
pub const FIGURES: &[(&str, &str)] = &[
    ("5.3", "thesis-dynamic: landmarks and trajectory; cumulative measurements and dead reckoning"),
    ("5.4", "thesis-dynamic: map and trajectory estimate; tracks of moving features"),
    ("5.5", "thesis-dynamic: mean pose and map error over time, 100 runs"),
    ("5.6", "thesis-dynamic-long: map and trajectory; pose error and map error over 3501 scans"),
    ("5.7", "thesis-compare: landmarks, trajectory, dead reckoning and cumulative measurements"),
    ("5.8", "thesis-compare: pose and map error of SC-PHD and RB-PHD SLAM, 50 runs"),
    ("5.9", "thesis-compare: smoothed particle densities of one update by either likelihood"),
    ("7.5", "girona-tank: trajectory beside dead reckoning and the truth; plan and section"),
    ("7.6", "girona-tank: features over the true ones"),
    ("7.7", "girona-tank: squared position error"),
];

#[cfg(test)]
mod tests;
