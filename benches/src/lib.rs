//! What is measured, apart from how: filters in worlds that go on for ever, for the benches of time (`benches/time.rs`), of
//! instructions (`benches/instructions.rs`), and for the figures and curves of `cargo xtask bench`.

pub mod cases;
pub mod figure;
mod rig;
mod world;

pub use rig::{Case, Rig};
pub use world::{Clutter, Course, Input, World};

use std::path::Path;

/// The mean time that criterion has found for one of a group, µs.
///
/// # Errors
/// There is no such result, or it cannot be read.
pub fn criterion_time_us(criterion: &Path, group: &str, id: &str) -> Result<f64, String> {
    let path = criterion.join(group).join(id).join("new/estimates.json");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let estimates: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let mean_ns = estimates["mean"]["point_estimate"].as_f64();
    mean_ns.map(|mean_ns| mean_ns / 1e3).ok_or_else(|| format!("{} has no mean", path.display()))
}
