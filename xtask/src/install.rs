//! Installs packages that a check needs, if this is possible.

use crate::{debian, process};
use std::process::Command;

/// Installs Debian packages with apt-get. The error names them.
pub fn packages(names: &[&str]) -> Result<(), String> {
    let packages = names.join(" ");
    if process::read(process::command("apt-get").arg("--version")).is_err() {
        return Err(format!("nothing to install {packages} with"));
    }
    if process::read(process::command("id").arg("-u"))? != "0" {
        return Err(format!("only root can install {packages}"));
    }
    println!("setting up: apt-get installs {packages}");
    process::run(apt_get().arg("update"))?;
    let mut install = apt_get();
    // Without --no-remove, apt could replace another Rust that the user has chosen.
    install.args(["install", "-y", "--no-install-recommends", "--no-remove"]).args(names);
    process::run(&mut install)
}

/// apt-get with its own network limits; killing it could leave packages half configured.
fn apt_get() -> Command {
    let mut command = process::command("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command.arg("-q").args(debian::NETWORK);
    command
}
