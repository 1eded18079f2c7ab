//! Finds a toolchain that can build for a Cortex-M.

use crate::debian::{self, Bundle, Tree};
use crate::firmware::board::TARGETS;
use crate::outcome::Missing;
use crate::{install, noalloc, process, tools};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Duration;

/// The environment variable that selects a kind of toolchain.
pub const CHOICE_VARIABLE: &str = "SCPHD_TARGET_TOOLCHAIN";

/// Time limit: rustup retries for a long time if its server cannot be reached; otherwise it needs seconds.
const DOWNLOAD_LIMIT: Duration = Duration::from_secs(120);

/// Debian's Rust for web browsers, which is kept recent in stable releases, or its ordinary one.
const DEBIAN: Bundle = Bundle {
    name: "rust",
    packages: &[
        &["rustc-web", "cargo-web", "rust-web-src", "rust-web-clippy"],
        &["rustc", "cargo", "rust-src", "rust-clippy"],
    ],
    oldest: OLDEST,
};

/// The oldest supported compiler.
pub const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");

const RUSTUP: &str = "rustup";
const DEBIANS: &str = "debian";

/// A toolchain that can build for a Cortex-M.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Toolchain {
    /// The active one, with the libraries of the targets in this sysroot.
    Active { sysroot: PathBuf },
    /// Debian's, which compiles `core` from its sources; installed, or unpacked to a folder.
    Debian { unpacked: Option<Tree> },
}

/// The result of the search, for later steps.
static FOUND: OnceLock<Result<Toolchain, Missing>> = OnceLock::new();

/// The kind in [`CHOICE_VARIABLE`], if there is one; fails if the value is invalid.
pub fn choice() -> Result<Option<&'static str>, String> {
    kind(&std::env::var(CHOICE_VARIABLE).unwrap_or_default())
}

fn kind(value: &str) -> Result<Option<&'static str>, String> {
    match [RUSTUP, DEBIANS].into_iter().find(|kind| *kind == value) {
        None if !value.is_empty() => Err(format!("{CHOICE_VARIABLE} is `{value}`; it may be `rustup` or `debian`")),
        found => Ok(found),
    }
}

/// A toolchain for the targets of all boards: tries the alternatives in order and prints their results.
pub fn find() -> Result<Toolchain, Missing> {
    FOUND.get_or_init(|| find_for(&TARGETS)).clone()
}

/// A way to obtain a toolchain for some targets.
type Alternative = fn(&[&str]) -> Result<Toolchain, String>;

/// A toolchain for other targets; the search is not cached.
pub fn find_for(targets: &[&str]) -> Result<Toolchain, Missing> {
    let names = targets.join(" and ");
    let choice = choice().map_err(Missing)?;
    println!("looking for a toolchain that builds for {names}");
    // Toolchains that are present come first, then those that have to be fetched.
    let alternatives: [(&str, &str, Alternative); 4] = [
        ("active toolchain", RUSTUP, active),
        ("Debian's packages", DEBIANS, |_| debian_here()),
        ("rustup target add", RUSTUP, add_with_rustup),
        ("Debian's packages, unpacked or installed now", DEBIANS, |_| debian_fetched()),
    ];
    let mut reasons = Vec::new();
    for (name, kind, alternative) in alternatives {
        if choice.is_some_and(|choice| choice != kind) {
            continue;
        }
        // The linker is checked too, so that later link errors are those of an image.
        let found = alternative(targets).and_then(|toolchain| {
            toolchain.linker(&mut Command::new("cargo")).map(|_| toolchain).map_err(|Missing(reason)| reason)
        });
        match found {
            Ok(toolchain) => {
                println!("- {name}: works");
                return Ok(toolchain);
            }
            Err(reason) => {
                println!("- {name}: {reason}");
                reasons.push(format!("{name}: {reason}"));
            }
        }
    }
    Err(Missing(format!("no toolchain for {names} ({})", reasons.join("; "))))
}

