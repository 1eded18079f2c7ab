//! The workspace of the C interface.

use crate::process;
use std::path::PathBuf;
use std::process::Command;

/// The targets of archives other than the host: with and without a floating-point unit.
pub const TARGETS: [&str; 2] = ["thumbv7em-none-eabihf", "thumbv7em-none-eabi"];

/// Folder for host builds other than the archive.
pub fn tools_dir() -> PathBuf {
    process::own_target_dir("capi-tools")
}

pub fn cargo(command: &str) -> Command {
    process::cargo_in(command, "bindings/capi/Cargo.toml", &tools_dir())
}
