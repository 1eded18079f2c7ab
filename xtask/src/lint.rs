//! The steps `fmt` and `lint`, and helpers for other steps that use clippy.

use std::path::PathBuf;
use std::process::Command;

use crate::capi;
use crate::files;
use crate::outcome::{Missing, Outcome, Stop};
use crate::process;
use crate::python;
use crate::web;

/// Features of the workspace that are only enabled by the firmware or not at all.
const LINT_FEATURES: [&str; 2] = [
    "--features",
    "scphd/defmt,scphd/embedded-hal,scphd-link/defmt,scphd-sequencer/defmt,scphd-store/defmt,scphd-stream/defmt",
];

/// Fails unless the active toolchain has this subcommand of cargo.
fn need(command: &str) -> Result<(), Missing> {
    let said = process::read(process::cargo().args([command, "--version"]));
    said.map(drop).map_err(|_| Missing(format!("the active toolchain has no `cargo {command}`")))
}

/// Fails unless the active toolchain has clippy.
pub fn need_clippy() -> Result<(), Missing> {
    need("clippy")
}

/// The step `fmt`: firmware, C interface, Python package, web page and ROS 2 node are separate workspaces.
pub fn fmt() -> Result<Outcome, Stop> {
    let firmware = ["fmt", "--manifest-path", "firmware/Cargo.toml", "--", "--check"];
    let rtos = ["fmt", "--manifest-path", "firmware/rtos/Cargo.toml", "--", "--check"];
    let capi = ["fmt", "--all", "--manifest-path", "bindings/capi/Cargo.toml", "--", "--check"];
    let python = ["fmt", "--manifest-path", "bindings/python/Cargo.toml", "--", "--check"];
    let web = ["fmt", "--manifest-path", "bindings/web/Cargo.toml", "--", "--check"];
    let ros2 = ["fmt", "--manifest-path", "bindings/ros2/Cargo.toml", "--", "--check"];
    let workspace = ["fmt", "--all", "--check"];
    need("fmt")?;
    let each = [&workspace[..], &firmware[..], &rtos[..], &capi[..], &python[..], &web[..], &ros2[..]];
    let results = each.map(|arguments| process::run(process::cargo().args(arguments)));
    results.into_iter().collect::<Result<(), String>>()?;
    Ok(Outcome::PASSED)
}

/// clippy on every package of the workspace, with warnings as errors. The steps `lint` and `msrv` run it, of which the second one
/// finds nothing left to do.
pub fn workspace() -> Result<Command, String> {
    let mut cargo = process::cargo();
    cargo.args(["clippy", "--workspace", "--all-targets", "--keep-going"]);
    cargo.args(LINT_FEATURES).args(["--", "-D", "warnings"]);
    cargo.env("CLIPPY_CONF_DIR", settings()?);
    Ok(cargo)
}

/// A folder with settings for clippy: tests must build with the oldest Rust too.
pub fn settings() -> Result<PathBuf, String> {
    let folder = process::own_target_dir("clippy-settings");
    files::write(&folder.join("clippy.toml"), "check-incompatible-msrv-in-tests = true\n")?;
    Ok(folder)
}

/// The step `lint`.
pub fn lint() -> Result<Outcome, Stop> {
    // The other capacities of the vehicle's filter, which only the firmware's images use.
    let mut few = process::cargo();
    few.args(["clippy", "--package", "scphd-stream", "--features", "few-particles", "--", "-D", "warnings"]);
    need_clippy()?;
    for mut clippy in [workspace()?, few, capi::clippy(), python::clippy(), web::clippy()] {
        process::run(&mut clippy)?;
    }
    Ok(Outcome::PASSED)
}
