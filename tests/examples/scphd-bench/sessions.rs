//! Figures of whole runs: on a recorded log, and on several threads.

use crate::figure::Figure;
use scphd_filters::settings::{Proposal, Settings};
use scphd_filters::slam::{Precision, Slam, core_filter};
use scphd_filters::threads::Threads;
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_run::session::{self, Filter, with_roomy_stack};
use scphd_worlds::scenario;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

const SEED: u64 = 1;
const THREADS_SCANS: usize = 40;
const THREADS_PARTICLES: usize = 512;
const LOG: &str = "victoria_park";
const LOG_PARTICLES: usize = 100;
/// Number of runs. The fastest one counts, because other load of the machine only increases times.
const RUNS: usize = 3;

pub fn run(data: &Path) -> Result<(), String> {
    let mut figures = on_threads()?.to_vec();
    figures.extend(over_log(data)?);
    println!("{}", serde_json::to_string_pretty(&figures).map_err(|error| error.to_string())?);
    Ok(())
}

/// Mean time of a scan, µs: the least of several runs.
fn scan_us(log: &Log, settings: &Settings, threads: &Threads) -> Result<f64, String> {
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let filter = Filter::Core(Precision::F32);
        let session = session::run_on::<Planar>(threads, log, settings, filter, SEED, &mut |_| ());
        let mean = session.map_err(|error| error.to_string())?.summary.scan_us_mean;
        least = least.min(mean.ok_or("no scan")?);
    }
    Ok(least)
}

fn on_threads() -> Result<[Figure; 2], String> {
    const NAME: &str = "thesis-dynamic";
    let mut log = scenario::by_name(NAME, SEED).ok_or("the scenario is gone")?;
    log.scans.truncate(THREADS_SCANS);
    let mut settings = Settings::for_scenario(NAME, &log);
    settings.filter.particles = THREADS_PARTICLES;
    let cores = available_parallelism().map_or(1, usize::from);
    let all = Threads::new(cores).map_err(|error| error.to_string())?;
    let alone = scan_us(&log, &settings, &Threads::default())?;
    let together = scan_us(&log, &settings, &all)?;
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
