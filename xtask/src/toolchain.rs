//! Which toolchain can build for a Cortex-M here.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::install;
use crate::noalloc;
use crate::process;

/// The environment variable that forces one kind of toolchain.
pub const CHOICE_VARIABLE: &str = "SCPHD_TARGET_TOOLCHAIN";

/// A rustup that cannot reach its server retries for a long time; a reachable one needs seconds.
const DOWNLOAD_LIMIT: Duration = Duration::from_secs(120);

const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_PACKAGES: [&str; 3] = ["rustc-web", "cargo-web", "rust-web-src"];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Choice {
    First,
    Rustup,
    Debian,
}

impl Choice {
    fn from_variable(value: Option<&str>) -> Result<Self, String> {
        match value {
            None | Some("") => Ok(Self::First),
            Some("rustup") => Ok(Self::Rustup),
            Some("debian") => Ok(Self::Debian),
            Some(other) => Err(format!("{CHOICE_VARIABLE} is `{other}`; it may be `rustup` or `debian`")),
        }
    }
}

/// A toolchain that can build for a Cortex-M.
pub enum Toolchain {
    /// The active one, which has the target's libraries under this sysroot.
    Active { sysroot: PathBuf },
    /// Debian's, which compiles `core` from its sources.
    Debian,
}

/// A toolchain for all of `targets`: tries the alternatives in their order and says what became of each.
pub fn find(targets: &[&str]) -> Result<Toolchain, String> {
    let names = targets.join(" and ");
    let choice = Choice::from_variable(std::env::var(CHOICE_VARIABLE).ok().as_deref())?;
    println!("looking for a toolchain that builds for {names}");
    if choice != Choice::Debian {
        for (name, alternative) in
            [("active toolchain", active as fn(&[&str]) -> Result<_, _>), ("rustup target add", add_with_rustup)]
        {
            if let Some(toolchain) = report(name, alternative(targets)) {
                return Ok(toolchain);
            }
        }
    }
    if choice != Choice::Rustup
        && let Some(toolchain) = report("Debian's packages", debian())
    {
        return Ok(toolchain);
    }
    Err(match choice {
        Choice::First => format!("no toolchain here builds for {names}; see the reasons above"),
        _ => format!("no toolchain that {CHOICE_VARIABLE} allows builds for {names}; see the reasons above"),
    })
}

fn report(name: &str, found: Result<Toolchain, String>) -> Option<Toolchain> {
    match found {
        Ok(toolchain) => {
            println!("- {name}: works");
            Some(toolchain)
        }
        Err(reason) => {
            println!("- {name}: {reason}");
            None
        }
    }
}

/// The active toolchain, if it has the targets, whoever installed them.
fn active(targets: &[&str]) -> Result<Toolchain, String> {
    let sysroot = active_sysroot()?;
    match targets.iter().find(|target| !noalloc::has_core(&sysroot, target)) {
        None => Ok(Toolchain::Active { sysroot }),
        Some(target) => Err(format!("{} has no libraries for {target}", sysroot.display())),
    }
}

fn active_sysroot() -> Result<PathBuf, String> {
    process::read(process::command(noalloc::rustc()).args(["--print", "sysroot"])).map(PathBuf::from)
}

/// Has rustup fetch the targets for the active toolchain.
fn add_with_rustup(targets: &[&str]) -> Result<Toolchain, String> {
    process::read(process::command("rustup").arg("--version")).map_err(|_| "there is no rustup".to_owned())?;
    println!("setting up: rustup fetches {}, for at most {} s", targets.join(" "), DOWNLOAD_LIMIT.as_secs());
    process::run_for(process::command("rustup").args(["target", "add"]).args(targets), DOWNLOAD_LIMIT)?;
    active(targets)
}

/// Debian's Rust for building web browsers, which is kept recent in stable releases; installed if that is allowed.
fn debian() -> Result<Toolchain, String> {
    match debian_usable() {
        Ok(()) => Ok(Toolchain::Debian),
        Err(reason) => {
            println!("  not yet: {reason}");
            install::packages(&DEBIAN_PACKAGES)?;
            debian_usable().map(|()| Toolchain::Debian)
        }
    }
}

