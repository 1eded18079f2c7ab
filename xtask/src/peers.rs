//! Tests with Python packages that read and write what this project does, in the project's Python environment.

use crate::outcome::{Outcome, Stop};
use crate::python::Environment;
use crate::{process, unit};
use std::process::Command;

/// Packages that read MCAP files and trajectories.
const READERS: [&str; 2] = ["evo>=1.30,<2", "rosbags>=0.10,<0.12"];
/// A package of half a gigabyte.
const LARGE: [&str; 1] = ["rerun-sdk>=0.41,<0.42"];
/// pymavlink and its dependencies.
const MAVLINK: [&str; 3] = ["pymavlink>=2.4.41,<3", "fastcrc>=0.3", "lxml>=5"];

/// The tests of a file, which the step `unit` has built.
fn tests(file: &str) -> Command {
    let mut cargo = process::cargo();
    cargo.arg("test").args(unit::PACKAGES).args(["--test", file, "--", "--ignored", "--nocapture"]);
    cargo
}

/// The step `logs`: other programs read the output of runs; with `large`, also with large packages.
pub fn logs(large: bool) -> Result<Outcome, Stop> {
    let environment = Environment::obtain()?;
    environment.equip(&READERS)?;
    let mut readers = tests("readers");
    readers.env("SCPHD_READERS_PYTHON", environment.program()).env_remove("SCPHD_READERS_ALL");
    if large {
        environment.equip(&LARGE)?;
        readers.env("SCPHD_READERS_ALL", "1");
    }
    process::run(&mut readers)?;
    Ok(environment.passed())
}

/// The step `mavlink`: pymavlink reads and writes messages of flight stacks.
pub fn mavlink() -> Result<Outcome, Stop> {
    let environment = Environment::obtain()?;
    environment.equip_alone(&MAVLINK)?;
    process::run(tests("pymavlink").env("SCPHD_MAVLINK_PYTHON", environment.program()))?;
    Ok(environment.passed())
}
