//! C and C++ programs on the host.

use crate::outcome::Missing;
use crate::{process, tools};
use std::path::{Path, PathBuf};
use std::process::Command;

pub struct Compiler {
    program: String,
    standard: &'static str,
    language: &'static str,
}

const WARNINGS: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

impl Compiler {
    pub fn c() -> Result<Self, Missing> {
        Self::find("CC", ["cc", "gcc", "clang"], "-std=c11", "c")
    }

    pub fn cpp() -> Result<Self, Missing> {
        Self::find("CXX", ["c++", "g++", "clang++"], "-std=c++17", "c++")
    }

    fn find(
        variable: &str,
        programs: [&str; 3],
        standard: &'static str,
        language: &'static str,
    ) -> Result<Self, Missing> {
        let chosen = std::env::var(variable).ok().filter(|program| !program.is_empty());
        let mut programs = chosen.into_iter().chain(programs.map(str::to_owned));
        let here = |program: &String| process::read(process::command(program).arg("--version")).is_ok();
        let program = programs.find(here).ok_or_else(|| Missing(format!("no {language} compiler")))?;
        Ok(Self { program, standard, language })
    }

    pub fn version(&self) -> String {
        let said = process::read(process::command(&self.program).arg("--version")).unwrap_or_default();
        said.lines().next().unwrap_or_default().to_owned()
    }

    /// The compiler with its language standard, without options of this project.
    pub fn plain(&self) -> Command {
        let mut command = process::command(&self.program);
        command.arg(self.standard);
        command
    }

    fn command(&self, source: &str) -> Command {
        let capi = process::root().join("bindings/capi");
        let mut command = self.plain();
        command.args(["-O1", "-g"]).args(WARNINGS);
        command.arg("-I").arg(capi.join("include")).arg("-I").arg(capi.join("tests/c"));
        command.args(["-x", self.language]).arg(capi.join(source)).args(["-x", "none"]);
        command
    }

    /// Compiles a source without linking.
    pub fn compile(&self, source: &str, dir: &Path) -> Result<(), String> {
        process::run(self.command(source).arg("-c").arg("-o").arg(dir.join("compiled.o")))
    }

    /// Builds a program with these archives.
    pub fn build(&self, source: &str, archives: &[&Path], dir: &Path) -> Result<PathBuf, String> {
        let program = dir.join(Path::new(source).file_name().unwrap_or_default()).with_extension(self.language);
        process::run(self.command(source).args(archives).args(["-lm", "-o"]).arg(&program))?;
        Ok(program)
    }
}

/// Builds and runs the programs; `inputs` are replayed.
pub fn check(c: &Compiler, archive: &Path, inputs: &Path, dir: &Path) -> Result<(), String> {
    let program = |source: &str| c.build(source, &[archive], dir).map(process::command);
    c.compile("examples/loop.c", dir)?;
    for source in ["tests/c/misuse.c", "tests/c/all_that_a_filter_can.c", "examples/robot.c", "tests/c/worn_wheels.c"] {
        process::run(&mut program(source)?)?;
    }
    process::run(program("tests/c/replay.c")?.arg(inputs))?;
    beside_another(c, archive, dir)
}

/// Compiles and runs programs that use the header in C++; `inputs` are replayed.
pub fn check_cpp(cpp: &Compiler, archive: &Path, inputs: &Path, dir: &Path) -> Result<(), String> {
    cpp.compile("examples/robot.c", dir)?;
    process::run(process::command(cpp.build("tests/c/replay.c", &[archive], dir)?).arg(inputs))?;
    process::run(&mut process::command(cpp.build("examples/robot.cpp", &[archive], dir)?))
}

/// Links the complete archive, another Rust archive with a panic handler of its own, and a copy of ours into one program.
fn beside_another(c: &Compiler, archive: &Path, dir: &Path) -> Result<(), String> {
    let (other, copy) = (dir.join("libother.a"), dir.join("libcopy.a"));
    let mut rustc = process::rustc();
    rustc.args(["--edition", "2024", "--crate-type", "staticlib", "-Cpanic=abort", "-Copt-level=1", "-Clto=fat"]);
    process::run(rustc.arg("-o").arg(&other).arg(process::root().join("bindings/capi/tests/c/other.rs")))?;
    std::fs::copy(archive, &copy).map_err(|error| format!("{}: {error}", copy.display()))?;
    let (whole, end) = (Path::new("-Wl,--whole-archive"), Path::new("-Wl,--no-whole-archive"));
    let program = c.build("tests/c/beside.c", &[whole, archive, end, &other, &copy], dir)?;
    process::run(&mut process::command(program))
}

/// Runs the shorter programs in valgrind.
pub fn check_memory(dir: &Path) -> Result<(), crate::outcome::Stop> {
    for program in ["misuse.c", "all_that_a_filter_can.c", "robot.c"] {
        let mut command = tools::valgrind()?;
        command.args(["--quiet", "--leak-check=full", "--error-exitcode=9"]).arg(dir.join(program));
        process::run(&mut command)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Comments that take a whole line are ignored.
    #[test]
    fn the_page_shows_what_is_compiled() {
        let read = |path: &str| std::fs::read_to_string(process::root().join(path)).unwrap();
        let (page, example) = (read("docs/c.md"), read("bindings/capi/examples/loop.c"));
        let (_, after) = page.split_once("```c\n").unwrap();
        let (shown, _) = after.split_once("```").unwrap();
        let compiled: Vec<&str> = example.lines().map(str::trim).collect();
        let shown = shown.lines().map(str::trim).filter(|line| !line.starts_with("/*"));
        let strange: Vec<&str> = shown.filter(|line| !compiled.contains(line)).collect();
        assert!(strange.is_empty(), "{strange:?}");
    }
}
