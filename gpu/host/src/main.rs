//! `scphd-gpu`: a Monte Carlo study with all runs at once on a GPU, one large filter there, or the same threads on the host.

use clap::{Args, Parser, Subcommand, ValueEnum};
use scphd_gpu::{
    Checked, Cuda, Device, DeviceError, Difference, Emulated, Execution, Interpreted, LargeRun, Modules, Source,
    Tuning, drive_on_host, large, study, time,
};
use scphd_run::monte_carlo::overview;
use scphd_view::output;
use std::error::Error;
use std::iter::successors;
use std::ops::RangeInclusive;
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
    /// Runs a scenario many times and prints means over the runs: those of `scphd-sim monte-carlo SCENARIO --filter core`, except
    /// for the times of scans.
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
        tuning: TuningArgs,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Compares the state after every scan with the host's, bit for bit.
    Check {
        /// Name of the scenario, or the folder of a recorded log.
        scenario: String,
        /// Number of runs, with seeds from 1 on.
        #[arg(long, default_value_t = 4)]
        runs: u64,
        /// Number of scans of each run.
        #[arg(long, default_value_t = 300)]
        scans: usize,
        #[command(flatten)]
        tuning: TuningArgs,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Prints the device; ends with 3 if there is none, as every command does.
    Device {
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Times this number of runs of a scenario, without digests, and one run on one core of the host.
    Time {
        /// Name of the scenario, or the folder of a recorded log.
        scenario: String,
        /// Number of runs.
        #[arg(long, default_value_t = 1024)]
        runs: usize,
        #[command(flatten)]
        tuning: TuningArgs,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Compares the state of one large filter after every scan with that of the library's own scan, bit for bit.
    LargeCheck {
        /// Name of the scenario, or the folder of a recorded log.
        scenario: String,
        /// Number of scans.
        #[arg(long, default_value_t = 300)]
        scans: usize,
        /// Seed of scenario and filter.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        #[command(flatten)]
        tuning: TuningArgs,
        #[command(flatten)]
        on: DeviceArgs,
    },
    /// Times one large filter of 32 particles, of twice as many and so on, on the device and on one core of the host.
    LargeTime {
        /// Name of the scenario, or the folder of a recorded log.
        scenario: String,
        /// Number of scans of each filter.
        #[arg(long, default_value_t = 30)]
        scans: usize,
        /// The smallest number of particles.
        #[arg(long, value_name = "N", default_value_t = 32)]
        least: usize,
        /// The greatest number of particles.
        #[arg(long, value_name = "N", default_value_t = 16_384)]
        most: usize,
        #[command(flatten)]
        tuning: TuningArgs,
        #[command(flatten)]
        on: DeviceArgs,
    },
}

#[derive(Debug, Args)]
struct TuningArgs {
    /// Number of particles.
    #[arg(long, value_name = "N")]
    particles: Option<usize>,
    /// Number of samples of each particle.
    #[arg(long, value_name = "M")]
    samples: Option<usize>,
    /// Whether features may move.
    #[arg(long, value_enum)]
    moving: Option<Switch>,
    /// Settings in TOML that replace those of the scenario.
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
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
    /// Threads of a warp if the module is executed on the host; 1 is the fastest there, and cards have 32.
    #[arg(long, value_name = "K", default_value_t = 32)]
    warp: u32,
    /// If the module is executed on the host, refuses two threads of a launch at the same byte if one of them writes it. Takes 17
    /// times the memory.
    #[arg(long)]
    watch: bool,
    /// Threads of the host for the emulated device; by default, one for each core.
    #[arg(long, value_name = "K")]
    threads: Option<usize>,
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

impl TuningArgs {
    fn source(&self, scenario: &str) -> Result<Source, Box<dyn Error>> {
        let file =
            |path: &PathBuf| std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()));
        let settings = self.settings.as_ref().map(file).transpose()?;
        let moving = self.moving.map(|moving| moving == Switch::On);
        let tuning = Tuning { particles: self.particles, samples: self.samples, moving, settings };
        Ok(Source::new(scenario, tuning)?)
    }
}

impl DeviceArgs {
    fn open(&self) -> Result<Box<dyn Device>, Box<dyn Error>> {
        Ok(match self.device {
            DeviceName::Cuda => Box::new(Cuda::open(&Modules::of(&self.modules), self.card, self.block, self.profile)?),
            DeviceName::Emulated => Box::new(Emulated::new(self.threads)),
            DeviceName::Ptx => {
                let execution = Execution { block: self.block, warp: self.warp, watch: self.watch };
                Box::new(Interpreted::open(&Modules::of(&self.modules), execution)?)
            }
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
            let source = tuning.source(&scenario)?;
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
        Command::Check { scenario, runs, scans, tuning, on } => {
            let source = tuning.source(&scenario)?;
            let mut device = on.open()?;
            let seeds: Vec<u64> = (1..=runs).collect();
            let checked = Checked::of(&mut *device, &source, &seeds, scans)?;
            device.report().into_iter().for_each(|report| println!("{report}"));
            report(&scenario, device.name(), &checked)
        }
        Command::Device { on } => {
            let device = on.open()?;
            println!("{}", device.name());
            Ok(())
        }
        Command::Time { scenario, runs, tuning, on } => {
            let source = tuning.source(&scenario)?;
            let plan = source.plan(runs, Some(runs), 1)?;
            let mut device = on.open()?;
            let took = time(&mut *device, &source, &plan, None)?;
            let log = source.log(1)?;
            let host_s = drive_on_host(&log, &source.settings(&log)?, 1)?;
            device.report().into_iter().for_each(|report| println!("{report}"));
            let each_s = took.launched_s / runs as f64;
            println!(
                "{scenario}: {runs} runs of {} scans, {} at once, in {:.3} s on {}: {:.3} ms a run; \
                 one core of the host: {:.3} ms a run, {:.1} times as much",
                log.scans.len(),
                took.resident,
                took.launched_s,
                device.name(),
                1e3 * each_s,
                1e3 * host_s,
                host_s / each_s
            );
            Ok(())
        }
        Command::LargeCheck { scenario, scans, seed, tuning, on } => {
            let source = tuning.source(&scenario)?;
            check_large(&mut *on.open()?, &source, seed, scans)
        }
        Command::LargeTime { scenario, scans, least, most, tuning, on } => {
            time_large(&mut *on.open()?, &scenario, tuning, scans, least..=most)
        }
    }
}

/// Compares the state of one large filter after every scan with that of the library's own scan.
fn check_large(device: &mut dyn Device, source: &Source, seed: u64, scans: usize) -> Result<(), Box<dyn Error>> {
    let batch = large(source, seed, scans)?;
    let found = LargeRun::on(device, &batch, 1)?;
    device.report().into_iter().for_each(|report| println!("{report}"));
    let host = LargeRun::alone(&batch, 1)?;
    if let Some(Difference { scan, host, device, .. }) = found.difference(&host, seed) {
        return Err(format!("scan {scan}: {host:016x} on the host, {device:016x} on the device").into());
    }
    let [pages, moving_pages] = found.peak_pages();
    println!(
        "{} particles on {}: {} digests as on the host; at most {pages} and {moving_pages} pages, {} scans short of room",
        batch.particles(),
        device.name(),
        found.results.len(),
        found.short_scans()
    );
    Ok(())
}

/// Times one large filter after the other, each with twice the particles of the one before.
fn time_large(
    device: &mut dyn Device,
    scenario: &str,
    mut tuning: TuningArgs,
    scans: usize,
    range: RangeInclusive<usize>,
) -> Result<(), Box<dyn Error>> {
    println!("{scenario}, {scans} scans with their predictions, on {}", device.name());
    println!("particles   device ms   one core ms   times   short of room");
    for particles in successors(Some(*range.start()), |particles| Some(2 * particles)).take_while(|n| range.contains(n))
    {
        tuning.particles = Some(particles);
        let batch = large(&tuning.source(scenario)?, 1, scans)?;
        let found = LargeRun::on(device, &batch, 0)?;
        device.report().into_iter().for_each(|report| println!("{report}"));
        let host = LargeRun::alone(&batch, 0)?;
        if let Some(Difference { host, device, .. }) = found.difference(&host, 1) {
            return Err(format!("{particles} particles: {host:016x} on the host, {device:016x} on the device").into());
        }
        let times = host.scan_ms / found.scan_ms;
        let short = found.short_scans();
        println!("{particles:>9}   {:>9.3}   {:>11.3}   {times:>5.1}   {short}", found.scan_ms, host.scan_ms);
    }
    Ok(())
}

fn report(scenario: &str, device: &str, checked: &Checked) -> Result<(), Box<dyn Error>> {
    let Checked { digests, differences, launched_s, peak_pages, features_a_scan } = checked;
    let [pages, moving_pages] = peak_pages;
    let [features, movers] = features_a_scan;
    for Difference { seed, scan, host, device } in differences {
        println!("{scenario}, seed {seed}, scan {scan}: {host:016x} on the host, {device:016x} on the device");
    }
    println!(
        "{scenario} on {device}: {digests} digests in {launched_s:.3} s; at most {pages} and {moving_pages} pages, \
         {features:.1} and {movers:.1} estimated features a scan"
    );
    match differences.len() {
        0 => Ok(()),
        differing => Err(format!("{differing} runs differ from the host").into()),
    }
}
