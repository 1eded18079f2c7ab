//! The arguments and their help.

use super::failure::Failure;
use clap::{Args, Parser, Subcommand, ValueEnum, value_parser};
use clap_complete::Shell;
use scphd_boards::hil::Port;
use scphd_filters::ekf::Association;
use scphd_filters::kind::Kind;
use scphd_filters::settings::{Likelihood, is_used_by};
use scphd_filters::slam::Precision;
use scphd_filters::threads::Threads;
use scphd_run::monte_carlo::Shard;
use scphd_run::session::Filter;
use std::ops::RangeInclusive;
use std::path::PathBuf;

const ABOUT: &str = "Runs the scphd SLAM filter over logs and simulated scenarios";

const LONG_ABOUT: &str = "\
Runs the scphd SLAM filter (single-cluster PHD filter in fixed memory) over recorded logs and simulated scenarios, and \
prints how well and how fast it did.

Without a command: the scenario `survey` once through the filter in single precision (f32) and once through the \
brute-force reference in double precision (f64), on the same measurements and with the same seed. Prints both side by \
side and leaves plots (SVG and PNG) and CSV tables in `out/`. Takes some seconds: the reference computes everything. The \
settings are those of `scphd-sim run survey`.

A name is looked up in one order by all commands: a built-in scenario goes first, then the folder of a log; `./NAME` is \
always a folder.

The figures: root mean square errors over the scans whose true position is known; OSPA (order 1, cut-off 10 m) and GOSPA \
(order 2, cut-off 20 m, alpha 2) of the final map against the true landmarks; wall time of the scan step in \
microseconds. Angles in settings, CSV and logs are in radians, in the table in degrees.

Exit code: 0, 2 for bad input, arguments or settings, 1 for any other failure. There are no colours, whatever NO_COLOR says. Output files are written only after a \
successful run, each whole or not at all.";

/// A number of things.
fn count(text: &str) -> Result<usize, &'static str> {
    text.parse().map_err(|_| "must be a whole number and not negative")
}

/// A distance.
fn distance(text: &str) -> Result<f64, &'static str> {
    let distance = text.parse().ok().filter(|distance: &f64| distance.is_finite() && *distance >= 0.0);
    distance.ok_or("must be a number and not negative")
}

/// A share of something, less than all of it.
fn share(text: &str) -> Result<f64, &'static str> {
    let share = text.parse().ok().filter(|share| (0.0..1.0).contains(share));
    share.ok_or("must be at least 0 and less than 1")
}

/// A rate.
fn positive(text: &str) -> Result<f64, &'static str> {
    let rate = text.parse().ok().filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    rate.ok_or("must be a number above 0")
}

/// A seed.
fn seed(text: &str) -> Result<u64, &'static str> {
    text.parse().map_err(|_| "must be a whole number from 0 to 18446744073709551615")
}

