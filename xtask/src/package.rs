//! The step `package`: checks that the packages for publication are complete.

use crate::outcome::{Missing, Outcome, Stop};
use crate::{files, process};
use std::collections::BTreeSet;

/// Name and folder of each crate that is a library for others.
const LIBRARIES: [(&str, &str); 8] = [
    ("scphd", "core"),
    ("scphd-stream", "onboard/stream"),
    ("scphd-link", "onboard/link"),
    ("scphd-lidar", "onboard/lidar"),
    ("scphd-mavlink", "onboard/mavlink"),
    ("scphd-sequencer", "onboard/sequencer"),
    ("scphd-store", "onboard/store"),
    ("scphd-vehicle", "onboard/vehicle"),
];

const FILES: [&str; 5] = ["Cargo.toml", "README.md", "LICENSE-MIT", "LICENSE-APACHE", "src/lib.rs"];

/// Expected warnings: the project has no address yet, and tests remain in the repository, because they need its logs and oracles.
const MEANT: [&str; 2] = ["warning: manifest has no documentation, homepage or repository", "warning: ignoring test "];

/// Creates all packages without building them, and checks their contents.
pub fn step() -> Result<Outcome, Stop> {
    let mut cargo = process::cargo();
    // Offline, so that newer versions in a registry have no effect. Dirty, because a step may run before a commit.
    cargo.args(["package", "--no-verify", "--offline", "--allow-dirty", "--target-dir"]);
    cargo.arg(process::own_target_dir("package"));
    cargo.args(LIBRARIES.iter().flat_map(|(name, _)| ["--package", name]));
    let output = cargo.output().map_err(|error| error.to_string())?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("cargo package: {said}").into());
    }
    let is_meant = |line: &str| MEANT.iter().any(|meant| line.starts_with(meant));
    let warned: Vec<&str> = said.lines().filter(|line| line.starts_with("warning") && !is_meant(line)).collect();
    if !warned.is_empty() {
        return Err(format!("cargo package: {}", warned.join("; ")).into());
    }
    for (name, folder) in LIBRARIES {
        whole(name, folder)?;
    }
    Ok(Outcome::Passed(format!("{} libraries", LIBRARIES.len())))
}

/// Checks that a package has the required files and licences, and does not depend on the repository around it.
fn whole(name: &str, folder: &str) -> Result<(), Stop> {
    let listed =
        process::read(process::cargo().args(["package", "--list", "--offline", "--allow-dirty", "--package", name]))?;
    let listed: BTreeSet<String> = listed.lines().map(|line| line.replace('\\', "/")).collect();
    if let Some(missing) = FILES.iter().find(|file| !listed.contains(**file)) {
        return Err(format!("{name}: {missing} is not in the package").into());
    }
    if let Some(stray) = listed.iter().find(|file| file.starts_with("tests/")) {
        return Err(format!("{name}: {stray} needs the repository").into());
    }
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        if files::text(&process::root().join(folder).join(licence))? != files::text(&process::root().join(licence))? {
            return Err(format!("{folder}/{licence} is not that of the project").into());
        }
    }
    Ok(())
}

/// Checks that licences and sources of all dependencies are allowed by `deny.toml`, in every workspace.
pub fn deny() -> Result<Outcome, Stop> {
    if process::read(process::cargo().args(["deny", "--version"])).is_err() {
        return Err(Missing("no `cargo deny` here: cargo install cargo-deny --locked".into()).into());
    }
    for manifest in ["Cargo.toml", "bindings/capi/Cargo.toml", "firmware/Cargo.toml", "firmware/rtos/Cargo.toml"] {
        let mut cargo = process::cargo();
        cargo.args(["deny", "--manifest-path", manifest, "--config"]).arg(process::root().join("deny.toml"));
        process::run(cargo.args(["check", "bans", "licenses", "sources"]))?;
    }
    Ok(Outcome::PASSED)
}
