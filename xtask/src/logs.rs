//! What a run leaves for other programs, read by those: packages of Python in the environment of the project's own.

use crate::outcome::{Outcome, Stop};
use crate::process;
use crate::python::{self, Environment};
use crate::unit;

/// What reads MCAP files and trajectories.
const READERS: [&str; 2] = ["evo>=1.30,<2", "rosbags>=0.10,<0.12"];
/// Half a gigabyte.
const LARGE: [&str; 1] = ["rerun-sdk>=0.41,<0.42"];

/// The step; with `large` by what is large too.
pub fn step(large: bool) -> Outcome {
    check(large).into()
}

fn check(large: bool) -> Result<Outcome, Stop> {
    let version = python::interpreter()?;
    let environment = Environment::of(&version)?;
    environment.equip(&READERS)?;
    if large {
        environment.equip(&LARGE)?;
    }
    let mut cargo = process::cargo();
    // The step `unit` has built it.
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