#[derive(Debug, Parser)]
#[command(name = "scphd-sim", version, about = ABOUT, long_about = LONG_ABOUT, args_conflicts_with_subcommands = true,
    propagate_version = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// No tables of results, no progress, no notices: files, warnings and errors alone. Lists, settings and findings of a check are printed
    /// as ever.
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
    /// landmarks.csv and moving.csv; `scphd-sim export` makes one to look at: of `survey`, of `survey-fixes` with fixes of
    /// the position, of `two-sensors` with two sensors.
    Replay {
        /// Folder of a log; several are run one after the other.
        #[arg(required = true, value_name = "DIR")]
        dirs: Vec<PathBuf>,
        /// Standard deviation of either coordinate of the truth, m, as where that is a satellite receiver's: the covariance of the
        /// estimate and of the truth together is what errors are held against. Overrides `truth_sigma_m` of the log. In the plane.
        #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = distance)]
        truth_sigma: Option<f64>,
        #[command(flatten)]
        run: RunArgs,
    },
    /// Runs a filter over a built-in scenario.
    Run {
        /// Name of the scenario; see --list.
        #[arg(required_unless_present = "list")]
        scenario: Option<String>,
        /// Lists the scenarios and does nothing else.
        #[arg(long, exclusive = true)]
        list: bool,
        #[command(flatten)]
        run: RunArgs,
        #[command(flatten)]
        scenario_seed: ScenarioSeed,
    },
    /// Runs a scenario many times, or logs, and prints means over the runs.
    ///
    /// Run k (from 0) has filter seed SEED + k and input set k / (N / M): a scenario made with seed SEED + that number,
    /// or the log of that number. So every run is decided by its number alone, whatever the threads. OSPA is of order
    /// 1 and cut-off 10 m, of the static and moving estimate together, at every scan: a static landmark counts from
    /// its first time in view on, a moving one while it is in view.
    ///
    /// `worlds`, `worlds-mounted`, `worlds-moving`, `worlds-exact` and, in space, `worlds-space` and `worlds-space-exact` are other
    /// places with every seed, which have no mean: one line a world, then how the first filter stands beside each other one; with --variants how every variant stands beside the first, and the first
    /// beside the best of the others in each world. With --out FILE every run is kept as it ends, and not run again.
    MonteCarlo(MonteCarloArgs),
    /// Puts together the parts of a study that `monte-carlo --shard` left.
    Merge(MergeArgs),
    /// Draws a figure of the thesis from scenarios and runs of this program, as SVG and PNG.
    ///
    /// Without a number: lists the figures.
    Figure(FigureArgs),
    /// Runs the filter in lockstep with the reference and prints how far they differ.
    ///
    /// Every step of the reference starts from the filter's own state and random numbers, so that what differs
    /// afterwards is what that one step computed differently. The exit code is 0 however large the differences are.
    Compare(CompareArgs),
    /// Checks log folders: units, clocks, doubled scans, the stated view, dead reckoning beside the truth.
    ///
    /// Prints figures of each log and what is found, each with what to do: an error where the log cannot be read, a warning
    /// where what comes of it is probably wrong, a note where nothing has to be done. The exit code is 2 if there is an error,
    /// with --strict also if there is a warning. A part of it runs before every replay. docs/check.md lists all findings.
    Check(CheckArgs),
    /// Shows two runs beside each other: what was set otherwise, and what came of it.
    ///
    /// A and B are pages that --html wrote, or what --json wrote of single runs. Prints the settings that differ and all figures. With --html, of
    /// two pages, a page with both trajectories in one map and both errors in one plot. Runs over other inputs are refused.
    Diff(DiffArgs),
    /// Prints the completions of this command line for a shell.
    ///
    /// For bash, say: scphd-sim completions bash > ~/.local/share/bash-completion/completions/scphd-sim
    Completions {
        /// The shell.
        #[arg(value_enum)]
        shell: Shell,
    },
    /// Lists the built-in scenarios.
    Scenarios,
    /// Writes a built-in scenario as a log folder, or with several seeds as several.
    Export {
        /// Name of the scenario; `scphd-sim scenarios` lists them.
        scenario: String,
        /// Folder to write; it is made, or has to be empty.
        dir: PathBuf,
        /// Seed of the scenario's noise, missed detections and false measurements.
        #[arg(long, allow_negative_numbers = true, value_parser = seed, default_value_t = 1)]
        seed: u64,
        /// Writes N folders SCENARIO-SEED into DIR, of the seeds from --seed on.
        #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
        count: Option<u32>,
    },
    /// Makes a log folder of a recording.
    ///
    /// SOURCE is an MCAP file with messages of ROS 2, of which the topics are guessed where they are not named; a TOML file that says which
    /// columns of text tables are what; or a folder with the original files of MRCLAM or of Victoria Park. What was guessed is told.
    /// docs/logs.md lists the messages, and what a recording does not say.
    Import(ImportArgs),
    /// Writes a log or scenario as the binary stream that a vehicle computer reads; docs/stream.md describes it.
    Stream(StreamArgs),
    /// Streams a log or scenario to a target over a serial line, and shows what comes back beside the truth.
    ///
    /// The target runs a filter with the room of the firmware (`firmware/src/bin/hil.rs`; docs/link.md has the bytes). Every scan is
    /// answered with pose, covariance, digest and cost; what was lost is sent again. At the end: round trip, and the margin at --hz. The exit
    /// code is 1 if a digest is another one than the host's.
    Hil(HilArgs),
    /// Learns noise, detection and clutter settings from a part of a log, and proposes them if they foresee the rest better.
    ///
    /// What the innovations of the part say is tried group by group and together, as it is and half way there, in runs over the
    /// whole log. The judge is where the vehicle sees things again in the part that was not learnt from: the places of old
    /// measurements, by the run's own trajectory, have to foresee those of new ones. No truth is used, and no setting can
    /// flatter its score. What does not win clearly, and again with other seeds, is refused, and then everything stays as it is.
    /// Settings of the recursion stay in any case, but births keep their ratio to clutter; odometry noise of a log that is no
    /// simulation is never lowered, and measurement noise not below what the log states.
    Tune(TuneArgs),
    /// Prints the settings a log or scenario is run with, as a TOML file for --settings.
    Settings {
        /// Name of a scenario, or folder of a log.
        #[arg(value_name = "SCENARIO|DIR")]
        source: PathBuf,
        /// Prints them for a firmware instead: a table of constants with which the joint map is described there.
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
    /// Takes warnings for errors.
    #[arg(long)]
    pub strict: bool,
    /// Writes figures and findings to FILE (`-`: standard output) as one JSON object, those of several logs as a list of them.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct ImportArgs {
    /// The recording: an MCAP file, a folder of `ros2 bag record`, a map of the columns of tables (.toml), or a folder of a data set.
    pub source: PathBuf,
    /// Folder to write; it is made, or has to be empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A log.toml with what the recording does not say: vehicle, sensors, noise [default: that in the file, if a run of this program wrote
    /// it; otherwise a guess].
    #[arg(long, value_name = "FILE")]
    pub head: Option<PathBuf>,
    /// Topic of the odometry.
    #[arg(long, value_name = "TOPIC")]
    pub odometry: Option<String>,
    /// Topic of the detections; of several sensors NAME=TOPIC for each.
    #[arg(long, value_name = "[NAME=]TOPIC")]
    pub detections: Vec<String>,
    /// Topic of fixes of the pose, or `none`.
    #[arg(long, value_name = "TOPIC")]
    pub fixes: Option<String>,
    /// Topic of the true pose, or `none`.
    #[arg(long, value_name = "TOPIC")]
    pub truth: Option<String>,
    /// Which time of a message counts.
    #[arg(long, value_enum, default_value_t = ClockName::Header)]
    pub clock: ClockName,
    /// Of a file that is torn off or damaged, takes what lies before.
    #[arg(long)]
    pub partial: bool,
    /// Of a recording whose stamps go back, which part to take, from 1 on.
    #[arg(long, value_name = "N")]
    pub part: Option<usize>,
    /// Leaves out detections whose range is not less: sensors write their greatest range, or more, where nothing came back.
    #[arg(long, value_name = "METRES")]
    pub range_below: Option<f64>,
    /// Which robot of MRCLAM.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u32).range(1..=5))]
    pub robot: u32,
}

