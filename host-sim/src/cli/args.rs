//! The arguments and their help.

use super::failure::Failure;
use clap::{Args, Parser, Subcommand, ValueEnum, value_parser};
use scphd_boards::hil::Port;
use scphd_boards::stream::Recorded;
use scphd_filters::ekf::Association;
use scphd_filters::kind::Kind;
use scphd_filters::settings::{Likelihood, is_used_by};
use scphd_filters::slam::Precision;
use scphd_filters::threads::Threads;
use scphd_run::session::Filter;
use std::ops::RangeInclusive;
use std::path::PathBuf;

const ABOUT: &str = "Runs the scphd SLAM filter over logs and simulated scenarios";

const LONG_ABOUT: &str = "\
Runs the scphd SLAM filter (single-cluster PHD filter in fixed memory) over recorded logs and simulated scenarios, and \
prints how well and how fast it did.

Without a command: the scenario `survey` through the recommended filter (a joint map), through the filter of the thesis, \
both in single precision (f32), and through its reference in double precision (f64), on the same measurements and with \
the same seed. Prints them side by side and leaves plots (SVG and PNG) and CSV tables in `out/`. Takes some seconds. The \
settings are those of `scphd-sim run survey`.

A name is looked up in one order by all commands: a built-in scenario goes first, then the folder of a log; `./NAME` is \
always a folder.

The figures: root mean square errors over the scans whose true position is known; OSPA (order 1, cut-off 10 m) and GOSPA \
(order 2, cut-off 20 m, alpha 2) of the final map against the true landmarks; wall time of the scan step in \
microseconds. Angles in settings, CSV and logs are in radians, in the table in degrees.

Exit code: 0, 2 for bad input, arguments or settings, 1 for any other failure. There are no colours, whatever NO_COLOR says. Output files are written only after a \
successful run, each whole or not at all.";

fn count(text: &str) -> Result<usize, &'static str> {
    text.parse().map_err(|_| "must be a whole number and not negative")
}

fn distance(text: &str) -> Result<f64, &'static str> {
    let distance = text.parse().ok().filter(|distance: &f64| distance.is_finite() && *distance >= 0.0);
    distance.ok_or("must be a number and not negative")
}

fn share(text: &str) -> Result<f64, &'static str> {
    let share = text.parse().ok().filter(|share| (0.0..1.0).contains(share));
    share.ok_or("must be at least 0 and less than 1")
}

fn positive(text: &str) -> Result<f64, &'static str> {
    let rate = text.parse().ok().filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    rate.ok_or("must be a number above 0")
}

fn seed(text: &str) -> Result<u64, &'static str> {
    text.parse().map_err(|_| "must be a whole number from 0 to 18446744073709551615")
}

