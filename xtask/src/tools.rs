//! Programs that steps need besides cargo: how they are found and obtained.

use crate::debian::{self, Bundle, Tree};
use crate::outcome::Missing;
use crate::{install, process};
use std::path::PathBuf;
use std::process::Command;

/// A program that a step needs.
pub struct Wanted {
    pub program: &'static str,
    /// Debian packages that contain it.
    bundle: Bundle,
}

impl Wanted {
    /// A program that is in the first of these packages, in any version.
    const fn packaged(program: &'static str, name: &'static str, packages: &'static [&'static [&'static str]]) -> Self {
        Self { program, bundle: Bundle { name, packages, oldest: "0" } }
    }
}

/// Emulator of the boards.
pub const QEMU: Wanted = Wanted {
    program: "qemu-system-arm",
    // The first version that has all the boards.
    bundle: Bundle { name: "qemu", packages: &[&["qemu-system-arm"]], oldest: "1:6.0" },
};

/// Bare-metal linker.
pub const LLD: Wanted = Wanted::packaged("ld.lld", "lld", &[&["lld"]]);

/// Counts instructions on the host.
pub const VALGRIND: Wanted = Wanted::packaged("valgrind", "valgrind", &[&["valgrind"]]);

/// Makes symbols of an object local.
pub const OBJCOPY: Wanted = Wanted::packaged("llvm-objcopy", "llvm", &[&["llvm"]]);

/// C compiler and C library for a Cortex-M.
pub const ARM_GCC: Wanted =
    Wanted::packaged("arm-none-eabi-gcc", "gcc-arm", &[&["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"]]);

pub const CHROMIUM: Wanted = Wanted::packaged("chromium", "chromium", &[&["chromium"]]);

/// Runs WebAssembly without a browser.
pub const NODE: Wanted = Wanted::packaged("node", "nodejs", &[&["nodejs"]]);

/// Builds programs that use the installed C library.
pub const CMAKE: Wanted = Wanted::packaged("cmake", "cmake", &[&["cmake"]]);

/// Valgrind, which looks for its tools where it is installed, unless it is told another place.
pub fn valgrind() -> Result<Command, Missing> {
    let valgrind = VALGRIND.obtain()?;
    let mut command = valgrind.command();
    if let Some(tree) = &valgrind.tree {
        command.env("VALGRIND_LIB", tree.path("usr/libexec/valgrind"));
    }
    Ok(command)
}

/// A program that is present.
#[derive(Debug, Clone)]
pub struct Tool {
    pub program: PathBuf,
    /// The tree to which it was unpacked; `None` if it is installed.
    pub tree: Option<Tree>,
    pub version: String,
}

impl Tool {
    pub fn command(&self) -> Command {
        let mut command = process::command(&self.program);
        self.equip(&mut command);
        command
    }

    /// Prepares a command that runs the program.
    pub fn equip(&self, command: &mut Command) {
        if let Some(tree) = &self.tree {
            tree.equip(command);
        }
    }

    pub fn place(&self) -> String {
        self.tree.as_ref().map_or_else(|| "installed".into(), |tree| format!("unpacked: {}", tree.what()))
    }

    fn probe(program: PathBuf, tree: Option<Tree>) -> Result<Self, String> {
        let mut tool = Self { program, tree, version: String::new() };
        let said = process::read(tool.command().arg("--version"))?;
        tool.version = said.lines().next().unwrap_or_default().to_owned();
        Ok(tool)
    }
}

/// A test of a program, beyond reporting its version.
type Trial<'a> = &'a dyn Fn(&Tool) -> Result<(), String>;

impl Wanted {
    /// The program, if it is installed or was unpacked before.
    pub fn find(&self) -> Option<Tool> {
        self.find_that(&|_| Ok(()))
    }

    /// The first of these that passes a trial.
    fn find_that(&self, trial: Trial) -> Option<Tool> {
        let passes = |tool: &Tool| {
            let why_not = |reason: &String| {
                println!("the {} that is {} will not do: {reason}", self.program, tool.place());
            };
            trial(tool).inspect_err(why_not).is_ok()
        };
        let unpacked = || debian::unpacked(&self.bundle).and_then(|tree| self.of(tree).ok());
        let installed = Tool::probe(self.program.into(), None).ok();
        installed.filter(passes).or_else(|| unpacked().filter(passes))
    }

    fn of(&self, tree: Tree) -> Result<Tool, String> {
        Tool::probe(tree.path("usr/bin").join(self.program), Some(tree))
    }

    /// The program; if it is missing, it is unpacked to a folder, or installed if that is not possible.
    pub fn obtain(&self) -> Result<Tool, Missing> {
        self.obtain_that(&|_| Ok(()))
    }

    /// The program that passes a trial; one that fails it is treated as missing.
    pub fn obtain_that(&self, trial: Trial) -> Result<Tool, Missing> {
        if let Some(tool) = self.find_that(trial) {
            return Ok(tool);
        }
        println!("there is no {}", self.program);
        let tried = |tool: Tool| trial(&tool).map(|()| tool);
        let unpacked = debian::fetch(&self.bundle).and_then(|tree| self.of(tree)).and_then(tried);
        let installed = |reason: String| {
            println!("- Debian's packages, unpacked: {reason}");
            let installed = install::packages(self.bundle.packages[0]);
            installed.and_then(|()| Tool::probe(self.program.into(), None)).and_then(tried).map_err(|other| {
                println!("- installed: {other}");
                Missing(format!("no {}: {reason}; {other}", self.program))
            })
        };
        unpacked.or_else(installed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CARGO: Wanted = Wanted::packaged("cargo", "none", &[]);

    #[test]
    fn an_installed_program_is_used() {
        let tool = CARGO.find().expect("cargo runs this test");
        assert!(tool.tree.is_none() && tool.version.starts_with("cargo "), "{tool:?}");
    }

    #[test]
    fn a_program_that_fails_its_trial_is_treated_as_missing() {
        assert!(CARGO.find_that(&|_| Err("it lacks a part".into())).is_none());
        assert!(CARGO.find_that(&|tool| process::read(tool.command().arg("--list")).map(drop)).is_some());
    }

    #[test]
    fn a_missing_program_is_not_found() {
        assert!(
            Wanted::packaged("scphd-no-such-program", "no-such-bundle", &[&["scphd-no-such-package"]]).find().is_none()
        );
    }
}