/// Which time of a message counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ClockName {
    /// That of its header.
    Header,
    /// That at which it was recorded.
    Log,
}

#[derive(Debug, Args)]
pub struct DiffArgs {
    /// What the first run wrote: its page (--html) or its figures (--json).
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// What the second run wrote.
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Compares them even where they are of other logs, scenarios or inputs.
    #[arg(long)]
    pub anyway: bool,
    /// Writes what differs to FILE (`-`: standard output) as one JSON object.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Writes both runs to FILE (`-`: standard output) as one page for a browser, which needs no network; A and B have to be pages.
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
    /// The filter [default: joint for logs and random worlds, unless --particles, --samples, --threads or
    /// --moving on speak of core; otherwise core].
    #[arg(long, value_enum)]
    pub filter: Option<FilterName>,
    /// Number type of the filter [default: f32 for core, f64 for reference, which knows no other].
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,
    /// Runs as many seeds, each one more than that before, and prints a row of statistics for each log.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = value_parser!(u32).range(1..))]
    pub repeat: u32,
    /// Runs up to N at the same time; the figures do not depend on it, except for the times.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = value_parser!(u16).range(1..))]
    pub jobs: u16,
    /// Weighs candidates and updates maps with N threads; the figures do not depend on it, except for the times. For the
    /// core filter only.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Writes the figures to FILE (`-`: standard output) as one JSON object, those of several runs as a list of them.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Writes scans.csv, map.csv, estimate.tum, truth.tum, and trajectory and error plots (SVG and PNG) to DIR; for a single run only.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Writes the run to FILE (`-`: standard output) as a page for a browser, which needs no network: the map at all times, curves, health,
    /// settings; for a single run only.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Writes the run to FILE (`-`: standard output) as an MCAP file with messages of ROS 2: estimate, truth, map, detections, and what the
    /// filter was told; for a single run only. docs/logs.md lists the topics.
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// Writes the map at the end to FILE, for --map of another drive; a joint map in the plane and a single run only.
    #[arg(long, value_name = "FILE")]
    pub save_map: Option<PathBuf>,
    /// Starts in the map that --save-map wrote, at the pose of the log, and goes on mapping in it.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Takes no pose from the log, but finds it in the map of --map; until then the vehicle maps in a frame of its own, and its errors
    /// mean nothing.
    #[arg(long, requires = "map")]
    pub locate: bool,
}

