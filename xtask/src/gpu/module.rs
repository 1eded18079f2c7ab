//! The module as text (PTX): built from the kernels and the library, and checked for instructions that would change bits or stop
//! a thread.

use crate::outcome::Stop;
use crate::toolchain::Toolchain;
use crate::{files, lint, process};
use std::path::PathBuf;
use std::process::Command;

pub const TARGET: &str = "nvptx64-nvidia-cuda";
/// Oldest supported architecture; newer GPUs run the module too.
const OLDEST: &str = "sm_80";
/// File name of the text, as the program expects it.
pub const FILE: &str = "scphd.ptx";

fn cargo(toolchain: &Toolchain, command: &str) -> (Command, PathBuf) {
    let folder = process::own_target_dir(&format!("gpu-{}", toolchain.key()));
    let mut cargo = toolchain.cargo(command, "core");
    // Kernels are an unstable feature, and this is a stable compiler.
    cargo.env("RUSTC_BOOTSTRAP", "1");
    // Nothing is linked, but the compiler calls a linker. It copies small values byte by byte unless it is told their size.
    let copies = "-Cllvm-args=-mem-intrinsic-expand-size=128";
    let flags = [&format!("-Ctarget-cpu={OLDEST}"), "-Clinker=true", copies];
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
    cargo.args(["--quiet", "--profile", "ptx", "--locked", "--package", "scphd-gpu-kernels", "--lib"]);
    cargo.args(["--target", TARGET, "--target-dir"]).arg(&folder);
    (cargo, folder)
}

/// clippy on the kernels, which are not compiled for a host; warnings are errors.
pub fn lint(toolchain: &Toolchain) -> Result<(), Stop> {
    let (mut clippy, _) = cargo(toolchain, "clippy");
    Ok(process::run(clippy.env("CLIPPY_CONF_DIR", lint::settings()?).args(["--", "-D", "warnings"]))?)
}

/// Builds the text. The compiler generates it for the whole program, so that no linker is needed.
pub fn build(toolchain: &Toolchain) -> Result<String, Stop> {
    let (mut cargo, folder) = cargo(toolchain, "rustc");
    process::run(cargo.args(["--crate-type", "cdylib", "--", "--emit=asm"]))?;
    let path = folder.join(TARGET).join("ptx/deps/scphd_gpu_kernels.s");
    Ok(files::text(&path)?)
}

/// Checks all lines. Returns their number.
pub fn look_through(text: &str) -> Result<usize, String> {
    let entries = text.lines().filter(|line| line.contains(".entry ")).count();
    if entries == 0 {
        return Err("the module has no kernel".into());
    }
    let mut wrong: Vec<(&str, usize, &str)> = Vec::new();
    for line in text.lines() {
        let Some(why) = complaint(line) else { continue };
        match wrong.iter_mut().find(|(known, ..)| *known == why) {
            Some((_, times, _)) => *times += 1,
            None => wrong.push((why, 1, line.trim())),
        }
    }
    if wrong.is_empty() {
        return Ok(text.lines().count());
    }
    let all: Vec<String> = wrong.iter().map(|(why, times, line)| format!("{why}: {times}, first `{line}`")).collect();
    Err(format!("the module has what it should not have: {}", all.join("; ")))
}

/// Instructions in single precision that round. Each must state rounding to nearest; otherwise it may be fused.
const ROUNDED: [&str; 6] = ["add", "sub", "mul", "div", "rcp", "sqrt"];

/// The reason why a line is not allowed, if any.
fn complaint(line: &str) -> Option<&'static str> {
    let line = line.trim();
    if line.starts_with(".extern") {
        return Some("a function that is nowhere, as of a reachable panic");
    }
    if line.contains(".callprototype") {
        return Some("a call through a pointer, whose stack nobody knows");
    }
    let mut words = line.split_whitespace();
    let first = words.next()?;
    // There may be a predicate before the instruction.
    let instruction = if first.starts_with('@') { words.next()? } else { first };
    let mut parts = instruction.trim_end_matches(';').split('.');
    let name = parts.next()?;
    let kinds: Vec<&str> = parts.collect();
    let has = |kind: &str| kinds.contains(&kind);
    if name.is_empty() || kinds.is_empty() {
        return None;
    }
    if has("f64") {
        return Some("an instruction on doubles");
    }
    if !has("f32") {
        return None;
    }
    if name == "fma" || name == "mad" {
        return Some("a fused operation");
    }
    if has("approx") || has("full") || has("ftz") || has("sat") {
        return Some("an operation that is not exactly rounded");
    }
    let is_rounded = ROUNDED.contains(&name);
    let transcendental = ["sin", "cos", "ex2", "lg2", "rsqrt", "tanh"].contains(&name);
    (transcendental || is_rounded && !has("rn")).then_some("an operation that does not round to nearest")
}

#[cfg(test)]
mod tests {
    use super::{complaint, look_through};

    #[test]
    fn instructions_that_round_to_nearest_are_allowed() {
        let fine = [
            "\tadd.rn.f32 \t%r3, %r1, %r2;",
            "\t@%p1 div.rn.f32 \t%r3, %r1, %r2;",
            "\tsqrt.rn.f32 \t%r3, %r1;",
            "\tmad.lo.s32 \t%r3, %r1, %r2, %r4;",
            "\tsetp.lt.f32 \t%p1, %r1, %r2;",
            "\t.reg .b32 \t%r<12>;",
            "\tcvt.rn.f32.s32 \t%r1, %r2;",
            "$L__BB0_1:",
            "",
            "// add.f32 in a comment is none",
        ];
        assert_eq!(fine.map(complaint), [None; 10]);
    }

    #[test]
    fn instructions_that_change_bits_are_found() {
        let wrong = [
            "\tfma.rn.f32 \t%r4, %r1, %r2, %r3;",
            "\tmad.rn.f32 \t%r4, %r1, %r2, %r3;",
            "\tadd.f32 \t%r3, %r1, %r2;",
            "\t@%p2 mul.rn.ftz.f32 \t%r3, %r1, %r2;",
            "\tdiv.full.f32 \t%r3, %r1, %r2;",
            "\tsin.approx.f32 \t%r2, %r1;",
            "\tsqrt.rz.f32 \t%r2, %r1;",
            "\tcvt.f64.f32 \t%rd1, %r1;",
            "\tmul.rn.f64 \t%rd1, %rd2, %rd3;",
            ".extern .func scphd_a_panic_is_reachable",
            "\tprototype_0 : .callprototype ()_ ();",
        ];
        assert!(wrong.iter().all(|line| complaint(line).is_some()), "{:?}", wrong.map(complaint));
    }

    #[test]
    fn lines_of_a_module_are_counted_or_refused() {
        let kernel = ".visible .entry scphd_runs(\n)\n{\n\tadd.rn.f32 \t%r3, %r1, %r2;\n}\n";
        assert_eq!(look_through(kernel), Ok(5));
        assert!(look_through("// nothing\n").is_err());
        let message = look_through(&kernel.replace("add.rn", "fma.rn")).unwrap_err();
        assert!(message.contains("fused") && message.contains("fma.rn.f32"), "{message}");
    }
}
