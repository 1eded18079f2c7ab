//! Checks that other programs can read the output of runs: Python packages in the project's environment.

use crate::outcome::{Outcome, Stop};
use crate::process;
use crate::python::{self, Environment};
use crate::unit;

/// Packages that read MCAP files and trajectories.
const READERS: [&str; 2] = ["evo>=1.30,<2", "rosbags>=0.10,<0.12"];
/// A package of half a gigabyte.
const LARGE: [&str; 1] = ["rerun-sdk>=0.41,<0.42"];

/// The step; with `large`, also with large packages.
pub fn step(large: bool) -> Result<Outcome, Stop> {
    let version = python::interpreter()?;
    let environment = Environment::of(&version)?;
    environment.equip(&READERS)?;
    if large {
        environment.equip(&LARGE)?;
    }
    let mut cargo = process::cargo();
    // Built by the step `unit`.
    cargo.arg("test").args(unit::PACKAGES).args(["--test", "readers", "--", "--ignored", "--nocapture"]);
    cargo.env("SCPHD_READERS_PYTHON", environment.program());
    if large {
        cargo.env("SCPHD_READERS_ALL", "1");
    } else {
        cargo.env_remove("SCPHD_READERS_ALL");
    }
    process::run(&mut cargo)?;
    Ok(Outcome::Passed(format!("Python {version}")))
}
