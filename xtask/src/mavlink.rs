//! Messages of flight stacks, read and written by pymavlink in the project's Python environment.

use crate::outcome::{Outcome, Stop};
use crate::process;
use crate::python::{self, Environment};
use crate::unit;

/// pymavlink and its dependencies.
const PEER: [&str; 3] = ["pymavlink>=2.4.41,<3", "fastcrc>=0.3", "lxml>=5"];

/// The step.
pub fn step() -> Result<Outcome, Stop> {
    let version = python::interpreter()?;
    let environment = Environment::of(&version)?;
    environment.equip_alone(&PEER)?;
    let mut cargo = process::cargo();
    // Built by the step `unit`.
    cargo.arg("test").args(unit::PACKAGES).args(["--test", "pymavlink", "--", "--ignored", "--nocapture"]);
    process::run(cargo.env("SCPHD_MAVLINK_PYTHON", environment.program()))?;
    Ok(Outcome::Passed(format!("Python {version}")))
}
