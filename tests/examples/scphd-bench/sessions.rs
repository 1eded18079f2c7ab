//! Figures of whole runs: compared with the reference, on a recorded log, on several threads.

use crate::figure::Figure;
use scphd_filters::settings::{Proposal, Settings};
use scphd_filters::slam::{Precision, Slam, core_filter};
use scphd_filters::threads::Threads;
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_run::compare::compare;
use scphd_run::session::{self, Filter, with_roomy_stack};
use scphd_worlds::scenario;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

const SEED: u64 = 1;
/// Number of scans of the comparison with the reference, which takes tenths of a second for each.
const REFERENCE_SCANS: usize = 60;
const THREADS_SCANS: usize = 40;
const THREADS_PARTICLES: usize = 512;
const LOG: &str = "victoria_park";
const LOG_PARTICLES: usize = 100;
/// Number of runs. The fastest one counts, because other load of the machine only increases times.
const RUNS: usize = 3;

/// Prints the figures.
pub fn run(data: &Path) -> Result<(), String> {
    let mut figures = against_reference()?;
    figures.extend(on_threads()?);
    figures.extend(over_log(data)?);
    println!("{}", serde_json::to_string_pretty(&figures).map_err(|error| error.to_string())?);
    Ok(())
}

/// The first scans of the scenario of section 5.3.1, and its settings.
fn thesis_dynamic(scans: usize) -> Result<(Log, Settings), String> {
    const NAME: &str = "thesis-dynamic";
    let mut log = scenario::by_name(NAME, SEED).ok_or("the scenario is gone")?;
    log.scans.truncate(scans);
    let settings = Settings::for_scenario(NAME, &log);
    Ok((log, settings))
}

/// Mean time of a scan, µs: the least of several runs.
fn scan_us(log: &Log, settings: &Settings, filter: Filter, threads: &Threads, runs: usize) -> Result<f64, String> {
    let mut least = f64::INFINITY;
    for _ in 0..runs {
        let session = session::run_on::<Planar>(threads, log, settings, filter, SEED, &mut |_| ());
        let mean = session.map_err(|error| error.to_string())?.summary.scan_us_mean;
        least = least.min(mean.ok_or("no scan")?);
    }
    Ok(least)
}

fn against_reference() -> Result<Vec<Figure>, String> {
    let (log, settings) = thesis_dynamic(REFERENCE_SCANS)?;
    let alone = Threads::default();
    let reference = scan_us(&log, &settings, Filter::Reference, &alone, 1)?;
    let mut figures = Vec::new();
    for (precision, name) in
        [(Precision::F32, "speedup_over_reference"), (Precision::F64, "speedup_over_reference_f64")]
    {
        let filter = scan_us(&log, &settings, Filter::Core(precision), &alone, RUNS)?;
        figures.push(Figure::new(name, reference / filter, "1"));
    }
    let compared = with_roomy_stack(|| compare::<Planar>(&log, &settings, Precision::F64, SEED, |_| ()));
    let overall = compared.map_err(|error| error.to_string())?.map_err(|refusal| refusal.to_string())?.overall;
    figures.push(Figure::new("reference_position_difference_m", overall.estimated_position_m, "m"));
    Ok(figures)
}

fn on_threads() -> Result<[Figure; 2], String> {
    let (log, mut settings) = thesis_dynamic(THREADS_SCANS)?;
    settings.filter.particles = THREADS_PARTICLES;
    let cores = available_parallelism().map_or(1, usize::from);
    let all = Threads::new(cores).map_err(|error| error.to_string())?;
    let filter = Filter::Core(Precision::F32);
    let alone = scan_us(&log, &settings, filter, &Threads::default(), RUNS)?;
    let together = scan_us(&log, &settings, filter, &all, RUNS)?;
    Ok([Figure::new("threads_speedup", alone / together, "1"), Figure::new("threads", cores as f64, "1")])
}

fn over_log(data: &Path) -> Result<Vec<Figure>, String> {
    let folder = data.join(LOG);
    if !folder.is_dir() {
        eprintln!("left out: all times over victoria_park, for there is no {}", folder.display());
        return Ok(Vec::new());
    }
    let log = log_folder::read(&folder).map_err(|error| error.to_string())?;
    let by_default = Settings::for_log(&log);
    let mut many = by_default.clone();
    many.filter.particles = LOG_PARTICLES;
    let mut blind = many.clone();
    blind.filter.proposal = Proposal::Blind;
    [
        ("victoria_park_times_real_time", many),
        ("victoria_park_blind_times_real_time", blind),
        ("victoria_park_default_times_real_time", by_default),
    ]
    .into_iter()
    .map(|(name, settings)| Ok(Figure::new(name, times_real_time(&log, &settings)?, "1")))
    .collect()
}

/// The duration of a log divided by the filter's time for it.
fn times_real_time(log: &Log, settings: &Settings) -> Result<f64, String> {
    let (Some(first), Some(last)) = (log.scans.first(), log.scans.last()) else {
        return Err("a log without scans".into());
    };
    let mut least = Duration::MAX;
    for _ in 0..RUNS {
        let time = with_roomy_stack(|| -> Result<Duration, String> {
            let filter = core_filter(settings, &log.vehicle, log.initial_pose, Precision::F32, SEED);
            drive(log, &mut *filter.map_err(|refusal| refusal.to_string())?)
        });
        least = least.min(time.map_err(|error| error.to_string())??);
    }
    Ok((last.t_s - first.t_s) / least.as_secs_f64())
}

/// The time that a filter takes for a log.
fn drive(log: &Log, filter: &mut (impl Slam + ?Sized)) -> Result<Duration, String> {
    let started = Instant::now();
    for event in events(log) {
        let step = match event {
            Event::Predict { control, dt_s, .. } => filter.predict(control, dt_s).map(drop),
            Event::Fix { fix } => filter.observe(&fix).map(drop),
            Event::Scan { index } => filter.scan(0, &log.scans[index].detections).and_then(|_| filter.pose()).map(drop),
        };
        step.map_err(|refusal| refusal.to_string())?;
    }
    Ok(started.elapsed())
}