#[derive(Debug, Parser)]
#[command(name = "scphd-sim", version, about = ABOUT, long_about = LONG_ABOUT, args_conflicts_with_subcommands = true,
    propagate_version = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// No tables of results, progress and notices: only files, warnings and errors. Lists, settings and findings of a check are
    /// printed nevertheless.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    #[command(flatten)]
    pub job: MainJob,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Runs a filter over recorded logs.
    ///
    /// DIR is a folder with log.toml, odometry.csv, scans.csv, detections.csv and, optionally, fixes.csv, truth.csv,
    /// landmarks.csv and moving.csv; `scphd-sim export` writes an example: of `survey`, of `survey-fixes` with position fixes, of
    /// `two-sensors` with two sensors.
    Replay {
        /// Folder of a log; several are run in sequence.
        #[arg(required = true, value_name = "DIR")]
        dirs: Vec<PathBuf>,
        /// Standard deviation of each coordinate of the truth, m, for example of a satellite receiver: errors are compared with
        /// the sum of the covariances of estimate and truth. Overrides `truth_sigma_m` of the log. In the plane.
        #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = distance)]
        truth_sigma: Option<f64>,
        #[command(flatten)]
        run: RunArgs,
    },
    /// Runs a filter over a built-in scenario.
    Run {
        /// Name of the scenario; `scphd-sim scenarios` lists them.
        scenario: String,
        #[command(flatten)]
        run: RunArgs,
        #[command(flatten)]
        scenario_seed: ScenarioSeed,
    },
    /// Runs a scenario or logs many times, and prints means over the runs.
    ///
    /// Run k (from 0) has filter seed SEED + k and input set k / (N / M): a scenario made with the seed SEED + this number, or
    /// the log with this number. A run therefore depends on its number only, not on the threads. OSPA is of order 1 and cut-off
    /// 10 m, of the static and moving estimate together, at every scan: a static landmark counts from its first time in view, a
    /// moving one while it is in view.
    ///
    /// `worlds`, `worlds-mounted`, `worlds-moving`, `worlds-exact` and, in space, `worlds-space` and `worlds-space-exact` are
    /// different for every seed and have no mean: the output is a line for each world, then the comparison of the first filter
    /// with each other one; with --variants that of every variant with the first, and of the first with the best of the others in
    /// each world. With --out FILE finished runs are stored, and not repeated.
    MonteCarlo(MonteCarloArgs),
    /// Draws a figure of the thesis from scenarios and runs of this program, as SVG and PNG.
    ///
    /// Without a number: lists the figures.
    Figure(FigureArgs),
    /// Runs the filter in lockstep with the reference and prints their differences.
    ///
    /// Every step of the reference starts from the filter's state and random numbers, so that differences are those of a single
    /// step. The exit code is 0 for any differences.
    Compare(CompareArgs),
    /// Checks log folders: units, clocks, repeated scans, the stated view, dead reckoning compared with the truth.
    ///
    /// Prints figures of each log and the findings with advice: an error if the log cannot be read, a warning if the result is
    /// probably wrong, a note if nothing has to be done. The exit code is 2 if there is an error, with --strict also if there is
    /// a warning. A part of the check runs before every replay. docs/check.md lists all findings.
    Check(CheckArgs),
    /// Compares two runs: differences of settings and figures.
    ///
    /// A and B are pages of --html, or files of --json of single runs. Prints the different settings and all figures. With
    /// --html, for two pages, writes a page with both trajectories in one map and both errors in one plot. Runs over different
    /// inputs are refused.
    Diff(DiffArgs),
    /// Lists the built-in scenarios.
    Scenarios,
    /// Writes a built-in scenario as a log folder, or several with consecutive seeds.
    Export {
        /// Name of the scenario; `scphd-sim scenarios` lists them.
        scenario: String,
        /// Folder to write; it is created or must be empty.
        dir: PathBuf,
        /// Seed of the scenario's noise, missed detections and false measurements.
        #[arg(long, allow_negative_numbers = true, value_parser = seed, default_value_t = 1)]
        seed: u64,
        /// Writes N folders SCENARIO-SEED into DIR, with consecutive seeds from --seed.
        #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
        count: Option<u32>,
    },
    /// Converts a recording to a log folder.
    ///
    /// SOURCE is an MCAP file with messages of ROS 2, whose topics are chosen automatically unless named; a TOML file that
    /// assigns the columns of text tables; or a folder with the original files of MRCLAM or of Victoria Park. Assumptions are
    /// reported. docs/logs.md lists the messages, and which data a recording does not have.
    Import(ImportArgs),
    /// Writes a log or scenario as the binary stream that a vehicle computer reads; docs/stream.md describes it.
    Stream(StreamArgs),
    /// Streams a log or scenario to a target over a serial line, and compares the results with the truth.
    ///
    /// The target runs a filter with the capacities of the firmware (`firmware/src/bin/hil.rs`; docs/link.md describes the
    /// bytes). Every scan is answered with pose, covariance, digest and cost; lost records are repeated. At the end: round trip,
    /// and the margin at --hz. The exit code is 1 if a digest differs from the host's.
    Hil(HilArgs),
    /// Learns noise, detection and clutter settings from a part of a log, and proposes them if they predict the rest better.
    ///
    /// Estimates from the innovations of the part are tried for each group of settings and together, with the whole change and
    /// with half of it, in runs over the whole log. They are judged by the part that was not learnt from: the positions of old
    /// measurements, by the run's own trajectory, must predict those of new ones. The truth is not used, and no setting has a
    /// direct effect on the score. Changes that are not clearly better, and again with other seeds, are refused, and the settings
    /// stay as they are. Settings of the recursion are not changed, except births, which keep their ratio to clutter; odometry
    /// noise of a log that is not simulated is never lowered, nor is measurement noise below that of the log.
    Tune(TuneArgs),
    /// Prints the settings for a log or scenario, as a TOML file for --settings.
    Settings {
        /// Name of a scenario, or folder of a log.
        #[arg(value_name = "SCENARIO|DIR")]
        source: PathBuf,
        /// Prints them for a firmware instead: a table of constants that describes the joint map.
        #[arg(long = "as", value_name = "LANGUAGE")]
        language: Option<Language>,
        #[command(flatten)]
        tuning: Tuning,
    },
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Folder of a log, or several.
    #[arg(required = true, value_name = "DIR")]
    pub dirs: Vec<PathBuf>,
    /// Treats warnings as errors.
    #[arg(long)]
    pub strict: bool,
    /// Writes figures and findings to FILE (`-`: standard output) as a JSON object, for several logs as a list.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct ImportArgs {
    /// The recording: an MCAP file, a folder of `ros2 bag record`, a TOML file that assigns the columns of tables, or a folder of
    /// a data set.
    pub source: PathBuf,
    /// Folder to write; it is created or must be empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A log.toml with the data that the recording does not have: vehicle, sensors, noise [default: the one in the file if this
    /// program wrote it; otherwise assumptions].
    #[arg(long, value_name = "FILE")]
    pub head: Option<PathBuf>,
    /// Topic of the odometry.
    #[arg(long, value_name = "TOPIC")]
    pub odometry: Option<String>,
    /// Topic of the detections; with several sensors NAME=TOPIC for each.
    #[arg(long, value_name = "[NAME=]TOPIC")]
    pub detections: Vec<String>,
    /// Topic of fixes of the pose, or `none`.
    #[arg(long, value_name = "TOPIC")]
    pub fixes: Option<String>,
    /// Topic of the true pose, or `none`.
    #[arg(long, value_name = "TOPIC")]
    pub truth: Option<String>,
    /// Which time of a message is used.
    #[arg(long, value_enum, default_value_t = ClockName::Header)]
    pub clock: ClockName,
    /// Imports the data before a damaged or truncated part of a file.
    #[arg(long)]
    pub partial: bool,
    /// Piece to import of a recording whose stamps go back, from 1.
    #[arg(long, value_name = "N")]
    pub part: Option<usize>,
    /// Leaves out detections with this range or more: sensors write their greatest range, or more, if nothing was reflected.
    #[arg(long, value_name = "METRES")]
    pub range_below: Option<f64>,
    /// Number of the robot of MRCLAM.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u32).range(1..=5))]
    pub robot: u32,
}

