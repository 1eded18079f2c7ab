//! The steps `fmt`, `lint` and `doc`, and helpers for other steps that use clippy.

use crate::outcome::{Missing, Outcome, Stop};
use crate::{files, process};
use std::path::PathBuf;
use std::process::Command;

/// Features of the workspace that are only enabled by the firmware, or by tests, or not at all.
const LINT_FEATURES: &str = "scphd/defmt,scphd/embedded-hal,scphd-link/defmt,scphd-sequencer/defmt,scphd-sim/gpu,scphd-store/defmt,scphd-stream/defmt";

/// The separate workspaces of bindings, and the targets that clippy checks in them.
const BINDINGS: [(&str, &[&str]); 3] = [
    ("bindings/capi/Cargo.toml", &["--workspace", "--all-targets"]),
    ("bindings/python/Cargo.toml", &[]),
    ("bindings/web/Cargo.toml", &["--all-targets"]),
];

/// Fails unless the active toolchain has this subcommand of cargo.
fn need(command: &str) -> Result<(), Missing> {
    let said = process::read(process::cargo().args([command, "--version"]));
    said.map(drop).map_err(|_| Missing(format!("the active toolchain has no `cargo {command}`")))
}

/// The step `fmt`: firmware, C interface, Python package, web page and ROS 2 node are separate workspaces.
pub fn fmt() -> Result<Outcome, Stop> {
    need("fmt")?;
    let each = [
        ("Cargo.toml", &["--all"][..]),
        ("firmware/Cargo.toml", &[]),
        ("firmware/rtos/Cargo.toml", &[]),
        ("bindings/capi/Cargo.toml", &["--all"]),
        ("bindings/python/Cargo.toml", &[]),
        ("bindings/web/Cargo.toml", &[]),
        ("bindings/ros2/Cargo.toml", &[]),
    ];
    let results = each.map(|(manifest, packages)| {
        process::run(process::cargo().args(["fmt", "--manifest-path", manifest]).args(packages).args(["--", "--check"]))
    });
    results.into_iter().collect::<Result<(), String>>()?;
    Ok(Outcome::PASSED)
}

/// cargo, to check a separate workspace with the profile and in the build folder of this one, so that common dependencies are
/// checked once. The Python package needs no Python for that.
fn cargo_to_check(command: &str, manifest: &str) -> Command {
    let mut cargo = process::cargo_in(command, manifest, &process::target_dir());
    cargo.env("CARGO_PROFILE_DEV_OPT_LEVEL", "0");
    if std::env::var_os("CARGO_PROFILE_DEV_DEBUG").is_none() {
        cargo.env("CARGO_PROFILE_DEV_DEBUG", "line-tables-only");
    }
    cargo.env("PYO3_NO_PYTHON", "1").env("PYO3_BUILD_EXTENSION_MODULE", "1");
    cargo
}

/// The step `doc`: documentation, with warnings as errors.
pub fn doc() -> Result<Outcome, Stop> {
    let mut workspace = process::cargo();
    workspace.args(["doc", "--workspace", "--keep-going"]);
    let others = BINDINGS.map(|(manifest, _)| cargo_to_check("doc", manifest));
    for mut doc in [workspace].into_iter().chain(others) {
        process::run(doc.env("RUSTDOCFLAGS", "-D warnings").arg("--no-deps"))?;
    }
    Ok(Outcome::PASSED)
}

/// clippy on every package of the workspace, with warnings as errors.
fn workspace() -> Result<Command, String> {
    let mut cargo = process::cargo();
    cargo.args(["clippy", "--workspace", "--all-targets", "--keep-going"]);
    cargo.args(["--features", LINT_FEATURES, "--", "-D", "warnings"]);
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
    need("clippy")?;
    let others = BINDINGS.map(|(manifest, targets)| {
        let mut clippy = cargo_to_check("clippy", manifest);
        clippy.args(targets).args(["--", "-D", "warnings"]);
        clippy
    });
    for mut clippy in [workspace()?, few].into_iter().chain(others) {
        process::run(&mut clippy)?;
    }
    Ok(Outcome::PASSED)
}
