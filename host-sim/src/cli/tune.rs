//! `scphd-sim tune`.

use super::args::{Choice, TuneArgs};
use super::failure::{Failure, notice, print};
use super::outputs::{check_file, print_beside, write_file};
use super::progress::Progress;
use super::source::{Found, Source, tuned_from};
use scphd_sim::log::Log;
use scphd_sim::output::tuning;
use scphd_sim::session::Filter;
use scphd_sim::settings::{Origin, Origins, Settings};
use scphd_sim::tune::{self, Effort, Plan, TuneError, Tuned};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Learns settings, judges them, prints what came out, and writes all of them where asked to.
pub fn tune(args: TuneArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let choice = Choice::of(args.filter, None).map_err(Failure::input)?;
    if matches!(choice.filter, Filter::Ekf(_)) {
        return Err(Failure::input("--filter: the EKF has noise of its own, and no settings to learn"));
    }
    if seed.checked_add(2 * u64::from(args.runs)).is_none() {
        return Err(Failure::input(format_args!("--seed {seed}: too large for --runs {}", args.runs)));
    }
    if let Some(count) = args.count {
        return study(&args, choice, count);
    }
    let source = Found::find(&args.source, args.scenario_seed.scenario_seed)?.planar("tune")?;
    let log = &*source.log(seed)?;
    if args.truth && log.truth.is_empty() {
        return Err(Failure::input(format_args!("--truth: {} has none", log.name)));
    }
    if let Some(path) = &args.out {
        check_file("--out", path)?;
    }
    let (settings, mut origins, tuned) = one(&source, log, &args, choice)?;
    if let Some(path) = &args.out {
        let proposed = &tuned.outcome.settings;
        origins.set_changed(&settings, proposed, &Origin::Learnt);
        let text = origins.annotated(proposed).map_err(|error| Failure::Internal(error.to_string()))?;
        write_file("--out", path, text.as_bytes())?;
        notice(format_args!("settings are in {}", path.display()));
    }
    print_beside(args.out.as_deref(), &tuning::render(&log.name, &tuned, args.truth))
}

/// So many scenarios, each of the seed after that of the one before: a line each.
fn study(args: &TuneArgs, choice: Choice, count: u32) -> Result<(), Failure> {
    let first = args.scenario_seed.scenario_seed.unwrap_or(args.seed.seed);
    let last = first.checked_add(u64::from(count) - 1);
    let last = last.ok_or_else(|| Failure::input(format_args!("--count {count}: too large for seed {first}")))?;
    let found = Found::find(&args.source, None)?;
    if !found.is_seeded() || args.out.is_some() {
        return Err(Failure::input("--count: of a scenario, and without --out"));
    }
    let source = found.planar("tune")?;
    let mut all = Vec::new();
    for seed in first..=last {
        let log = &*source.log(seed)?;
        let (_, _, tuned) = one(&source, log, args, choice)?;
        print(&tuning::line(&log.name, &tuned))?;
        all.push(tuned);
    }
    print(&tuning::summary(&all))
}

/// The settings it started from, where they are from, and what came out.
fn one(source: &Source, log: &Log, args: &TuneArgs, choice: Choice) -> Result<(Settings, Origins, Tuned), Failure> {
    let mut origins = source.origins(log);
    let settings = choice.settings(tuned_from(source.defaults(log), &mut origins, &args.tuning)?);
    let duration_s = log.scans.last().map_or(0.0, |scan| scan.t_s) - log.scans.first().map_or(0.0, |scan| scan.t_s);
    let until_s = args.until.unwrap_or(0.5 * duration_s);
    let jobs = args.jobs.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let plan = Plan {
        filter: choice.filter,
        learn: tune::scans_between(log, args.from, until_s),
        rounds: usize::from(args.rounds),
        effort: Effort { seed: args.seed.seed, runs: u64::from(args.runs), jobs },
    };
    let most = tune::most_runs(&plan);
    let (progress, done) = (Progress::new(format!("tune {}, runs", log.name), most), AtomicUsize::new(0));
    let tuned = tune::tune(log, &settings, &plan, &|| progress.at(done.fetch_add(1, Ordering::Relaxed) + 1));
    drop(progress);
    let tuned = tuned.map_err(|error| match error {
        TuneError::Session(error) => error.into(),
        TuneError::EmptyPart => Failure::input(format_args!("--from, --until: {error}")),
        error => Failure::Internal(error.to_string()),
    })?;
    Ok((settings, origins, tuned))
}