/// Which time of a message is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ClockName {
    /// The time stamp of its header.
    Header,
    /// The time of recording.
    Log,
}

#[derive(Debug, Args)]
pub struct DiffArgs {
    /// Output of the first run: its page (--html) or its figures (--json).
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// Output of the second run.
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Compares runs of different logs, scenarios or inputs, too.
    #[arg(long)]
    pub anyway: bool,
    /// Writes the differences to FILE (`-`: standard output) as a JSON object.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Writes both runs to FILE (`-`: standard output) as a page for a browser, which needs no network; A and B must be pages.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct MainJob {
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
    /// Writes the figures of the runs to FILE as a JSON list of objects.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Folder for plots, the joint map's run as a page for a browser (report.html) and, in a folder for each filter, CSV tables.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    /// The filter [default: joint for logs and random worlds, unless --particles, --samples or --threads require core;
    /// otherwise core].
    #[arg(long, value_enum)]
    pub filter: Option<FilterName>,
    /// Number type of the filter [default: f32 for core, f64 for reference, which has no other].
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,
    /// Runs N consecutive seeds, and prints a row of statistics for each log.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = value_parser!(u32).range(1..))]
    pub repeat: u32,
    /// Runs up to N at the same time; only the times depend on it.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = value_parser!(u16).range(1..))]
    pub jobs: u16,
    /// Weighs candidates and updates maps with N threads; only the times depend on it. For the core filter only.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Writes the figures to FILE (`-`: standard output) as a JSON object, for several runs as a list.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Writes scans.csv, map.csv, estimate.tum, truth.tum, and trajectory and error plots (SVG and PNG) to DIR; for a single run
    /// only.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Writes the run to FILE (`-`: standard output) as a page for a browser, which needs no network: the map at all times,
    /// curves, health, settings; for a single run only.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Writes the run to FILE (`-`: standard output) as an MCAP file with messages of ROS 2: estimate, truth, map, detections,
    /// and inputs of the filter; for a single run only. docs/logs.md lists the topics.
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// Writes the final map to FILE, for --map of another drive; for a joint map in the plane and a single run only.
    #[arg(long, value_name = "FILE")]
    pub save_map: Option<PathBuf>,
    /// Starts in the map of --save-map, at the pose of the log, and continues mapping.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Finds the initial pose in the map of --map instead of using that of the log; until then the vehicle maps in a frame of its
    /// own, and its errors have no meaning.
    #[arg(long, requires = "map")]
    pub locate: bool,
}

