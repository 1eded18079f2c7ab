//! The step `msrv`: checks that nothing needs a newer Rust than the oldest supported one.

use crate::firmware::board::REFERENCE;
use crate::outcome::{Missing, Outcome, Stop};
use crate::toolchain::{self, OLDEST, Toolchain};
use crate::{files, lint, process};
use std::path::PathBuf;
use std::process::Command;

/// The lint that knows the version of each item of the standard library.
const LINT: &str = "clippy::incompatible_msrv";
/// No other lint is enabled.
const FLAGS: [&str; 4] = ["-Aclippy::all", "-Awarnings", "-D", LINT];

/// Uses an item that the standard library has since 1.90, in a crate that supports 1.89: the lint must report it.
const PLANTED: &str = "pub fn planted(a: u32, b: i32) -> Option<u32> {\n    a.checked_sub_signed(b)\n}\n";

/// The step: builds with the oldest Rust if it is present; otherwise clippy looks for newer items.
pub fn step() -> Result<Outcome, Stop> {
    let Some(mut check) = oldest_cargo() else {
        println!("no toolchain {OLDEST} is at hand; clippy looks for what the standard library has only since later");
        return by_lint();
    };
    check.args(["check", "--workspace", "--all-targets", "--target-dir"]).arg(process::own_target_dir("msrv"));
    process::run(&mut check)?;
    Ok(Outcome::Passed(format!("built with Rust {OLDEST}")))
}

/// cargo of the oldest Rust: the active one, or one of rustup. A test does not download a toolchain.
pub fn oldest_cargo() -> Option<Command> {
    let is_oldest = |mut rustc: Command| {
        let version = process::read(rustc.arg("--version")).ok();
        version.and_then(|version| version.split(' ').nth(1).map(|number| is_version(number, OLDEST))) == Some(true)
    };
    if is_oldest(process::rustc()) {
        return Some(process::cargo());
    }
    let listed = process::read(process::command("rustup").args(["toolchain", "list"])).ok()?;
    // The name of a toolchain is arbitrary, so that the compiler is asked for its version.
    let toolchain = listed.split_whitespace().find(|name| is_version(name, OLDEST))?;
    let rustup = |program| {
        let mut command = process::command("rustup");
        command.args(["run", toolchain, program]).env_remove("RUSTC");
        command
    };
    is_oldest(rustup("rustc")).then(|| rustup("cargo"))
}

fn by_lint() -> Result<Outcome, Stop> {
    lint::need("clippy")?;
    let settings = lint::settings()?;
    let lint = |mut clippy: Command, arguments: &[&str]| {
        clippy.env("CLIPPY_CONF_DIR", &settings).args(arguments).arg("--").args(FLAGS);
        clippy
    };
    let planted = plant()?;
    let mut clippy = process::cargo();
    clippy.current_dir(&planted).arg("clippy");
    match process::read(&mut lint(clippy, &["--quiet", "--offline"])) {
        Err(complaint) if complaint.contains("incompatible_msrv") || complaint.contains("MSRV") => {}
        Err(complaint) => return Err(format!("clippy's planted slip fails for another reason: {complaint}").into()),
        Ok(_) => return Err(format!("clippy does not see that {} needs a later Rust", planted.display()).into()),
    }
    // This lint is one of those that warn.
    process::run(&mut lint::workspace()?)?;
    let firmware = toolchain::find().and_then(|toolchain| firmware_clippy(&toolchain));
    match firmware {
        Ok(clippy) => {
            process::run(&mut lint(clippy, &[]))?;
            Ok(Outcome::Passed(format!("by clippy's lint incompatible_msrv, for no Rust {OLDEST} is at hand")))
        }
        Err(Missing(reason)) => {
            Ok(Outcome::Partly(format!("by clippy's lint incompatible_msrv; the firmware NOT CHECKED: {reason}")))
        }
    }
}

/// clippy over the firmware, for the reference board.
fn firmware_clippy(toolchain: &Toolchain) -> Result<Command, Missing> {
    if !toolchain.has_clippy() {
        return Err(Missing(format!("{} has no clippy", toolchain.name())));
    }
    let mut clippy = toolchain.cargo("clippy", "core");
    clippy.current_dir(process::root().join("firmware"));
    clippy.args(["--quiet", "--locked", "--bins", "--lib", "--target", REFERENCE.target, "--target-dir"]);
    clippy.arg(process::own_target_dir(&format!("msrv-firmware-{}", toolchain.key())));
    Ok(clippy)
}

/// A crate that needs a newer Rust than it states.
fn plant() -> Result<PathBuf, String> {
    let folder = process::own_target_dir("msrv-planted");
    let manifest = format!(
        "[package]\nname = \"planted\"\nversion = \"0.1.0\"\nedition = \"2024\"\nrust-version = \"{OLDEST}\"\n\n\
         [lib]\npath = \"lib.rs\"\n\n[workspace]\n"
    );
    files::write(&folder.join("Cargo.toml"), manifest)?;
    files::write(&folder.join("lib.rs"), PLANTED)?;
    Ok(folder)
}

/// Whether `name` is the release `version`, a patch release of it, or a toolchain with such a name.
fn is_version(name: &str, version: &str) -> bool {
    name.strip_prefix(version).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '-']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_match_whole_numbers() {
        assert!(is_version("1.89", "1.89"));
        assert!(is_version("1.89.0", "1.89"));
        assert!(is_version("1.89-x86_64-unknown-linux-gnu", "1.89"));
        assert!(!is_version("1.890.0", "1.89"));
        assert!(!is_version("stable-1.89", "1.89"));
    }
}
