//! Runs a C program on QEMU's boards, which must reach the same states as the host.

use super::archive;
use crate::firmware::board::{Board, EMULATED};
use crate::firmware::emulator;
use crate::outcome::Stop;
use crate::process;
use crate::tools::{ARM_GCC, Tool};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(600);

/// A processor, and the number of scans that it replays.
struct Processor {
    board: Board,
    target: &'static str,
    flags: &'static [&'static str],
    scans: u32,
    /// Index of its figure in the flash column of docs/c.md.
    column: usize,
}

const PROCESSORS: [Processor; 2] = [
    Processor {
        board: EMULATED[0],
        target: "thumbv7em-none-eabihf",
        flags: &["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"],
        scans: 300,
        column: 0,
    },
    // With software floating point.
    Processor {
        board: EMULATED[1],
        target: "thumbv7em-none-eabi",
        flags: &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=soft"],
        scans: 40,
        column: 1,
    },
];

/// Builds the program with the archive of each target, and runs it.
pub fn check(inputs: &Path) -> Result<(), Stop> {
    let (gcc, qemu) = (ARM_GCC.obtain_that(&links)?, emulator::prepare()?);
    println!("{} ({})", gcc.version, gcc.place());
    for processor in &PROCESSORS {
        let dir = archive::folder(processor.target);
        let program = dir.join("replay.elf");
        let scans = format!("-DREPLAY_SCANS={}", processor.scans);
        let mut build = compile(&gcc, processor)?;
        build.arg(format!("-DREPLAY_FILE=\"{}\"", inputs.display())).arg(scans);
        build.arg(capi().join("tests/c/replay.c")).arg(dir.join(archive::NAME)).args(["-lm", "-o"]).arg(&program);
        process::run_or_quote(&mut build)?;
        super::flash::check(&dir, processor.column, || compile(&gcc, processor))?;
        let mut run = qemu.command();
        run.args(["-machine", processor.board.name, "-nographic", "-monitor", "none", "-serial", "none"]);
        run.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(&program);
        process::run_for(&mut run, LIMIT)?;
    }
    Ok(())
}

/// Fails if the compiler or its C library is incomplete for one of the processors.
fn links(gcc: &Tool) -> Result<(), String> {
    let folder = process::own_target_dir("capi-trial");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for processor in &PROCESSORS {
        let program = folder.join(format!("{}.elf", processor.board.name));
        let mut build = compile(gcc, processor)?;
        process::read(build.arg(capi().join("tests/c/trial.c")).args(["-lm", "-o"]).arg(program))?;
    }
    Ok(())
}

fn capi() -> PathBuf {
    process::root().join("bindings/capi")
}

/// A command that compiles the startup code of a board; the program and its libraries are to be added.
fn compile(gcc: &Tool, processor: &Processor) -> Result<Command, String> {
    let mut command = gcc.command();
    command.args(processor.flags).args(["-std=c11", "-O2", "-ffunction-sections", "-nostartfiles"]);
    command.arg("-I").arg(capi().join("include")).arg("-I").arg(capi().join("tests/c"));
    command
        .arg("-T")
        .arg(capi().join("tests/c/board.ld"))
        .arg(format!("-Wl,--defsym=RAM_START={:#x}", processor.board.ram));
    // The C library has no note about executable stacks, which a board does not need.
    command.args(["-Wl,--gc-sections", "-Wl,--no-warn-execstack"]);
    match &gcc.tree {
        None => command.arg("--specs=rdimon.specs"),
        // The compiler does not find its C library in an unpacked tree.
        Some(tree) => {
            let kind = process::read(gcc.command().args(processor.flags).arg("-print-multi-directory"))?;
            let library = tree.path("usr/lib/arm-none-eabi/newlib").join(kind);
            if !library.is_dir() {
                return Err(format!("no C library in {}", library.display()));
            }
            command.arg("-isystem").arg(tree.path("usr/include/newlib")).arg("-B").arg(&library);
            command.arg("-L").arg(&library).arg(format!("--specs={}", library.join("rdimon.specs").display()))
        }
    };
    command.arg(capi().join("tests/c/board.c"));
    Ok(command)
}