#[derive(Debug, Args)]
pub struct MonteCarloArgs {
    /// Name of a scenario, or folders of logs, all in the plane or all of a stereo camera.
    #[arg(required = true, value_name = "SCENARIO|DIR")]
    pub sources: Vec<PathBuf>,
    /// Number of runs of each filter [default: 100 for a scenario, one for each log].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub runs: Option<u32>,
    /// Number of different inputs, a divisor of the number of runs [default: the number of runs, or of logs; a quarter for
    /// thesis-dynamic, whose study in the thesis has 25 inputs with 4 runs each].
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..))]
    pub input_sets: Option<u32>,
    /// Added to all seeds.
    #[arg(long, allow_negative_numbers = true, value_parser = seed, default_value_t = 0)]
    pub seed: u64,
    /// The filters, separated by commas; they have the same inputs, and the first is compared with each other one [default: joint
    /// in random worlds, unless --particles or --samples require core; otherwise core].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub filter: Vec<FilterName>,
    /// Number type of the filters [default: f32 for core, f64 for reference, which has no other].
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,
    /// TOML file with variants of the settings: every filter runs with each variant, or with those for it, and the others are
    /// compared with the first variant. docs/studies.md describes it.
    #[arg(long, value_name = "FILE.toml")]
    pub variants: Option<PathBuf>,
    #[command(flatten)]
    pub tuning: Tuning,
    /// Number of parallel runs [default: the number of cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Runs the filters on a GPU, with the same results; docs/gpu.md says for which filters and logs, and how to build it.
    #[arg(long, value_enum)]
    pub device: Option<DeviceName>,
    /// Writes the figures to FILE (`-`: standard output) as a JSON object, for several filters as a list.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Folder for plots (SVG and PNG) and tables (CSV); for random worlds the file of the runs (CSV).
    #[arg(long, value_name = "DIR|FILE")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct FigureArgs {
    /// Number of the figure, for example 5.5.
    #[arg(value_name = "NUMBER")]
    pub number: Option<String>,
    /// Folder for figure-NUMBER.svg and figure-NUMBER.png.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Number of runs of each filter, for figures of means [default: as in the thesis].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub runs: Option<u32>,
    /// Number of parallel runs [default: the number of cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Seed of scenario and filter, or, for figures of means, added to all seeds.
    #[arg(long, allow_negative_numbers = true, value_parser = seed, default_value_t = 1)]
    pub seed: u64,
    #[command(flatten)]
    pub tuning: Tuning,
}

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Name of a scenario, or folder of a log.
    #[arg(value_name = "SCENARIO|DIR", default_value = "survey")]
    pub source: PathBuf,
    /// The filter; each has its own reference.
    #[arg(long, value_enum, default_value_t = ComparedFilter::Core)]
    pub filter: ComparedFilter,
    /// Number type of the filter; the reference always has f64.
    #[arg(long, value_enum, default_value_t = ComparedPrecision::all())]
    pub precision: ComparedPrecision,
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
}

