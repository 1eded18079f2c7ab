//! `scphd-gpu`: a Monte Carlo study with all runs at once on a GPU, one large filter there, or the same threads on the host.

use clap::{Args, Parser, Subcommand, ValueEnum};
use scphd_gpu::{
    Checked, Cuda, DeviceError, Difference, Emulated, Interpreted, Machine, Modules, Source, Tuning, check, study,
};
use scphd_run::monte_carlo::overview;
use scphd_view::output;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// The exit code if there is no driver or no card.
const NO_DEVICE: u8 = 3;

/// Runs many filters at once, each over a whole scenario; or one large filter.
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
        /// Name of the scenario, in the plane and with one sensor.
        scenario: String,
        /// Number of runs.
        #[arg(long, default_value_t = 100)]
        runs: usize,
        /// Number of different inputs; by default, as many as runs, or as in the thesis.
        #[arg(long, value_name = "M")]
        input_sets: Option<usize>,
        /// Number that is added to all seeds.
        #[arg(long, default_value_t = 0)]
        seed: u64,
        /// Number of runs at a time; by default, as many as the device has memory for.
        #[arg(long, value_name = "K")]
        resident: Option<usize>,
        /// Writes the figures as JSON.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        tuning: Tuning,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Compares the state after every scan with the host's, bit for bit.
    Check {
        #[command(flatten)]
        runs: RunArgs,
        #[command(flatten)]
        tuning: Tuning,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Prints the device; ends with 3 if there is none, as every command does.
    Device {
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Times runs without digests but that of the last state, and one run on one core of the host.
    Time {
        #[command(flatten)]
        runs: RunArgs,
        #[command(flatten)]
        tuning: Tuning,
        #[command(flatten)]
        on: DeviceArgs,
    },
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
}

#[derive(Debug, Args)]
struct DeviceArgs {
    /// The device that runs the threads.
    #[arg(long, value_enum, default_value_t = DeviceName::Emulated)]
    device: DeviceName,
    /// Folder with the modules that `cargo xtask gpu` has built.
    #[arg(long, value_name = "DIR", default_value = "target/xtask/gpu/modules")]
    modules: PathBuf,
    /// Index of the card.
    #[arg(long, default_value_t = 0)]
    card: usize,
    /// Greatest number of threads of a block.
    #[arg(long, value_name = "K", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=1024))]
    block: u32,
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
    /// The same threads on the host.
    Emulated,
    /// The module itself on the host, instruction by instruction, with counts of the instructions.
    Ptx,
}

impl DeviceArgs {
    fn open(&self) -> Result<Box<dyn Machine>, Box<dyn Error>> {
        let modules = Modules::of(&self.modules);
        Ok(match self.device {
            DeviceName::Cuda => Box::new(Cuda::open(&modules, self.card, self.block, self.profile)?),
            DeviceName::Emulated => Box::new(Emulated::default()),
            DeviceName::Ptx => Box::new(Interpreted::open(&modules, self.block, self.watch)?),
        })
    }
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            match error.downcast_ref() {
                Some(DeviceError::NoDriver | DeviceError::NoDevice(_)) => ExitCode::from(NO_DEVICE),
                _ => ExitCode::FAILURE,
            }
        }
    }
}

fn run(command: Command) -> Result<(), Box<dyn Error>> {
    match command {
        Command::MonteCarlo { scenario, runs, input_sets, seed, resident, json, tuning, on } => {
            let source = Source::new(&scenario, tuning)?;
            let plan = source.plan(runs, input_sets, seed)?;
            let mut device = on.open()?;
            let done = study(&mut *device, &source, &plan, resident)?;
            if let Some(path) = json {
                overview::write_json(&path, &done.study)?;
            }
            println!("{}", output::overview::render(&done.study));
            println!(
                "{}: {runs} runs, {} at once, in {:.3} s; a run takes {} bytes",
                device.name(),
                done.took.resident,
                done.took.launched_s,
                done.took.bytes_a_run
            );
            if done.short.runs > 0 {
                println!(
                    "{} runs had too little memory at {} scans: their results are not those of larger memory",
                    done.short.runs, done.short.scans
                );
            }
            Ok(())
        }
        Command::Check { runs, tuning, on } => compare(&runs, tuning, &on, true),
        Command::Time { runs, tuning, on } => compare(&runs, tuning, &on, false),
        Command::Device { on } => {
            println!("{}", on.open()?.name());
            Ok(())
        }
    }
}

/// Compares runs on a device with those on the host: the state after every scan, or the time.
fn compare(
    RunArgs { scenario, runs, scans }: &RunArgs,
    tuning: Tuning,
    on: &DeviceArgs,
    every: bool,
) -> Result<(), Box<dyn Error>> {
    let source = Source::new(scenario, tuning)?;
    let plan = source.plan(*runs, Some(*runs), 1)?;
    let mut device = on.open()?;
    let Checked { took, scans, host_s, digests, differences, peaks: [pages, moving_pages], short } =
        check(&mut *device, &source, &plan, *scans, every)?;
    device.report().into_iter().for_each(|report| println!("{report}"));
    for Difference { seed, scan, host, device } in &differences {
        println!("seed {seed}, scan {scan}: {host:016x} on the host, {device:016x} on the device");
    }
    println!(
        "{scenario} on {}: {runs} runs of {scans} scans, {} at once, in {:.3} s; {digests} digests, {} runs differ; \
         at most {pages} and {moving_pages} pages, {} scans short of room",
        device.name(),
        took.resident,
        took.launched_s,
        differences.len(),
        short.scans
    );
    if !every {
        let (each_ms, host_ms) = (1e3 * took.launched_s / *runs as f64, 1e3 * host_s);
        let times = host_ms / each_ms;
        println!("{each_ms:.3} ms a run; one core of the host: {host_ms:.3} ms a run, {times:.1} times as much");
    }
    if differences.is_empty() { Ok(()) } else { Err("the states of the device are not those of the host".into()) }
}
