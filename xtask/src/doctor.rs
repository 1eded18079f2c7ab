//! The command `doctor`: reports tools that are present or missing, and the steps that need them. It changes nothing.

use std::process::Command;

use crate::capi::{self, Compiler};
use crate::debian;
use crate::firmware::board::TARGETS;
use crate::gpu;
use crate::msrv;
use crate::noalloc;
use crate::outcome::Missing;
use crate::process;
use crate::python;
use crate::toolchain::{self, OLDEST};
use crate::tools::{ARM_GCC, CHROMIUM, LLD, NODE, QEMU, VALGRIND, Wanted};
use crate::web;

/// The steps that build for a Cortex-M.
const CROSS: &str = "target, proof, firmware, budget, capi";

/// A tool, its version or the reason why it is missing, and the steps that need it.
type Line = (&'static str, Result<String, String>, &'static str);

pub fn report() -> String {
    let mut text: String = lines().iter().map(show).collect();
    text += "\nWhat is missing is had by ";
    text += &match debian::can_fetch() {
        Ok(()) => format!("unpacking Debian's packages to {}, without root", debian::cache().display()),
        Err(reason) => format!("installing it yourself ({reason})"),
    };
    text += "; targets of the active toolchain by rustup, where it has a network.\n\
             What cannot be had is skipped, and the summary of `cargo xtask test --all` counts it; with --strict that is a failure.\n";
    text
}

fn show((what, found, steps): &Line) -> String {
    let (mark, found) = match found {
        Ok(found) => ("here", found),
        Err(reason) => ("MISSING", reason),
    };
    format!("{mark:<8}{what:<26}{steps:<41}{found}\n")
}

fn lines() -> Vec<Line> {
    let first_line = |text: String| text.lines().next().unwrap_or_default().to_owned();
    let says =
        |mut command: Command, words: &[&str]| process::read(command.args(words)).map(first_line).map_err(first_line);
    let cargo = |words: &[&str]| says(process::cargo(), words);
    let compiler = |found: Result<Compiler, Missing>| found.map(|c| c.version()).map_err(String::from);
    let builds_for = |target| toolchain::here(&[target]).map(|found| found.name().to_owned());
    let for_boards = toolchain::here(&TARGETS)
        .map(|found| format!("{}, {}", found.name(), found.compiler().unwrap_or_else(|reason| reason)));
    let [_, soft] = capi::TARGETS;
    let oldest = msrv::oldest_cargo().map(|_| OLDEST.to_owned());
    let mut lines = vec![
        ("cargo", cargo(&["--version"]), "all"),
        ("rustc", says(process::rustc(), &["--version"]), "all"),
        ("rustfmt", cargo(&["fmt", "--version"]), "fmt"),
        ("clippy", cargo(&["clippy", "--version"]), "lint, msrv"),
    ];
    lines.extend(TARGETS.map(|target| (target, has_target(target), CROSS)));
    lines.extend([
        ("toolchain for Cortex-M", for_boards, CROSS),
        ("linker for Cortex-M", linker(), "proof, firmware, budget"),
        (QEMU.program, tool(&QEMU), "firmware, budget, capi"),
        (VALGRIND.program, tool(&VALGRIND), "counts, capi"),
        ("C compiler", compiler(Compiler::c()), "capi"),
        ("C++ compiler", compiler(Compiler::cpp()), "capi"),
        (ARM_GCC.program, tool(&ARM_GCC), "capi"),
        (soft, has_target(soft), "capi"),
        ("python3", python::interpreter().map_err(String::from), "python, logs, mavlink"),
        (web::TARGET, builds_for(web::TARGET), "web"),
        (gpu::TARGET, builds_for(gpu::TARGET), "module, gpu"),
        (NODE.program, tool(&NODE), "web"),
        (CHROMIUM.program, tool(&CHROMIUM), "web"),
        ("oldest Rust", oldest.ok_or_else(|| format!("no toolchain {OLDEST}")), "msrv, else by clippy"),
        ("recorded logs", logs(), "unit, firmware"),
    ]);
    lines
}

fn has_target(target: &str) -> Result<String, String> {
    let sysroot = toolchain::active_sysroot()?;
    if noalloc::has_core(&sysroot, target) {
        Ok("in the active toolchain".into())
    } else {
        Err("not in the active toolchain".into())
    }
}

fn linker() -> Result<String, String> {
    match toolchain::beside_rustc() {
        Some(_) => Ok("rust-lld of the active toolchain".into()),
        None => tool(&LLD),
    }
}

fn tool(wanted: &Wanted) -> Result<String, String> {
    let found = wanted.find().ok_or_else(|| format!("no {} that runs", wanted.program))?;
    Ok(format!("{} ({})", found.version, found.place()))
}

fn logs() -> Result<String, String> {
    let folder = scphd_shared_data::folder();
    let shown = folder.canonicalize().map_err(|_| format!("no {}", folder.display()))?;
    Ok(shown.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_tools_are_marked_with_their_steps() {
        let shown = show(&("emulator", Err("no emulator".into()), "firmware"));
        assert!(shown.starts_with("MISSING ") && shown.contains("firmware") && shown.ends_with("no emulator\n"));
        assert!(show(&("emulator", Ok("7".into()), "firmware")).starts_with("here "));
    }
}
