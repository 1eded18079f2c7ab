//! The C interface: its archive, its header, and C programs that use both.

pub mod archive;
mod board;
mod flash;
mod header;
mod install;
mod programs;
mod symbols;
mod workspace;

use crate::outcome::{Missing, Outcome, Stop};
use crate::{files, process, toolchain};
use archive::Builder;
use std::fs::{self, File};
use std::path::PathBuf;
use std::process::Stdio;
use std::thread;
use workspace::{cargo, tools_dir};

pub use install::{Place, install};
pub use programs::Compiler;
pub use workspace::TARGETS;

/// Compiles and runs C programs with the header and the archive for the host.
pub fn quick() -> Result<Outcome, Stop> {
    let functions = header::functions()?;
    let host = archive::make(&Builder::Host, &functions)?;
    let c = Compiler::c()?;
    println!("{}", c.version());
    header::check()?;
    programs::check(&c, &host.join(archive::NAME), &stream()?, &host)?;
    Ok(Outcome::Passed(format!("{} functions", functions.len())))
}

pub fn step() -> Result<Outcome, Stop> {
    if !cfg!(target_os = "linux") {
        return Err(Missing("the archive is made of ELF objects".into()).into());
    }
    let functions = header::functions()?;
    let bare = toolchain::find_for(&TARGETS);
    let mut missing = Vec::new();
    // Linking an archive uses one core.
    let (hosts, boards) = thread::scope(|scope| {
        let hosts = scope.spawn(|| {
            let archive = archive::make(&Builder::Host, &functions)?;
            header::check()?;
            process::run(&mut cargo("test"))?;
            Ok::<_, Stop>((archive, stream()?))
        });
        let boards = match &bare {
            Ok(toolchain) => TARGETS
                .iter()
                .try_for_each(|target| archive::make(&Builder::Bare(toolchain, target), &functions).map(drop)),
            Err(missing) => Err(missing.clone().into()),
        };
        (hosts.join().map_err(|_| "building for the host ended with a panic"), boards)
    });
    let (host, inputs) = hosts??;
    note(boards, &mut missing)?;

    let archive = host.join(archive::NAME);
    match Compiler::c() {
        Err(Missing(reason)) => missing.push(reason),
        Ok(c) => {
            println!("{}", c.version());
            programs::check(&c, &archive, &inputs, &host)?;
            install::check(&archive, &c, &host)?;
            note(programs::check_memory(&host), &mut missing)?;
        }
    }
    match Compiler::cpp() {
        Err(Missing(reason)) => missing.push(reason),
        Ok(cpp) => programs::check_cpp(&cpp, &archive, &inputs, &host)?,
    }
    if bare.is_ok() {
        note(board::check(&inputs), &mut missing)?;
    }
    let size = files::bytes(&archive)?.len() / 1024;
    let note = format!("{} functions, archive of {size} KiB", functions.len());
    Ok(Outcome::without(&missing.join("; "), note))
}

/// Collects the reason if something is missing; other errors are returned.
fn note(result: Result<(), Stop>, missing: &mut Vec<String>) -> Result<(), Stop> {
    match result {
        Err(Stop::Missing(reason)) => {
            missing.push(reason);
            Ok(())
        }
        other => other,
    }
}

/// Writes the inputs to a file, with the states of the Rust library after every scan.
pub fn stream() -> Result<PathBuf, String> {
    let path = tools_dir().join("drive.txt");
    fs::create_dir_all(tools_dir()).map_err(|error| format!("{}: {error}", tools_dir().display()))?;
    let file = File::create(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    process::run(cargo("run").args(["--package", "scphd-drive"]).stdout(Stdio::from(file)))?;
    Ok(path)
}
