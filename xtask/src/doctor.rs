//! The command `doctor`: reports tools that are present or missing, and the steps that need them. It changes nothing.

use std::process::Command;

use crate::capi::{self, Compiler};
use crate::debian;
use crate::firmware::board::TARGETS;
use crate::gpu;
use crate::noalloc;
use crate::outcome::Missing;
use crate::process;
use crate::python;
use crate::toolchain::{self, OLDEST};
use crate::tools::{ARM_GCC, CHROMIUM, LLD, QEMU, VALGRIND, Wanted};
use crate::web;

/// The steps that build for a Cortex-M.
const CROSS: &str = "target, proof, firmware, budget, capi, msrv";

/// The state of a tool.
struct Line {
    what: &'static str,
    /// Its version, or the reason why it is missing.
    found: Result<String, String>,
    steps: &'static str,
}

/// The report.
pub fn report() -> String {
    let mut text = String::new();
    for line in lines() {
        text += &show(&line);
    }
    text += "\nWhat is missing is had by ";
    text += &match debian::can_fetch() {
        Ok(()) => format!("unpacking Debian's packages to {}, without root", debian::cache().display()),
        Err(reason) => format!("installing it yourself ({reason})"),
    };
    text += "; targets of the active toolchain by rustup, where it has a network.\n\
             What cannot be had is skipped, and the summary of `cargo xtask test --all` counts it; with --strict that is a failure.\n";
    text
}

fn show(Line { what, found, steps }: &Line) -> String {
    let (mark, found) = match found {
        Ok(found) => ("here", found),
        Err(reason) => ("MISSING", reason),
    };
    format!("{mark:<8}{what:<26}{steps:<41}{found}\n")
}

fn lines() -> Vec<Line> {
    let says = |mut command: Command, words: &[&str]| {
        let said = process::read(command.args(words)).map(|text| text.lines().next().unwrap_or_default().to_owned());
        said.map_err(|error| error.lines().next().unwrap_or_default().to_owned())
    };
    let cargo = |words: &[&str]| says(process::cargo(), words);
    let mut lines = vec![
        Line { what: "cargo", found: cargo(&["--version"]), steps: "all" },
        Line { what: "rustc", found: says(process::rustc(), &["--version"]), steps: "all" },
        Line { what: "rustfmt", found: cargo(&["fmt", "--version"]), steps: "fmt" },
        Line { what: "clippy", found: cargo(&["clippy", "--version"]), steps: "lint, msrv" },
    ];
    lines.extend(TARGETS.map(|target| Line { what: target, found: has_target(target), steps: CROSS }));
    lines.push(Line {
        what: "toolchain for Cortex-M",
        found: toolchain::here(&TARGETS)
            .map(|found| format!("{}, {}", found.name(), found.compiler().unwrap_or_else(|reason| reason))),
        steps: CROSS,
    });
    lines.push(Line { what: "linker for Cortex-M", found: linker(), steps: "proof, firmware, budget" });
    lines.push(Line { what: QEMU.program, found: tool(&QEMU), steps: "firmware, budget, capi" });
    lines.push(Line { what: VALGRIND.program, found: tool(&VALGRIND), steps: "counts, capi" });
    let compiler = |found: Result<Compiler, Missing>| found.map(|c| c.version()).map_err(|Missing(reason)| reason);
    lines.push(Line { what: "C compiler", found: compiler(Compiler::c()), steps: "capi" });
    lines.push(Line { what: "C++ compiler", found: compiler(Compiler::cpp()), steps: "capi" });
    lines.push(Line { what: ARM_GCC.program, found: tool(&ARM_GCC), steps: "capi" });
    let [_, soft] = capi::TARGETS;
    lines.push(Line { what: soft, found: has_target(soft), steps: "capi" });
    let python = python::interpreter().map_err(|Missing(reason)| reason);
    lines.push(Line { what: "python3", found: python, steps: "python, logs, mavlink" });
    let toolchain = toolchain::here(&[web::TARGET]).map(|found| found.name().to_owned());
    lines.push(Line { what: web::TARGET, found: toolchain, steps: "web" });
    let [ptx] = gpu::TARGETS;
    let toolchain = toolchain::here(&gpu::TARGETS).map(|found| found.name().to_owned());
    lines.push(Line { what: ptx, found: toolchain, steps: "gpu" });
    lines.push(Line { what: CHROMIUM.program, found: tool(&CHROMIUM), steps: "web" });
    lines.push(Line { what: "oldest Rust", found: oldest(), steps: "msrv, else by clippy" });
    lines.push(Line { what: "recorded logs", found: logs(), steps: "unit, firmware" });
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

fn oldest() -> Result<String, String> {
    if crate::msrv::is_at_hand() { Ok(OLDEST.into()) } else { Err(format!("no toolchain {OLDEST}")) }
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
        let line = Line { what: "emulator", found: Err("no emulator".into()), steps: "firmware" };
        let shown = show(&line);
        assert!(shown.starts_with("MISSING ") && shown.contains("firmware") && shown.ends_with("no emulator\n"));
        assert!(show(&Line { found: Ok("7".into()), ..line }).starts_with("here "));
    }
}