#[derive(Debug, Args)]
pub struct MonteCarloArgs {
    /// Name of a scenario, or folders of logs, all in the plane or all of a stereo camera.
    #[arg(required = true, value_name = "SCENARIO|DIR")]
    pub sources: Vec<PathBuf>,
    /// Runs of each filter [default: 100 of a scenario, one of each log].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub runs: Option<u32>,
    /// Different inputs, a divisor of the runs [default: as many as runs, or logs; a quarter for thesis-dynamic, whose
    /// study in the thesis has 25 inputs with 4 runs each].
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..))]
    pub input_sets: Option<u32>,
    /// Added to all seeds.
    #[arg(long, allow_negative_numbers = true, value_parser = seed, default_value_t = 0)]
    pub seed: u64,
    /// The filters, separated by commas; they get the same inputs, and the first is compared with each other one [default:
    /// joint in random worlds, unless --particles, --samples or --moving on speak of core; otherwise core].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub filter: Vec<FilterName>,
    /// Number type of the filters [default: f32 for core, f64 for reference, which knows no other].
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,
    /// TOML file of settings that are changed on purpose: every filter runs with each of the variants in it, or with those that are of
    /// it, and the first variant is what the others are compared with. docs/studies.md describes it.
    #[arg(long, value_name = "FILE.toml")]
    pub variants: Option<PathBuf>,
    #[command(flatten)]
    pub tuning: Tuning,
    /// Runs at the same time [default: as many as there are cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Does only part K of N of the runs and leaves them in the file of --out, for `merge`.
    #[arg(long, value_name = "K/N")]
    pub shard: Option<Shard>,
    /// Writes the figures to FILE (`-`: standard output) as one JSON object, those of several filters as a list of them.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Folder for plots (SVG and PNG) and tables (CSV); with --shard the file for the runs (JSON).
    #[arg(long, value_name = "DIR|FILE")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// What every `monte-carlo --shard` of the study left, in any order.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Writes the figures to FILE (`-`: standard output) as one JSON object, those of several filters as a list of them.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Folder for plots (SVG and PNG) and tables (CSV).
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct FigureArgs {
    /// Number of the figure, as 5.5.
    #[arg(value_name = "NUMBER")]
    pub number: Option<String>,
    /// Folder for figure-NUMBER.svg and figure-NUMBER.png.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Runs of each filter, for figures of means [default: as in the thesis].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub runs: Option<u32>,
    /// Runs at the same time [default: as many as there are cores].
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
    /// The filter, each of which has a reference of its own.
    #[arg(long, value_enum, default_value_t = ComparedFilter::Core)]
    pub filter: ComparedFilter,
    /// Number type of the filter; the reference always has f64.
    #[arg(long, value_enum, default_value_t = ComparedPrecision::Both)]
    pub precision: ComparedPrecision,
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
    /// Writes the differences to FILE as a JSON list of objects, one a precision.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Writes the differences scan by scan to compare-f32.csv and compare-f64.csv in DIR.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct StreamArgs {
    /// Name of a scenario, `worst-case` or `worst-case-joint` for inputs that cost a filter the most its memory allows, or folder of a log.
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
    /// Runs the filter of a black box along, and writes a snapshot of its state after every N scans.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub snapshot_every: Option<u32>,
    /// The filter of the snapshots.
    #[arg(long, value_enum, default_value_t = ComparedFilter::Core, requires = "snapshot_every")]
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
    /// Where the target is: `tcp:ADDRESS:PORT`, or a serial device, set up before, as by `stty -F /dev/ttyACM0 115200 raw -echo`.
    #[arg(long)]
    pub port: Port,
    /// Number of scans, from the first [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub scans: Option<usize>,
    /// The filter that the target has.
    #[arg(long, value_enum, default_value_t = ComparedFilter::Core)]
    pub filter: ComparedFilter,
    /// Scans a second that the margin is told for.
    #[arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = positive)]
    pub hz: f64,
    /// Clock of the target's processor, for the margin: an emulator counts instructions, taken for one a cycle.
    #[arg(long, value_name = "MHZ", default_value_t = 480.0, value_parser = positive)]
    pub core_mhz: f64,
    /// Time after which to ask for an answer that has not come.
    #[arg(long, value_name = "MS", default_value_t = 1000, value_parser = value_parser!(u32).range(1..))]
    pub timeout_ms: u32,
    /// Times to ask for an answer or send a scan again, before giving up.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = value_parser!(u32))]
    pub repeats: u32,
    /// Loses a share P of the frames on purpose, either way.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub lose: f64,
    /// Flips a bit in a share P of the bytes.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub flip: f64,
    /// Sends a share P of the frames twice.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub double: f64,
    /// Holds a share P of the frames back until later ones have passed.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub late: f64,
    /// Seed of what the line does on purpose.
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
    /// Runs over the part that is learnt from, each with what the one before said.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 3, value_parser = value_parser!(u16).range(1..=100))]
    pub rounds: u16,
    /// Runs of a candidate, and as many with other seeds of the best one.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 3, value_parser = value_parser!(u16).range(1..=100))]
    pub runs: u16,
    /// Runs at the same time [default: as many as there are cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Learns from the scans from here on, s since the first.
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 0.0)]
    pub from: f64,
    /// Learns from the scans before, s since the first [default: the first half].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// The filter that is to run with the settings; of a joint map fewer innovations are known.
    #[arg(long, value_enum, default_value_t = FilterName::Core)]
    pub filter: FilterName,
    /// Tells the position errors in the part that judges too; nothing is decided by them.
    #[arg(long)]
    pub truth: bool,
    /// Does it for N scenarios, each of the seed after that of the one before, and prints a line each, with position errors.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub count: Option<u32>,
    #[command(flatten)]
    pub tuning: Tuning,
    #[command(flatten)]
    pub seed: Seed,
    #[command(flatten)]
    pub scenario_seed: ScenarioSeed,
    /// Writes all settings, the proposed ones among them, to FILE, for --settings.
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
}

