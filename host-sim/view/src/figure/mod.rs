//! The figures of chapter 5 of the thesis that the documentation shows, made from scenarios and runs of this program.

mod errors;
mod maps;

pub use errors::{comparison, mean_errors};
pub use maps::{estimate, tracks};

/// Numbers of the figures, each with a description.
pub const FIGURES: &[(&str, &str)] = &[
    ("5.4", "thesis-dynamic: map and trajectory estimate; tracks of moving features"),
    ("5.5", "thesis-dynamic: mean pose and map error over time, 100 runs"),
    ("5.8", "thesis-compare: pose and map error of SC-PHD and RB-PHD SLAM, 50 runs"),
];

#[cfg(test)]
mod tests;
