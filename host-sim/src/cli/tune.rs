//! `scphd-sim tune`.

use super::args::{Choice, TuneArgs};
use super::device::{Input, On};
use super::failure::{Failure, notice};
use super::offer::Offer;
use super::outputs::{check_file, print_beside, write_file};
use super::progress::Progress;
use super::source::{Found, Source, either};
use scphd_filters::kind::Kind;
use scphd_filters::settings::{Origin, Origins};
use scphd_filters::slam::Slam;
use scphd_log::log::Scan;
use scphd_run::session::Filter;
use scphd_run::tune::{self, Effort, Plan, Trials, TuneError, Tuned};
use scphd_view::output::tuning;
use std::borrow::Cow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Learns settings, judges them, prints the result, and writes all settings if requested.
pub fn tune(args: TuneArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let choice = Choice::of(args.filter, None).map_err(Failure::input)?;
    if matches!(choice.filter, Filter::Ekf(_)) {
        return Err(Failure::input("--filter: the EKF has noise of its own, and no settings to learn"));
    }
    if seed.checked_add(2 * u64::from(args.runs)).is_none() {
        return Err(Failure::input(format_args!("--seed {seed}: too large for --runs {}", args.runs)));
    }
    let scenario_seed = args.scenario_seed.scenario_seed.filter(|_| args.count.is_none());
    let found = Found::find(&args.source, scenario_seed)?;
    match args.count {
        Some(count) => either!(found, source => study(&source, &args, choice, count)),
        None => either!(found, source => single(&source, &args, choice)),
    }
}

fn single<K: Offer>(source: &Source<K>, args: &TuneArgs, choice: Choice) -> Result<(), Failure> {
    let log = &*source.log(args.seed.seed)?;
    if args.truth && K::truth(log).is_empty() {
        return Err(Failure::input(format_args!("--truth: {} has none", K::name(log))));
    }
    if let Some(path) = &args.out {
        check_file("--out", path)?;
    }
    let (settings, mut origins, tuned) = one(source, log, args, choice)?;
    if let Some(path) = &args.out {
        let proposed = &tuned.outcome.settings;
        origins.set_changed(&settings, proposed, &Origin::Learnt);
        let text = origins.overrides(proposed)?;
        write_file("--out", path, text.as_bytes())?;
        notice(format_args!("settings are in {}", path.display()));
    }
    print_beside(args.out.as_deref(), &tuning::render(K::name(log), &tuned, args.truth))
}

/// Repeats it for `count` scenarios with consecutive seeds, with a line for each.
fn study<K: Offer>(source: &Source<K>, args: &TuneArgs, choice: Choice, count: u32) -> Result<(), Failure> {
    let first = args.scenario_seed.scenario_seed.unwrap_or(args.seed.seed);
    let last = first.checked_add(u64::from(count) - 1);
    let last = last.ok_or_else(|| Failure::input(format_args!("--count {count}: too large for seed {first}")))?;
    if !source.is_seeded() || args.out.is_some() {
        return Err(Failure::input("--count: of a scenario, and without --out"));
    }
    let mut all = Vec::new();
    for seed in first..=last {
        let log = &*source.log(seed)?;
        let (_, _, tuned) = one(source, log, args, choice)?;
        print_beside(None, &tuning::line(K::name(log), &tuned))?;
        all.push(tuned);
    }
    print_beside(None, &tuning::summary(&all))
}

/// The settings before, their origins, and the result.
type Outcome<K> = (<K as Kind>::Settings, Origins, Tuned<<K as Kind>::Settings>);

fn one<K: Offer>(source: &Source<K>, log: &K::Log, args: &TuneArgs, choice: Choice) -> Result<Outcome<K>, Failure> {
    let mut origins = source.origins(log);
    let settings = choice.settings::<K>(source.tuned_from(&mut origins, log, &args.tuning, &[choice])?);
    let time = |scan: Option<&Scan<K>>| scan.map_or(0.0, |scan| scan.t_s);
    let duration_s = time(K::scans(log).last()) - time(K::scans(log).first());
    let until_s = args.until.unwrap_or(0.5 * duration_s);
    let jobs = args.jobs.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let plan = Plan {
        filter: choice.filter,
        learn: tune::scans_between::<K>(log, args.from, until_s),
        rounds: usize::from(args.rounds),
        effort: Effort { seed: args.seed.seed, runs: u64::from(args.runs), jobs },
    };
    let most = tune::most_runs(&plan);
    let (progress, done) = (Progress::new(format!("tune {}, runs", K::name(log)), most), AtomicUsize::new(0));
    let advance = || progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
    let on_device = |tasks: &[(&K::Settings, u64)]| {
        if tasks.is_empty() {
            return Ok(Vec::new());
        }
        let device = args.device.ok_or_else(|| TuneError::Unfit("no device".into()))?;
        let input = |run: usize| Ok((Cow::Borrowed(log), tasks[run].0.clone(), tasks[run].1));
        let finish = |_, slam: &mut dyn Slam<K>, (log, settings, _): &Input<'_, K>| {
            advance();
            Ok(tune::trial_of::<K>(slam, log, settings, &plan.learn).map_err(TuneError::from))
        };
        let on = On { filter: plan.filter, threads: jobs, predicted: true };
        K::run_on(device, on, tasks.len(), input, finish).map_err(|failure| TuneError::Unfit(failure.message()))
    };
    let trials: Option<Trials<'_, K::Settings>> = args.device.is_some().then_some(&on_device);
    let tuned = tune::tune::<K>(log, &settings, &plan, &advance, trials);
    drop(progress);
    let tuned = tuned.map_err(|error| match error {
        TuneError::Session(error) => error.into(),
        TuneError::Unfit(why) => Failure::input(format_args!("{}: {why}", K::name(log))),
        TuneError::EmptyPart => Failure::input(format_args!("--from, --until: {error}")),
        error => Failure::Internal(error.to_string()),
    })?;
    Ok((settings, origins, tuned))
}
