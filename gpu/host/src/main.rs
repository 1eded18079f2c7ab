//! `scphd-gpu`: compares runs on a GPU, or by an interpreter of the same module, with the host.

mod check;
mod source;
#[cfg(test)]
mod tests;

use check::check;
use clap::{Parser, ValueEnum};
use scphd_gpu::{Cuda, Failure, Interpreted, MODULES, Machine};
use source::{Source, Tuning};
use std::path::PathBuf;
use std::process::ExitCode;

/// The exit code if there is no driver or no card.
const NO_DEVICE: u8 = 3;

/// Compares runs on a GPU with the host. Ends with 3 if there is no card.
#[derive(Debug, Parser)]
#[command(name = "scphd-gpu", version, max_term_width = 100)]
struct Cli {
    /// What is compared.
    what: What,
    /// Name of the scenario, in the plane and with one sensor, or the folder of a recorded log.
    scenario: String,
    /// Number of runs, with seeds from 1 on.
    #[arg(long, default_value_t = 1)]
    runs: usize,
    /// Number of scans of each run.
    #[arg(long, default_value_t = 300)]
    scans: usize,
    #[command(flatten)]
    tuning: Tuning,
    /// The device that runs the threads.
    #[arg(long, value_enum, default_value_t = DeviceName::Cuda)]
    device: DeviceName,
    /// Folder of the module that `cargo xtask module` has built.
    #[arg(long, value_name = "DIR", default_value = MODULES)]
    modules: PathBuf,
    /// On a card, waits for every launch and prints the time of every kernel; the total time is longer then.
    #[arg(long)]
    profile: bool,
    /// If the module is executed on the host, refuses two threads of a launch at the same byte if one of them writes it. Takes 17
    /// times the memory.
    #[arg(long)]
    watch: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// State and outputs after every scan with the host's, bit for bit.
    Check,
    /// The time of runs without digests but that of the last state with that of one run on one core of the host.
    Time,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DeviceName {
    /// An NVIDIA card.
    Cuda,
    /// The module itself on the host, instruction by instruction, with counts of the instructions.
    Ptx,
}

fn main() -> ExitCode {
    match compare(Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            if matches!(failure, Failure::NoDevice(_)) { ExitCode::from(NO_DEVICE) } else { ExitCode::FAILURE }
        }
    }
}

fn compare(Cli { what, scenario, runs, scans, tuning, device, modules, profile, watch }: Cli) -> Result<(), Failure> {
    let source = Source { scenario, tuning };
    source.input(1, 1)?;
    let mut device: Box<dyn Machine> = match device {
        DeviceName::Cuda => Box::new(Cuda::open(&modules, profile)?),
        DeviceName::Ptx => Box::new(Interpreted::open(&modules, watch)?),
    };
    let (took, all) = check(&mut *device, &source, (runs, 1), scans, what == What::Check)?;
    let (host_s, compared): (f64, usize) =
        (all.first().map_or(0.0, |first| first.0), all.iter().map(|(_, scans, _)| scans).sum());
    let differences: Vec<String> = all.into_iter().filter_map(|(.., difference)| difference).collect();
    device.report().iter().chain(&differences).for_each(|line| println!("{line}"));
    println!(
        "{} on {}: {runs} runs of {scans} scans, {} at once, in {:.3} s; {compared} scans compared, {} runs differ; {} scans \
         short of room",
        source.scenario,
        device.name(),
        took.resident,
        took.launched_s,
        differences.len(),
        took.short[1]
    );
    if what == What::Time {
        let (each_ms, host_ms) = (1e3 * took.launched_s / runs as f64, 1e3 * host_s);
        let times = host_ms / each_ms;
        println!("{each_ms:.3} ms a run; one core of the host: {host_ms:.3} ms a run, {times:.1} times as much");
    }
    if differences.is_empty() { Ok(()) } else { Err(Failure::Other("the device differs from the host".into())) }
}