/// A toolchain that is present, without fetching anything.
pub fn here(targets: &[&str]) -> Result<Toolchain, String> {
    active(targets).or_else(|reason| debian_here().map_err(|other| format!("{reason}; {other}")))
}

/// The active toolchain, if it has the targets.
fn active(targets: &[&str]) -> Result<Toolchain, String> {
    let sysroot = active_sysroot()?;
    match targets.iter().find(|target| !noalloc::has_core(&sysroot, target)) {
        None => Ok(Toolchain::Active { sysroot }),
        Some(target) => Err(format!("{} has no libraries for {target}", sysroot.display())),
    }
}

pub fn active_sysroot() -> Result<PathBuf, String> {
    process::read(process::rustc().args(["--print", "sysroot"])).map(PathBuf::from)
}

/// Lets rustup fetch the targets for the active toolchain.
fn add_with_rustup(targets: &[&str]) -> Result<Toolchain, String> {
    process::read(process::command("rustup").arg("--version")).map_err(|_| "there is no rustup".to_owned())?;
    println!("setting up: rustup fetches {}, for at most {} s", targets.join(" "), DOWNLOAD_LIMIT.as_secs());
    process::run_for(process::command("rustup").args(["target", "add"]).args(targets), DOWNLOAD_LIMIT)?;
    active(targets)
}

/// Debian's toolchain, if it is installed or was unpacked before.
fn debian_here() -> Result<Toolchain, String> {
    Toolchain::debian(None).or_else(|reason| match debian::unpacked(&DEBIAN) {
        None => Err(reason),
        unpacked => Toolchain::debian(unpacked),
    })
}

/// Debian's toolchain, unpacked to a folder of this project, or installed if that is not possible.
fn debian_fetched() -> Result<Toolchain, String> {
    debian::fetch(&DEBIAN).and_then(|tree| Toolchain::debian(Some(tree))).or_else(|reason| {
        println!("  unpacked: {reason}");
        let installed = install::packages(DEBIAN.packages[0]).and_then(|()| Toolchain::debian(None));
        installed.map_err(|other| format!("{reason}; {other}"))
    })
}

/// The number 96 of "rustc 1.96.0 (…)" or of "1.96".
fn minor_version(text: &str) -> Option<u32> {
    text.split(' ').find_map(|word| word.strip_prefix("1."))?.split('.').next()?.parse().ok()
}

/// Removes flags from the environment, so that a build has only those given here.
pub fn clear_flags(command: &mut Command) {
    command.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
}