#[derive(Debug, Args)]
pub struct StreamArgs {
    /// Name of a scenario, `worst-case` or `worst-case-joint` for inputs with the greatest cost for a filter's capacities, or
    /// folder of a log.
    #[arg(value_name = "SCENARIO|DIR")]
    pub source: PathBuf,
    /// File to write.
    pub file: PathBuf,
    /// Number of scans, from the first [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub scans: Option<usize>,
    /// Number type of the inputs.
    #[arg(long, value_enum, default_value_t = PrecisionName::F32)]
    pub precision: PrecisionName,
    /// Runs the filter of a black box too, and writes a snapshot of its state after every N scans.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub snapshot_every: Option<u32>,
    /// The filter of the stream; that of `worst-case-joint` is the joint map.
    #[arg(long, value_enum, default_value_t = ComparedFilter::Core)]
    pub filter: ComparedFilter,
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
}

#[derive(Debug, Args)]
pub struct HilArgs {
    /// Name of a scenario, or folder of a log; of a vehicle in the plane.
    #[arg(value_name = "SCENARIO|DIR")]
    pub source: PathBuf,
    /// Address of the target: `tcp:ADDRESS:PORT`, or a serial device that has been set up, for example by
    /// `stty -F /dev/ttyACM0 115200 raw -echo`.
    #[arg(long)]
    pub port: Port,
    /// Number of scans, from the first [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub scans: Option<usize>,
    /// The filter of the target.
    #[arg(long, value_enum, default_value_t = ComparedFilter::Core)]
    pub filter: ComparedFilter,
    /// Scan rate for which the margin is printed.
    #[arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = positive)]
    pub hz: f64,
    /// Clock of the target's processor, for the margin: an emulator counts instructions, which are taken as one for each cycle.
    #[arg(long, value_name = "MHZ", default_value_t = 480.0, value_parser = positive)]
    pub core_mhz: f64,
    /// Time after which a missing answer is requested.
    #[arg(long, value_name = "MS", default_value_t = 1000, value_parser = value_parser!(u32).range(1..))]
    pub timeout_ms: u32,
    /// Greatest number of requests for an answer or repetitions of a scan.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = value_parser!(u32))]
    pub repeats: u32,
    /// Loses a share P of the frames deliberately, in both directions.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub lose: f64,
    /// Flips a bit in a share P of the bytes.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub flip: f64,
    /// Sends a share P of the frames twice.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub double: f64,
    /// Delays a share P of the frames until later ones have passed.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub late: f64,
    /// Seed of the deliberate faults of the line.
    #[arg(long, value_name = "SEED", value_parser = seed, default_value_t = 1)]
    pub line_seed: u64,
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
}

#[derive(Debug, Args)]
pub struct TuneArgs {
    /// Name of a scenario, or folder of a log.
    #[arg(value_name = "SCENARIO|DIR")]
    pub source: PathBuf,
    /// Number of runs over the part to learn from; each uses the estimates of the one before.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 3, value_parser = value_parser!(u16).range(1..=100))]
    pub rounds: u16,
    /// Number of runs of a candidate, and of the best one with other seeds.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 3, value_parser = value_parser!(u16).range(1..=100))]
    pub runs: u16,
    /// Number of parallel runs [default: the number of cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Does the runs of the candidates on a GPU, with the same results; docs/gpu.md says for which filters and logs, and how to build
    /// it.
    #[arg(long, value_enum)]
    pub device: Option<DeviceName>,
    /// Learns from the scans from this time, s since the first scan.
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 0.0)]
    pub from: f64,
    /// Learns from the scans before this time, s since the first scan [default: the first half].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// The filter that will run with the settings; a joint map has fewer innovations.
    #[arg(long, value_enum, default_value_t = FilterName::Core)]
    pub filter: FilterName,
    /// Reports also the position errors in the part that judges; they are not used for decisions.
    #[arg(long)]
    pub truth: bool,
    /// Repeats it for N scenarios with consecutive seeds, and prints a line for each, with position errors.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub count: Option<u32>,
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
    /// Writes the proposed settings, and those of --settings and of options, to FILE, for --settings.
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
}

