//! The node of ROS 2: its tests, and another implementation of DDS as its peer, over loopback.

use crate::outcome::{Missing, Outcome, Stop};
use crate::process;
use crate::python::Environment;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// The peer, and a package with the definitions of messages.
const PEER: [&str; 2] = ["cyclonedds>=11,<12", "rosbags>=0.10,<0.12"];
/// Exit code of the peer if it and the node do not discover each other.
const NO_DISCOVERY: i32 = 77;
/// Logs of the simulator to play, scenarios, and their speed-up.
const LOGS: [&str; 2] = ["survey", "thesis-compare"];
const SCENARIOS: [&str; 2] = ["two-sensors@8", "survey-fixes@8"];
const LOG_RATE: u32 = 8;

/// Runs a command in a network of its own, which has nothing but loopback, with multicast: nothing leaves the machine, and no other
/// node is found.
const ALONE: [&str; 6] = [
    "--map-root-user",
    "--net",
    "sh",
    "-c",
    "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\"",
    "sh",
];

/// A command in such a network or, where none can be made, in that of the machine.
fn in_network(program: impl AsRef<OsStr>) -> Command {
    match process::read(process::command("unshare").args(ALONE).arg("true")) {
        Ok(_) => {
            let mut unshare = process::command("unshare");
            unshare.args(ALONE).arg(program);
            unshare
        }
        Err(reason) => {
            println!("no network of its own, so that of this machine: {reason}");
            process::command(program)
        }
    }
}

/// cargo, in the workspace of the node.
fn cargo(command: &str) -> Command {
    let mut cargo = process::cargo_in(command, "bindings/ros2/Cargo.toml", &process::own_target_dir("ros2"));
    cargo.arg("--release");
    cargo
}

pub fn step() -> Result<Outcome, Stop> {
    process::run(cargo("clippy").args(["--all-targets", "--", "-D", "warnings"]))?;
    process::run(cargo("test").arg("--tests"))?;
    let environment = Environment::obtain()?;
    environment.equip(&PEER)?;
    process::run(cargo("build").args(["--bins", "--example", "reencode"]))?;
    let program = |name: &str| process::own_target_dir("ros2").join("release").join(name);
    let folder = process::own_target_dir("ros2").join("played");
    // A log can only be written to a new folder.
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let mut sources = Vec::new();
    for log in LOGS {
        let place = folder.join(format!("{log}-log"));
        let mut publish = process::command(program("scphd-publish"));
        process::run(publish.args([log, "--no-play", "--log"]).arg(&place))?;
        sources.push(PathBuf::from(format!("{}@{LOG_RATE}", place.display())));
    }
    sources.extend(SCENARIOS.map(PathBuf::from));
    let mut peer = in_network(environment.program());
    peer.arg("bindings/ros2/tests/peer.py").arg(program("")).arg(&folder).args(sources);
    peer.env("PYTHONDONTWRITEBYTECODE", "1");
    let status = peer.status().map_err(|error| error.to_string())?;
    match status.code() {
        Some(0) => Ok(environment.passed()),
        Some(NO_DISCOVERY) => Err(Missing("DDS finds nobody over loopback here".into()).into()),
        _ => Err(format!("the peer: {status}").into()),
    }
}