impl Toolchain {
    pub fn name(&self) -> &'static str {
        match self {
            Self::Active { .. } => "the active toolchain",
            Self::Debian { unpacked: None } => "Debian's toolchain",
            Self::Debian { unpacked: Some(_) } => "Debian's toolchain, unpacked",
        }
    }

    /// A short name for folders.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Active { .. } => "active",
            Self::Debian { .. } => "debian",
        }
    }

    pub fn compiler(&self) -> Result<String, String> {
        process::read(self.program("rustc").arg("--version"))
    }

    /// A program of the toolchain, independent of the toolchain that runs this program.
    fn program(&self, name: &str) -> Command {
        let Self::Debian { unpacked } = self else {
            return if name == "rustc" { process::rustc() } else { process::command(name) };
        };
        let mut command = process::command(self.path(name));
        for variable in ["CARGO", "RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH", "RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER"] {
            command.env_remove(variable);
        }
        clear_flags(&mut command);
        if let Some(tree) = unpacked {
            tree.equip(&mut command);
        }
        command
    }

    fn path(&self, program: &str) -> PathBuf {
        match self {
            Self::Debian { unpacked: Some(tree) } => tree.path("usr/bin").join(program),
            Self::Debian { unpacked: None } => Path::new("/usr/bin").join(program),
            Self::Active { .. } => program.into(),
        }
    }

    /// Debian's toolchain in a tree or in the system, if it is present, recent enough, and has the sources of `core`.
    fn debian(unpacked: Option<Tree>) -> Result<Self, String> {
        let toolchain = Self::Debian { unpacked };
        for program in ["cargo", "rustc"].map(|name| toolchain.path(name)) {
            if !program.is_file() {
                return Err(format!("{} is missing", program.display()));
            }
        }
        let version = toolchain.compiler()?;
        if minor_version(&version).is_none_or(|minor| Some(minor) < minor_version(OLDEST)) {
            return Err(format!("{} is `{version}`, older than {OLDEST}", toolchain.path("rustc").display()));
        }
        // The packages link the sources to the place that `-Zbuild-std` expects.
        let sysroot = process::read(toolchain.program("rustc").args(["--print", "sysroot"]))?;
        let sources = Path::new(&sysroot).join("lib/rustlib/src/rust/library/core/Cargo.toml");
        if sources.is_file() { Ok(toolchain) } else { Err(format!("{} is missing", sources.display())) }
    }

    /// Whether it has clippy; the active toolchain is asked elsewhere.
    pub fn has_clippy(&self) -> bool {
        matches!(self, Self::Active { .. }) || self.path("cargo-clippy").is_file()
    }

    /// `cargo build`, `rustc` or `clippy`, only with flags of the caller. `libraries` are built by a toolchain that has none for the
    /// target.
    pub fn cargo(&self, command: &str, libraries: &str) -> Command {
        if let Self::Active { .. } = self {
            let mut cargo = process::cargo();
            clear_flags(&mut cargo);
            cargo.arg(command);
            return cargo;
        }
        let mut cargo = self.program(if command == "clippy" { "cargo-clippy" } else { "cargo" });
        // Building `core` from its sources is an unstable feature, and this is a stable cargo.
        cargo.env("RUSTC_BOOTSTRAP", "1").env("CARGO", self.path("cargo")).env("RUSTC", self.path("rustc"));
        cargo.arg(command).arg(format!("-Zbuild-std={libraries}"));
        cargo
    }

    /// Sets the bare-metal linker of a build, if the toolchain does not find its own. Returns the flags for its compiler.
    pub fn linker(&self, build: &mut Command) -> Result<Vec<String>, Missing> {
        if matches!(self, Self::Active { .. }) && beside_rustc().is_some() {
            return Ok(Vec::new());
        }
        let linker = linker(build, "ld.lld")?;
        Ok(vec![format!("-Clinker={}", linker.display()), "-Clinker-flavor=ld.lld".into()])
    }
}

/// The linker of the active toolchain, or LLVM's with this name, for which `build` is prepared.
pub fn linker(build: &mut Command, name: &str) -> Result<PathBuf, Missing> {
    if let Some(path) = beside_rustc() {
        return Ok(path);
    }
    let lld = tools::LLD.obtain()?;
    lld.equip(build);
    Ok(lld.program.with_file_name(name))
}

/// The linker of the active toolchain, if it has one.
pub fn beside_rustc() -> Option<PathBuf> {
    let host = host().ok()?;
    let path = active_sysroot().ok()?.join(format!("lib/rustlib/{host}/bin/rust-lld"));
    path.is_file().then_some(path)
}

/// The default target of the active compiler.
pub fn host() -> Result<String, String> {
    let text = process::read(process::rustc().arg("-vV"))?;
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "the compiler does not name its host".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variable_selects_the_toolchain() {
        assert_eq!((kind(""), kind("rustup"), kind("debian")), (Ok(None), Ok(Some(RUSTUP)), Ok(Some(DEBIANS))));
        assert!(kind("Debian").is_err());
    }

    #[test]
    fn minor_versions_are_read() {
        assert_eq!(minor_version("rustc 1.96.0 (ac68faa20 2026-05-25)"), Some(96));
        assert_eq!(minor_version("1.89"), Some(89));
        assert_eq!(minor_version("rustc 1.97.0-nightly (e50aa6fba 2026-05-19)"), Some(97));
        assert_eq!(minor_version("no version"), None);
    }
}
