//! The archive: one object with only the functions of the header as global symbols.
//!
//! The compiler's archive contains code that all Rust programs share: a panic handler, helpers of the compiler. Two such archives
//! in one program would conflict. Therefore the library and the helpers that it needs are linked into one object, everything else
//! is removed, and all symbols except those of the header are made local.

use super::symbols;
use crate::outcome::{Missing, Stop};
use crate::toolchain::{self, Toolchain};
use crate::tools::{LLD, OBJCOPY};
use crate::{files, process};
use ar_archive_writer::{ArchiveKind, DEFAULT_OBJECT_READER, NewArchiveMember, write_archive_to_stream};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::Command;

pub const NAME: &str = "libscphd.a";

/// The toolchain for the build.
pub enum Builder<'a> {
    /// The active compiler, for its host.
    Host,
    /// A toolchain and a target without an operating system.
    Bare(&'a Toolchain, &'static str),
}

/// The folder of the archive for a target.
pub fn folder(target: &str) -> PathBuf {
    process::own_target_dir(&format!("capi-{target}"))
}

/// Builds the archive, checks its symbols, and returns its folder.
pub fn make(builder: &Builder<'_>, functions: &BTreeSet<String>) -> Result<PathBuf, Stop> {
    let host;
    let (mut cargo, target) = match builder {
        Builder::Host => {
            host = toolchain::host()?;
            let mut cargo = process::cargo();
            toolchain::clear_flags(&mut cargo);
            cargo.arg("rustc");
            (cargo, host.as_str())
        }
        Builder::Bare(toolchain, target) => {
            let mut cargo = toolchain.cargo("rustc", "core");
            // Gives a tenth less flash, for a hundredth more instructions.
            cargo.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "2");
            (cargo, *target)
        }
    };
    let dir = folder(target);
    cargo.args(["--quiet", "--release", "--locked", "--manifest-path", "bindings/capi/Cargo.toml", "--lib"]);
    cargo.args(["--features", "archive", "--crate-type", "staticlib", "--target", target, "--target-dir"]).arg(&dir);
    process::run(&mut cargo)?;
    let built = dir.join(target).join("release/libscphd_capi.a");
    let object = dir.join("scphd.o");
    link(&built, functions, &object)?;
    localise(functions, &object)?;
    let bytes = files::bytes(&object)?;
    symbols::check(&bytes, functions)?;
    write(bytes, &dir.join(NAME))?;
    Ok(dir)
}

/// Links the functions of the header with all that they need into one object.
fn link(built: &Path, functions: &BTreeSet<String>, object: &Path) -> Result<(), Stop> {
    let mut lld = match toolchain::beside_rustc() {
        Some(path) => {
            let mut lld = process::command(path);
            lld.args(["-flavor", "gnu"]);
            lld
        }
        None => LLD.obtain()?.command(),
    };
    lld.args(["-r", "--gc-sections", "--strip-debug"]).args(functions.iter().flat_map(|name| ["-u", name]));
    process::read(lld.arg(built).arg("-o").arg(object))?;
    Ok(())
}

/// Makes all symbols local except those of the header.
fn localise(functions: &BTreeSet<String>, object: &Path) -> Result<(), Stop> {
    let list = object.with_extension("symbols");
    let names: Vec<&str> = functions.iter().map(String::as_str).collect();
    files::write(&list, names.join("\n"))?;
    let mut option = std::ffi::OsString::from("--keep-global-symbols=");
    option.push(&list);
    process::read(objcopy()?.arg(option).arg(object))?;
    Ok(())
}

/// The objcopy of the active toolchain, or LLVM's.
fn objcopy() -> Result<Command, Missing> {
    let own = || -> Option<Command> {
        let program = toolchain::beside_rustc()?.with_file_name("rust-objcopy");
        let libraries = toolchain::active_sysroot().ok()?.join("lib");
        let command = || {
            let mut command = process::command(&program);
            command.env("LD_LIBRARY_PATH", &libraries);
            command
        };
        process::read(command().arg("--version")).ok()?;
        Some(command())
    };
    own().map_or_else(|| Ok(OBJCOPY.obtain()?.command()), Ok)
}

/// Writes an archive with one object, and with the symbol index for linkers.
fn write(object: Vec<u8>, archive: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", archive.display());
    let member = NewArchiveMember::new(object, &DEFAULT_OBJECT_READER, "scphd.o".into());
    let mut file = BufWriter::new(File::create(archive).map_err(failed)?);
    write_archive_to_stream(&mut file, &[member], ArchiveKind::Gnu, false, None).map_err(failed)
}