/// What changes the settings.
#[derive(Debug, Args)]
pub struct Tuning {
    /// Particles N kept between scans; the core filter holds up to 1024. Overrides the settings file.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub particles: Option<usize>,
    /// Samples M drawn from every particle by a prediction; the core filter holds up to 2048 particles × samples.
    /// Overrides the settings file.
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = count)]
    pub samples: Option<usize>,
    /// Whether features may move; on: births of moving features are half as frequent as of static ones [default: on for
    /// the scenarios of 5.3.1, otherwise off]. Overrides the settings file.
    #[arg(long, value_enum)]
    pub moving: Option<Switch>,
    /// TOML file whose fields replace the defaults that follow from the log; any may be left out. `scphd-sim settings`
    /// prints all with their values; units are in the names, intensities are per m rad.
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
    /// The thesis's filter in fixed capacity, what runs on the target.
    Core,
    /// One Gaussian over the pose and all features; what moves, with --moving on, beside it.
    Joint,
    /// The thesis's recursion by brute force in double precision, slow, in the plane; the likelihood is that of the settings,
    /// single-cluster by default.
    Reference,
    /// The same with the likelihood of RB-PHD SLAM, empty-map approximation.
    RbEmpty,
    /// The same with the likelihood of RB-PHD SLAM, single-feature approximation.
    RbSingle,
    /// The same with the likelihood of RB-PHD SLAM with several features at once.
    RbMulti,
    /// EKF SLAM with nearest-neighbour association, as a yardstick; in the plane.
    Ekf,
    /// The same told the associations by the log's label columns: a bound, never an estimate.
    EkfKnown,
}

