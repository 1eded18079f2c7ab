//! `scphd-gpu`: Monte Carlo studies with one thread for each candidate or map of many filters, or one block for each of many joint
//! maps, and single large filters, on a GPU or by an interpreter of the same module.
//!
//! The measurements of all runs are simulated here and stored in flat buffers ([`batch`]). A device processes all scans. Its outputs
//! are replayed ([`played`]) to the simulator's scores as if a filter had produced them. `docs/gpu.md` describes the layout.

mod batch;
mod cuda;
mod device;
mod failure;
mod interpreted;
mod played;
mod source;
mod study;
#[cfg(test)]
mod tests;

use clap::{Args, Parser, Subcommand, ValueEnum};
use cuda::Cuda;
use device::Machine;
use failure::Failure;
use interpreted::Interpreted;
use scphd_run::monte_carlo::overview;
use scphd_view::output;
use source::{Source, Tuning};
use std::path::PathBuf;
use std::process::ExitCode;
use study::{Checked, check, study};

/// The exit code if there is no driver or no card.
const NO_DEVICE: u8 = 3;

/// Runs many filters at once, each over a whole scenario; or one large filter. Ends with 3 if there is no card.
#[derive(Debug, Parser)]
#[command(name = "scphd-gpu", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs a scenario many times and prints means over the runs: those of `scphd-sim monte-carlo SCENARIO --filter core` or `joint`,
    /// except for the times of scans.
    MonteCarlo {
        /// Name of the scenario, in the plane and with one sensor, or the folder of a recorded log.
        scenario: String,
        /// Number of runs.
        #[arg(long, default_value_t = 100)]
        runs: usize,
        /// Number that is added to all seeds.
        #[arg(long, default_value_t = 0)]
        seed: u64,
        /// Writes the figures as JSON.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        tuning: Tuning,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Compares state and outputs after every scan with the host's, bit for bit.
    Check(RunArgs),
    /// Times runs without digests but that of the last state, and one run on one core of the host.
    Time(RunArgs),
}

#[derive(Debug, Args)]
struct RunArgs {
    /// Name of the scenario, or the folder of a recorded log.
    scenario: String,
    /// Number of runs, with seeds from 1 on.
    #[arg(long, default_value_t = 1)]
    runs: usize,
    /// Number of scans of each run.
    #[arg(long, default_value_t = 300)]
    scans: usize,
    #[command(flatten)]
    tuning: Tuning,
    #[command(flatten)]
    on: DeviceArgs,
}

#[derive(Debug, Args)]
struct DeviceArgs {
    /// The device that runs the threads.
    #[arg(long, value_enum, default_value_t = DeviceName::Cuda)]
    device: DeviceName,
    /// Folder of the module that `cargo xtask module` has built.
    #[arg(long, value_name = "DIR", default_value = "target/xtask/gpu/modules")]
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
enum DeviceName {
    /// An NVIDIA card.
    Cuda,
    /// The module itself on the host, instruction by instruction, with counts of the instructions.
    Ptx,
}

impl DeviceArgs {
    fn open(self) -> Result<Box<dyn Machine>, Failure> {
        Ok(match self.device {
            DeviceName::Cuda => Box::new(Cuda::open(&self.modules, self.profile)?),
            DeviceName::Ptx => Box::new(Interpreted::open(&self.modules, self.watch)?),
        })
    }
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::MonteCarlo { scenario, runs, seed, json, tuning, on } => {
            Source::new(&scenario, tuning).and_then(|source| monte_carlo(&source, (runs, seed), json, on))
        }
        Command::Check(args) => compare(args, true),
        Command::Time(args) => compare(args, false),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            if matches!(failure, Failure::NoDevice(_)) { ExitCode::from(NO_DEVICE) } else { ExitCode::FAILURE }
        }
    }
}

fn monte_carlo(
    source: &Source,
    (runs, seed): (usize, u64),
    json: Option<PathBuf>,
    on: DeviceArgs,
) -> Result<(), Failure> {
    let plan = source.plan(runs, None, seed)?;
    let mut device = on.open()?;
    let (study, took) = study(&mut *device, source, &plan)?;
    if let Some(path) = json {
        overview::write_json(&path, &study).map_err(|error| Failure::Other(error.to_string()))?;
    }
    println!("{}", output::overview::render(&study));
    let (name, resident, seconds, bytes) = (device.name(), took.resident, took.launched_s, took.bytes_a_run);
    println!("{name}: {runs} runs, {resident} at once, in {seconds:.3} s; a run takes {bytes} bytes");
    let [runs, scans] = took.short;
    if runs > 0 {
        println!("{runs} runs had too little memory at {scans} scans: their results are not those of larger memory");
    }
    Ok(())
}

/// Compares runs on a device with those on the host: the state after every scan, or the time.
fn compare(RunArgs { scenario, runs, scans, tuning, on }: RunArgs, every: bool) -> Result<(), Failure> {
    let source = Source::new(&scenario, tuning)?;
    let plan = source.plan(runs, Some(runs), 1)?;
    let mut device = on.open()?;
    let checked = check(&mut *device, &source, &plan, scans, every)?;
    let Checked { took, host_s, scans: compared, differences } = checked;
    device.report().into_iter().chain(differences.iter().cloned()).for_each(|line| println!("{line}"));
    println!(
        "{scenario} on {}: {runs} runs of {scans} scans, {} at once, in {:.3} s; {compared} scans compared, {} runs differ; \
         {} scans short of room",
        device.name(),
        took.resident,
        took.launched_s,
        differences.len(),
        took.short[1]
    );
    if !every {
        let (each_ms, host_ms) = (1e3 * took.launched_s / runs as f64, 1e3 * host_s);
        let times = host_ms / each_ms;
        println!("{each_ms:.3} ms a run; one core of the host: {host_ms:.3} ms a run, {times:.1} times as much");
    }
    if differences.is_empty() { Ok(()) } else { Err(Failure::Other("the device differs from the host".into())) }
}
