//! The core, built for a Cortex-M: which toolchain can do it here, and the build itself.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::noalloc;
use crate::process;
use crate::steps::Outcome;

/// Cortex-M4F and M7 with an FPU. It has neither std nor an operating system, so whatever builds for it is no_std.
const TARGET: &str = "thumbv7em-none-eabihf";

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

/// A toolchain that can build for [`TARGET`].
enum Toolchain {
    /// The active one, which has the target's libraries under this sysroot.
    Active { sysroot: PathBuf },
    /// Debian's, which compiles `core` from its sources.
    Debian,
}

/// The step: find a toolchain, build, check.
pub fn step() -> Outcome {
    match find().and_then(|toolchain| build(&toolchain)) {
        Ok(note) => Outcome::Passed(note),
        Err(reason) => Outcome::Failed(reason),
    }
}

/// Tries the alternatives in their order and says what became of each.
fn find() -> Result<Toolchain, String> {
    let choice = Choice::from_variable(std::env::var(CHOICE_VARIABLE).ok().as_deref())?;
    println!("looking for a toolchain that builds for {TARGET}");
    if choice != Choice::Debian {
        for (name, alternative) in
            [("active toolchain", active as fn() -> Result<Toolchain, String>), ("rustup target add", add_with_rustup)]
        {
            if let Some(toolchain) = report(name, alternative()) {
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
        Choice::First => format!("no toolchain here builds for {TARGET}; see the reasons above"),
        _ => format!("no toolchain that {CHOICE_VARIABLE} allows builds for {TARGET}; see the reasons above"),
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

/// The active toolchain, if it has the target, whoever installed it.
fn active() -> Result<Toolchain, String> {
    let sysroot = process::read(process::command(noalloc::rustc()).args(["--print", "sysroot"]))?;
    let sysroot = PathBuf::from(sysroot);
    if noalloc::has_core(&sysroot, TARGET) {
        Ok(Toolchain::Active { sysroot })
    } else {
        Err(format!("{} has no libraries for {TARGET}", sysroot.display()))
    }
}

/// Has rustup fetch the target for the active toolchain.
fn add_with_rustup() -> Result<Toolchain, String> {
    process::read(process::command("rustup").arg("--version")).map_err(|_| "there is no rustup".to_owned())?;
    println!("setting up: rustup fetches {TARGET}, for at most {} s", DOWNLOAD_LIMIT.as_secs());
    process::run_for(process::command("rustup").args(["target", "add", TARGET]), DOWNLOAD_LIMIT)?;
    active()
}

/// Debian's Rust for building web browsers, which is kept recent in stable releases; installed if that is allowed.
fn debian() -> Result<Toolchain, String> {
    match debian_usable() {
        Ok(()) => Ok(Toolchain::Debian),
        Err(reason) => {
            println!("  not yet: {reason}");
            install_debian_packages()?;
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

fn install_debian_packages() -> Result<(), String> {
    process::read(process::command("apt-get").arg("--version")).map_err(|_| "there is no apt-get".to_owned())?;
    let packages = DEBIAN_PACKAGES.join(" ");
    if process::read(process::command("id").arg("-u"))? != "0" {
        return Err(format!("only root can install {packages}"));
    }
    println!("setting up: apt-get installs {packages}");
    let mut update = apt_get();
    process::run(update.arg("update"))?;
    let mut install = apt_get();
    // Without --no-remove apt would replace another Rust the machine's owner has chosen.
    install.args(["install", "-y", "--no-install-recommends", "--no-remove"]).args(DEBIAN_PACKAGES);
    process::run(&mut install)
}

/// apt-get with limits of its own on the network; killing it from outside could leave packages half configured.
fn apt_get() -> Command {
    let mut command = process::command("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command.args(["-q", "-o", "Acquire::Retries=1", "-o", "Acquire::http::Timeout=30"]);
    command.args(["-o", "Acquire::https::Timeout=30"]);
    command
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

/// Builds the core where there is no `alloc`, and looks at the library.
fn build(toolchain: &Toolchain) -> Result<String, String> {
    let (name, dir, mut cargo) = match toolchain {
        Toolchain::Active { sysroot } => {
            let dir = process::own_target_dir("target-active");
            println!("setting up: a sysroot with core and without alloc, in {}", dir.display());
            let core_only = noalloc::core_only_sysroot(sysroot, TARGET, &dir.join("core-only"))?;
            let mut cargo = process::cargo();
            clear_flags(&mut cargo);
            // The encoded form survives a path with a space in it.
            cargo.env("CARGO_ENCODED_RUSTFLAGS", format!("--sysroot={}", core_only.display()));
            cargo.arg("build");
            ("the active toolchain", dir, cargo)
        }
        Toolchain::Debian => {
            let mut cargo = debian_command(DEBIAN_CARGO);
            // Building `core` from its sources is an unstable feature of cargo, and this is a stable cargo.
            cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTC", DEBIAN_RUSTC);
            cargo.args(["build", "-Zbuild-std=core"]);
            ("Debian's toolchain", process::own_target_dir("target-debian"), cargo)
        }
    };
    cargo.args(["-p", "scphd", "--target", TARGET, "--release", "--target-dir"]).arg(&dir);
    process::run(&mut cargo)?;

    let library = dir.join(TARGET).join("release/libscphd.rlib");
    noalloc::check_library(&library)?;
    println!("no alloc to link with, and no allocator symbol in {}", library.display());
    Ok(format!("with {name}"))
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