/// A language that settings are printed in.
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
    /// The fixed-capacity filter of particles and mixtures.
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
    /// One after the other.
    Both,
}

impl ComparedFilter {
    /// The same as another command names it.
    pub fn choice(self) -> Choice {
        let filter = match self {
            Self::Core => Filter::Core(Precision::F32),
            Self::Joint => Filter::Joint(Precision::F32),
        };
        Choice { filter, likelihood: None }
    }
}

impl ComparedPrecision {
    /// The precisions to compare, in the order of the columns.
    pub fn each(self) -> &'static [Precision] {
        match self {
            Self::F32 => &[Precision::F32],
            Self::F64 => &[Precision::F64],
            Self::Both => &[Precision::F32, Precision::F64],
        }
    }
}

/// A filter with its number type and, where its name says so, its particle likelihood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    pub filter: Filter,
    likelihood: Option<Likelihood>,
}

impl Choice {
    /// The filter asked for, or why there is none such.
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

    /// Its name on the command line.
    pub fn name(&self) -> &'static str {
        match (self.filter, self.likelihood) {
            (Filter::Core(_), _) => "core",
            (filter, likelihood) => filter.name(likelihood.unwrap_or(Likelihood::SingleCluster)),
        }
    }

    /// Whether it uses a setting or an option. One whose name says the likelihood is told it by nothing else.
    pub fn uses(&self, what: &str) -> bool {
        is_used_by(self.filter, what) && !(self.likelihood.is_some() && what == "filter.likelihood")
    }

    /// The settings it works with.
    pub fn settings<K: Kind>(&self, mut settings: K::Settings) -> K::Settings {
        let recursion = K::recursion_mut(&mut settings);
        recursion.likelihood = self.likelihood.unwrap_or(recursion.likelihood);
        settings
    }
}

impl Tuning {
    /// The options that are given, but for the settings file.
    pub fn options(&self) -> Vec<&'static str> {
        let given = [
            (self.particles.is_some(), "--particles"),
            (self.samples.is_some(), "--samples"),
            (self.moving == Some(Switch::On), "--moving on"),
            (self.moving == Some(Switch::Off), "--moving off"),
        ];
        given.into_iter().filter(|(given, _)| *given).map(|(_, option)| option).collect()
    }
}

impl FilterName {
    /// The filter for what is or is not a log, or as good as one, where the command line does not say: a joint map, but for what only a
    /// mixture has.
    pub fn usual(is_log: bool, tuning: &Tuning, threads: u16) -> Self {
        let several = tuning.particles.is_some() || tuning.samples.is_some() || threads > 1;
        if is_log && !several && tuning.moving != Some(Switch::On) { Self::Joint } else { Self::Core }
    }
}

impl MonteCarloArgs {
    /// The filters asked for, or the usual one for what are or are not random worlds.
    pub fn filters(&self, are_worlds: bool) -> Vec<FilterName> {
        if self.filter.is_empty() { vec![FilterName::usual(are_worlds, &self.tuning, 1)] } else { self.filter.clone() }
    }
}

impl RunArgs {
    /// The filter asked for, or the usual one for what is or is not a log in the plane; or why there is none such.
    pub fn filter(&self, is_log: bool) -> Result<Choice, &'static str> {
        let usual = || FilterName::usual(is_log, &self.tuning, self.threads);
        Choice::of(self.filter.unwrap_or_else(usual), self.precision)
    }

    /// The seeds asked for, one after the other.
    pub fn seeds(&self) -> Result<RangeInclusive<u64>, Failure> {
        let first = self.seed.seed;
        let last = first
            .checked_add(u64::from(self.repeat) - 1)
            .ok_or_else(|| Failure::input(format_args!("--seed {first}: too large for --repeat {}", self.repeat)))?;
        Ok(first..=last)
    }

    /// The threads asked for.
    pub fn threads(&self) -> Result<Threads, Failure> {
        Ok(Threads::new(self.threads.into())?)
    }

    /// The options beside [`Tuning`] that are given, and not used by all filters.
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
