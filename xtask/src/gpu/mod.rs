//! The filter on a GPU: builds and checks the module and executes it on the host; assembles it, and runs it on a GPU if there is
//! one.

mod executed;
mod module;
mod ptxas;

use crate::outcome::{Outcome, Stop};
use crate::{files, process, toolchain};
use std::path::{Path, PathBuf};
use std::process::Command;

pub use module::TARGET;

/// Exit code of the program without a driver or GPU.
const NO_DEVICE: i32 = 3;
const ON_CARD: [&str; 9] = [
    "check thesis-dynamic --runs 64",
    "check survey --particles 32 --runs 64",
    "check thesis-dynamic --joint --runs 64",
    "check survey --joint --runs 64",
    "check thesis-dynamic --particles 64",
    "check thesis-dynamic --particles 4096",
    "time thesis-dynamic --runs 10000",
    "time survey --joint --runs 10000",
    "time thesis-dynamic --particles 4096 --scans 30",
];

/// cargo, for the program that runs the kernels.
fn cargo(command: &str) -> Command {
    let mut cargo = process::cargo();
    cargo.args([command, "--quiet", "--locked", "--package", "scphd-gpu"]);
    cargo
}

/// The step `module`.
pub fn module() -> Result<Outcome, Stop> {
    built().map(|(_, said, has_clippy)| if has_clippy { Outcome::Passed(said) } else { Outcome::Partly(said) })
}

/// Builds the module, checks its text, and executes it. Returns its folder, a summary, and whether clippy was there.
fn built() -> Result<(PathBuf, String, bool), Stop> {
    let toolchain = toolchain::find_for(&[TARGET])?;
    if toolchain.has_clippy() {
        module::lint(&toolchain)?;
    }
    let text = module::build(&toolchain)?;
    let lines = module::look_through(&text)?;
    println!(
        "{lines} lines of PTX: no double, nothing fused, nothing approximate, no panic, no call through a pointer"
    );
    let folder = process::own_target_dir("gpu").join("modules");
    files::write(&folder.join(module::FILE), &text)?;
    let executed = executed::few(&folder, cargo)?;
    let linted = if toolchain.has_clippy() { "" } else { "; NOT RUN: clippy on the kernels" };
    Ok((folder, format!("{lines} lines of PTX, {executed}{linted}"), toolchain.has_clippy()))
}

/// The step `gpu`.
pub fn step() -> Result<Outcome, Stop> {
    let (folder, built, _) = built()?;
    let executed = format!("{built}, and {}", executed::check(&folder, cargo)?);
    let summary = match ptxas::Ptxas::obtain() {
        Ok(ptxas) => ptxas.assemble(&folder.join(module::FILE), &folder)?,
        Err(reason) => {
            return Ok(Outcome::Partly(format!("{executed}; NOT RUN: ptxas, {}", reason.0)));
        }
    };
    println!("{summary}");
    let summary = format!("{executed}; {summary}");
    match on_card(&folder) {
        Ok(said) => Ok(Outcome::Passed(format!("{summary}; {said}"))),
        Err(Stop::Missing(reason)) => Ok(Outcome::Partly(format!("{summary}; NOT RUN: {reason}"))),
        Err(broken) => Err(broken),
    }
}

fn on_card(modules: &Path) -> Result<String, Stop> {
    let of_card = |words: &str| -> Result<String, Stop> {
        let mut command = cargo("run");
        command.args(["--release", "--"]).args(words.split(' ')).args(["--device", "cuda", "--modules"]).arg(modules);
        let output = command.output().map_err(|error| error.to_string())?;
        let [said, complaint] =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).trim().to_owned());
        match output.status.code() {
            Some(0) => Ok(said),
            Some(NO_DEVICE) => Err(Stop::Missing(complaint)),
            _ => Err(format!("{words}: {said} {complaint}").into()),
        }
    };
    let mut all = Vec::new();
    for words in ON_CARD {
        let said = of_card(words)?;
        println!("{said}");
        all.push(said);
    }
    Ok(all.join("; "))
}