/// Options that change the settings.
#[derive(Debug, Args)]
pub struct Tuning {
    /// Particles N between scans; the core filter has a capacity of 1024. Overrides the settings file.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub particles: Option<usize>,
    /// Samples M drawn from every particle in a prediction; the core filter has a capacity of 2048 particles × samples. Overrides
    /// the settings file.
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = count)]
    pub samples: Option<usize>,
    /// Whether features may move; on: births of moving features are half as frequent as those of static ones [default: on for the
    /// scenarios of 5.3.1 and for a joint map of a recorded log, there with twice as many births as of static ones if the log shows
    /// moving objects; otherwise off]. Overrides the settings file.
    #[arg(long, value_enum)]
    pub moving: Option<Switch>,
    /// Hypotheses of data association of a joint map in the plane, 16 at most [default: 8 for a drive that loses its heading
    /// and for a log that shows moving objects, otherwise 1]. Overrides the settings file.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub hypotheses: Option<usize>,
    /// TOML file whose fields override the defaults for the log; all are optional. `scphd-sim settings` prints all with their
    /// values; units are in the names, intensities are per m rad.
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct Seed {
    /// Seed of the filter's random numbers; for a scenario also of its noise, unless --scenario-seed is given.
    #[arg(long, allow_negative_numbers = true, value_parser = seed, default_value_t = 1)]
    pub seed: u64,
}

#[derive(Debug, Args)]
pub struct ScenarioSeed {
    /// Seed of the scenario's noise, missed detections and false measurements [default: that of --seed].
    #[arg(long, value_name = "SEED", allow_negative_numbers = true, value_parser = seed)]
    pub scenario_seed: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    /// The thesis's filter with fixed capacities, as on a target.
    Core,
    /// One Gaussian over the pose and all features; unless --moving is off, moving-object tracks beside it.
    Joint,
    /// The thesis's recursion without approximations in double precision, slow, in the plane; the likelihood is that of the
    /// settings, by default single-cluster.
    Reference,
    /// The same with the likelihood of RB-PHD SLAM, empty-map approximation.
    RbEmpty,
    /// The same with the likelihood of RB-PHD SLAM, single-feature approximation.
    RbSingle,
    /// The same with the likelihood of RB-PHD SLAM with several features.
    RbMulti,
    /// EKF SLAM with nearest-neighbour association, as a baseline; in the plane.
    Ekf,
    /// The same with the associations of the log's label columns: a bound, not an estimate.
    EkfKnown,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DeviceName {
    /// An NVIDIA card.
    Cuda,
    /// The card's program on this machine, instruction by instruction, which is slow.
    Ptx,
}

/// A programming language for printed settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    C,
    Rust,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PrecisionName {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ComparedFilter {
    /// The fixed-capacity filter with particles and mixtures.
    Core,
    /// The filter with a joint map.
    Joint,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ComparedPrecision {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
    /// Both, in sequence.
    Both,
}

impl ComparedFilter {
    /// The filter as a choice of other commands.
    pub fn choice(self) -> Choice {
        let filter = match self {
            Self::Core => Filter::Core(Precision::F32),
            Self::Joint => Filter::Joint(Precision::F32),
        };
        Choice { filter, likelihood: None }
    }

    /// The filter of a stream.
    pub fn recorded(self) -> Recorded {
        match self {
            Self::Core => Recorded::Mixture,
            Self::Joint => Recorded::Joint,
        }
    }
}

impl ComparedPrecision {
    /// All that are compiled.
    fn all() -> Self {
        if Precision::F64.is_built() { Self::Both } else { Self::F32 }
    }

    /// The precisions to compare, in the order of the columns.
    pub fn each(self) -> &'static [Precision] {
        match self {
            Self::F32 => &[Precision::F32],
            Self::F64 => &[Precision::F64],
            Self::Both => &[Precision::F32, Precision::F64],
        }
    }
}

/// A filter with its number type and, if its name includes one, its particle likelihood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    pub filter: Filter,
    likelihood: Option<Likelihood>,
}

impl Choice {
    /// The requested filter, or the reason why it does not exist.
    pub fn of(name: FilterName, precision: Option<PrecisionName>) -> Result<Self, &'static str> {
        let of_core = match precision {
            None | Some(PrecisionName::F32) => Precision::F32,
            Some(PrecisionName::F64) => Precision::F64,
        };
        let (filter, likelihood) = match name {
            FilterName::Core => (Filter::Core(of_core), None),
            FilterName::Joint => (Filter::Joint(of_core), None),
            FilterName::Reference => (Filter::Reference, None),
            FilterName::RbEmpty => (Filter::Reference, Some(Likelihood::RbEmpty)),
            FilterName::RbSingle => (Filter::Reference, Some(Likelihood::RbSingle)),
            FilterName::RbMulti => (Filter::Reference, Some(Likelihood::RbMulti)),
            FilterName::Ekf => (Filter::Ekf(Association::NearestNeighbour), None),
            FilterName::EkfKnown => (Filter::Ekf(Association::Known), None),
        };
        match (filter, precision) {
            (Filter::Reference, Some(PrecisionName::F32)) => Err("--precision f32: the reference is f64 only"),
            (Filter::Ekf(_), Some(PrecisionName::F32)) => Err("--precision f32: the EKF is f64 only"),
            _ => Ok(Self { filter, likelihood }),
        }
    }

