//! The step `msrv`: checks that nothing needs a newer Rust than the oldest supported one.

use crate::outcome::{Outcome, Stop};
use crate::toolchain::OLDEST;
use crate::{lint, process};
use std::process::Command;

/// The step: builds with the oldest Rust if it is present; otherwise clippy's lint `incompatible_msrv`, one of those that are errors
/// in the step `lint`, looks for newer items of the standard library.
pub fn step() -> Result<Outcome, Stop> {
    let Some(mut check) = oldest_cargo() else {
        lint::lint()?;
        return Ok(Outcome::Passed(format!("by clippy's lint incompatible_msrv, for no Rust {OLDEST} is at hand")));
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