/// Whether Debian's toolchain is there, new enough, and has the sources of `core`.
fn debian_usable() -> Result<(), String> {
    for program in [DEBIAN_CARGO, DEBIAN_RUSTC] {
        if !Path::new(program).is_file() {
            return Err(format!("{program} is missing"));
        }
    }
    let version = process::read(debian_command(DEBIAN_RUSTC).arg("--version"))?;
    let oldest = env!("CARGO_PKG_RUST_VERSION");
    if minor_version(&version).is_none_or(|minor| Some(minor) < minor_version(oldest)) {
        return Err(format!("{DEBIAN_RUSTC} is `{version}`, older than {oldest}"));
    }
    // The packages link the sources to where `-Zbuild-std` looks for them.
    let sysroot = process::read(debian_command(DEBIAN_RUSTC).args(["--print", "sysroot"]))?;
    let sources = Path::new(&sysroot).join("lib/rustlib/src/rust/library/core/Cargo.toml");
    if sources.is_file() { Ok(()) } else { Err(format!("{} is missing", sources.display())) }
}

/// The number 96 of "rustc 1.96.0 (…)" or of "1.96".
fn minor_version(text: &str) -> Option<u32> {
    text.split(' ').find_map(|word| word.strip_prefix("1."))?.split('.').next()?.parse().ok()
}

/// A command of Debian's toolchain, kept apart from the one that runs this program.
fn debian_command(program: &str) -> Command {
    let mut command = process::command(program);
    for variable in ["CARGO", "RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH", "RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER"] {
        command.env_remove(variable);
    }
    clear_flags(&mut command);
    command
}

/// The build is judged with the flags given here and no others.
fn clear_flags(command: &mut Command) {
    command.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
}

impl Toolchain {
    /// What to call it in a report.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Active { .. } => "the active toolchain",
            Self::Debian => "Debian's toolchain",
        }
    }

    /// A short name for a directory.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Active { .. } => "active",
            Self::Debian => "debian",
        }
    }

    /// `cargo build`, judged with the flags given by the caller and no others; `libraries` are those that a toolchain
    /// without any for the target has to build itself.
    pub fn cargo_build(&self, libraries: &str) -> Command {
        match self {
            Self::Active { .. } => {
                let mut cargo = process::cargo();
                clear_flags(&mut cargo);
                cargo.arg("build");
                cargo
            }
            Self::Debian => {
                let mut cargo = debian_command(DEBIAN_CARGO);
                // Building `core` from its sources is an unstable feature of cargo, and this is a stable cargo.
                cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTC", DEBIAN_RUSTC);
                cargo.arg("build").arg(format!("-Zbuild-std={libraries}"));
                cargo
            }
        }
    }

    /// Compiler flags that name a linker for bare metal, where the toolchain does not find its own.
    pub fn linker_flags(&self) -> Result<Vec<String>, String> {
        let beside_rustc = active_sysroot().ok().map(|sysroot| {
            let host = format!("lib/rustlib/{}-unknown-linux-gnu/bin/rust-lld", std::env::consts::ARCH);
            sysroot.join(host)
        });
        let own = beside_rustc.filter(|path| path.is_file());
        if own.is_some() && matches!(self, Self::Active { .. }) {
            return Ok(Vec::new());
        }
        let linker = match own {
            Some(path) => path,
            None => {
                if process::read(process::command("ld.lld").arg("--version")).is_err() {
                    install::packages(&["lld"])?;
                }
                PathBuf::from("ld.lld")
            }
        };
        Ok(vec![format!("-Clinker={}", linker.display()), "-Clinker-flavor=ld.lld".into()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variable_chooses() {
        assert_eq!(Choice::from_variable(None), Ok(Choice::First));
        assert_eq!(Choice::from_variable(Some("")), Ok(Choice::First));
        assert_eq!(Choice::from_variable(Some("rustup")), Ok(Choice::Rustup));
        assert_eq!(Choice::from_variable(Some("debian")), Ok(Choice::Debian));
        assert!(Choice::from_variable(Some("Debian")).is_err());
    }

    #[test]
    fn minor_versions_are_read() {
        assert_eq!(minor_version("rustc 1.96.0 (ac68faa20 2026-05-25)"), Some(96));
        assert_eq!(minor_version("1.89"), Some(89));
        assert_eq!(minor_version("rustc 1.97.0-nightly (e50aa6fba 2026-05-19)"), Some(97));
        assert_eq!(minor_version("no version"), None);
    }
}