    /// Name on the command line.
    pub fn name(&self) -> &'static str {
        match (self.filter, self.likelihood) {
            (Filter::Core(_), _) => "core",
            (filter, likelihood) => filter.name(likelihood.unwrap_or(Likelihood::SingleCluster)),
        }
    }

    /// Whether it uses a setting or an option. If its name includes the likelihood, the setting of the likelihood is not used.
    pub fn uses(&self, what: &str) -> bool {
        is_used_by(self.filter, what) && !(self.likelihood.is_some() && what == "filter.likelihood")
    }

    /// The settings with its likelihood.
    pub fn settings<K: Kind>(&self, mut settings: K::Settings) -> K::Settings {
        let recursion = K::recursion_mut(&mut settings);
        recursion.likelihood = self.likelihood.unwrap_or(recursion.likelihood);
        settings
    }
}

impl Tuning {
    /// The given options other than the settings file.
    pub fn options(&self) -> Vec<&'static str> {
        let given = [
            (self.particles.is_some(), "--particles"),
            (self.samples.is_some(), "--samples"),
            (self.hypotheses.is_some(), "--hypotheses"),
            (self.moving == Some(Switch::On), "--moving on"),
            (self.moving == Some(Switch::Off), "--moving off"),
        ];
        given.into_iter().filter(|(given, _)| *given).map(|(_, option)| option).collect()
    }
}

impl FilterName {
    /// The default filter; `is_log`: for a log or a scenario like one. It is a joint map, unless options are given that only a
    /// mixture has.
    pub fn usual(is_log: bool, tuning: &Tuning, threads: u16) -> Self {
        let several = tuning.particles.is_some() || tuning.samples.is_some() || threads > 1;
        if is_log && !several { Self::Joint } else { Self::Core }
    }
}

impl MonteCarloArgs {
    /// The requested filters, or the default one.
    pub fn filters(&self, are_worlds: bool) -> Vec<FilterName> {
        if self.filter.is_empty() { vec![FilterName::usual(are_worlds, &self.tuning, 1)] } else { self.filter.clone() }
    }
}

impl RunArgs {
    /// The requested filter, or the default one for a log in the plane or for something else; or the reason why it does not
    /// exist.
    pub fn filter(&self, is_log: bool) -> Result<Choice, &'static str> {
        let usual = || FilterName::usual(is_log, &self.tuning, self.threads);
        Choice::of(self.filter.unwrap_or_else(usual), self.precision)
    }

    pub fn seeds(&self) -> Result<RangeInclusive<u64>, Failure> {
        let first = self.seed.seed;
        let last = first
            .checked_add(u64::from(self.repeat) - 1)
            .ok_or_else(|| Failure::input(format_args!("--seed {first}: too large for --repeat {}", self.repeat)))?;
        Ok(first..=last)
    }

    pub fn threads(&self) -> Result<Threads, Failure> {
        Ok(Threads::new(self.threads.into())?)
    }

    /// The given options other than those of [`Tuning`] that are not used by all filters.
    pub fn options(&self) -> Vec<&'static str> {
        let given = [
            (self.threads > 1, "--threads"),
            (self.save_map.is_some(), "--save-map"),
            (self.map.is_some(), "--map"),
            (self.locate, "--locate"),
        ];
        given.into_iter().filter(|(given, _)| *given).map(|(_, option)| option).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
