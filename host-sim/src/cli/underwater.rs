//! The commands over underwater logs and scenarios.

use super::args::{Choice, CompareArgs, FigureArgs, FilterName, MonteCarloArgs, RunArgs, Switch, Tuning};
use super::commands::report_health;
use super::compare;
use super::failure::{Failure, notice, print};
use super::monte_carlo::{DEFAULT_RUNS, Destination};
use super::outputs::{Outputs, label, make};
use super::progress::Progress;
use super::repeat::in_parallel;
use scphd_sim::log_folder;
use scphd_sim::monte_carlo::{self, Job, Plan, RunResult, Study};
use scphd_sim::output::comparison::{self, Compared};
use scphd_sim::output::json::Format;
use scphd_sim::output::{json, repeats, table};
use scphd_sim::plot::Figure;
use scphd_sim::session::with_roomy_stack;
use scphd_sim::underwater::log::Log;
use scphd_sim::underwater::session;
use scphd_sim::underwater::settings::Settings;
use scphd_sim::underwater::{self, by_name, lockstep, plot, tables};
use std::borrow::Cow;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Where the log of a run with a certain seed comes from.
pub enum Source {
    /// One log for all seeds.
    Fixed(Box<Log>),
    /// A scenario, with a seed of its own or with that of the run.
    Scenario(String, Option<u64>),
}

/// Whether there is an underwater scenario of that name.
pub fn is_scenario(name: &str) -> bool {
    underwater::SCENARIOS.iter().any(|(scenario, _)| *scenario == name)
}

/// The log of a folder.
pub fn read(dir: &Path) -> Result<Source, Failure> {
    let log = log_folder::read_underwater(dir).map_err(|error| Failure::of_log(dir, &error))?;
    Ok(Source::Fixed(Box::new(log)))
}

/// The underwater scenario of that name or the underwater log in that folder, if it is either.
pub fn source(name: &Path, scenario_seed: Option<u64>) -> Result<Option<Source>, Failure> {
    match name.to_str() {
        Some(name) if is_scenario(name) => Ok(Some(Source::Scenario(name.to_owned(), scenario_seed))),
        _ if log_folder::has_camera(name) => read(name).map(Some),
        _ => Ok(None),
    }
}

impl Source {
    /// The settings a log of this source is run with unless told otherwise: Table 7.1 for a scenario of the thesis.
    pub fn defaults(&self, log: &Log) -> Settings {
        match self {
            Self::Fixed(_) => Settings::for_real_log(log),
            Self::Scenario(..) => Settings::for_log(log),
        }
    }

    /// The log for a run with `seed`.
    pub fn log(&self, seed: u64) -> Result<Cow<'_, Log>, Failure> {
        match self {
            Self::Fixed(log) => Ok(Cow::Borrowed(log)),
            Self::Scenario(name, own) => by_name(name, own.unwrap_or(seed))
                .map(Cow::Owned)
                .ok_or_else(|| Failure::input(format_args!("no underwater scenario '{name}'"))),
        }
    }
}

/// `defaults`, then the settings file, then the command line.
pub fn tuned(defaults: Settings, tuning: &Tuning) -> Result<Settings, Failure> {
    let mut settings = defaults;
    if let Some(path) = &tuning.settings {
        settings = settings.with_file(path)?;
    }
    settings.filter.particles = tuning.particles.unwrap_or(settings.filter.particles);
    settings.filter.samples = tuning.samples.unwrap_or(settings.filter.samples);
    if tuning.moving == Some(Switch::On) {
        return Err(Failure::input("--moving on: underwater runs take everything for static"));
    }
    settings.check().map_err(|error| {
        let name = error.field.rsplit('.').next().unwrap_or(error.field);
        Failure::input(format_args!("--{name} {}: must be {}", error.found, error.range))
    })?;
    Ok(settings)
}

fn chosen(choice: &Choice, mut settings: Settings) -> Settings {
    settings.filter.likelihood = choice.likelihood().unwrap_or(settings.filter.likelihood);
    settings
}

/// Prints the settings of a log or scenario.
pub fn settings(source: &Source, tuning: &Tuning) -> Result<(), Failure> {
    let settings = tuned(source.defaults(&*source.log(0)?), tuning)?;
    let text = settings.to_toml().map_err(|error| Failure::Internal(error.to_string()))?;
    print(text.trim_end())
}

/// One filter over one log or several, with one seed or several.
pub fn run(sources: &[Source], args: RunArgs) -> Result<(), Failure> {
    let choice = args.filter().map_err(Failure::input)?;
    let outputs = Outputs { json: args.json, out: args.out };
    outputs.check()?;
    if outputs.out.is_some() && (sources.len() > 1 || args.repeat > 1) {
        return Err(Failure::input("--out: for a single run only, not with several logs or --repeat"));
    }
    let first = args.seed.seed;
    let runs: Vec<(&Source, u64)> = sources
        .iter()
        .flat_map(|source| (0..u64::from(args.repeat)).map(move |k| (source, first.wrapping_add(k))))
        .collect();
    let mut frames = 0;
    for (source, seed) in &runs {
        let log = source.log(*seed)?;
        tuned(source.defaults(&log), &args.tuning)?;
        frames += log.frames.len();
    }
    let (progress, done) = (Progress::new("underwater".into(), frames), AtomicUsize::new(0));
    let sessions = in_parallel(&runs, args.jobs.into(), |&(source, seed)| {
        let log = source.log(seed)?;
        let settings = chosen(&choice, tuned(source.defaults(&log), &args.tuning)?);
        let mut advance = |_| progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(session::run(&log, &settings, choice.filter, seed, &mut advance)?)
    })?;
    drop(progress);
    let summaries: Vec<_> = sessions.iter().map(|session| session.summary.clone()).collect();
    let [session] = &sessions[..] else {
        if let Some(path) = &outputs.json {
            json::write_summaries(path, &summaries)?;
        }
        let logs: Vec<_> = summaries.chunks(args.repeat as usize).collect();
        return outputs.print(&repeats::render(&logs));
    };
    if let Some(out) = &outputs.out {
        make(out)?;
        tables::write_record(out, &session.record)?;
        let log = runs[0].0.log(runs[0].1)?;
        plot::figure(&log, &[(&label(&session.summary), &session.record)]).write(out, "trajectory")?;
        plot::errors(&log, &[(&label(&session.summary), &session.record)]).write(out, "error")?;
        notice(format_args!("tables and plots are in {}", out.display()));
    }
    if let Some(path) = &outputs.json {
        json::write_summary(path, &session.summary)?;
    }
    outputs.print(&table::render(&summaries))?;
    if let Some(pages) = session.record.frames.iter().filter_map(|frame| frame.pages_used).max() {
        outputs.print(&format!("greatest number of pages in use: {pages}"))?;
    }
    report_health(&outputs, &session.summary, &session.health)?;
    if let [(t_s, what), more @ ..] = &session.left_out[..] {
        let rest = if more.is_empty() { String::new() } else { format!("; and {} more", more.len()) };
        eprintln!("warning: a step before the frame of {t_s} s left out: {what}{rest}");
    }
    Ok(())
}

/// Runs a Monte Carlo study of an underwater scenario, or a part of one.
pub fn study(args: MonteCarloArgs) -> Result<(), Failure> {
    let choices = args
        .filter
        .iter()
        .map(|&name| Choice::of(name, args.precision).map_err(Failure::input))
        .collect::<Result<Vec<_>, _>>()?;
    let source = Source::Scenario(args.sources[0].to_string_lossy().into_owned(), None);
    let runs = args.runs.map_or(DEFAULT_RUNS, |runs| runs as usize);
    let input_sets = args.input_sets.map_or(runs, |sets| sets as usize);
    if !runs.is_multiple_of(input_sets) {
        return Err(Failure::input(format_args!("--runs {runs}: must be a multiple of the {input_sets} input sets")));
    }
    let destination = Destination::of(args.shard, args.json, args.out)?;
    let log = source.log(args.seed)?;
    let first = tuned(source.defaults(&log), &args.tuning)?;
    let names = choices.iter().map(|choice| choice.filter.name(chosen(choice, first.clone()).filter.likelihood).into());
    let plan = Plan {
        format: Format,
        scenario: log.name.clone(),
        filters: names.collect(),
        runs,
        input_sets,
        seed: args.seed,
        settings: first.to_toml().map_err(|error| Failure::Internal(error.to_string()))?,
    };
    let jobs = destination.jobs(&plan);
    let label = format!("{} runs of {}", jobs.len() * choices.len(), plan.filters.join(", "));
    let progress = Progress::new(label, log.frames.len() * jobs.len() * choices.len());
    let done = AtomicUsize::new(0);
    let threads = args.jobs.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let one = |job: &Job, filter: usize| -> Result<RunResult, Failure> {
        let choice = &choices[filter];
        let log = source.log(job.scenario_seed)?;
        let settings = chosen(choice, tuned(source.defaults(&log), &args.tuning)?);
        let mut advance = |_| progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
        let session = session::run(&log, &settings, choice.filter, job.filter_seed, &mut advance)?;
        Ok(session::result(job, settings.filter.samples, session))
    };
    let results = monte_carlo::execute(&jobs, choices.len(), threads, one)?;
    drop(progress);
    destination.deliver(&Study { plan, results })
}

/// One of the figures 7.5 to 7.7: SC-PHD and RB-PHD SLAM over the same survey.
pub fn figure<'n>(number: &'n str, args: &FigureArgs) -> Result<Vec<(&'n str, Figure)>, Failure> {
    let source = Source::Scenario("girona-tank".into(), None);
    let log = source.log(args.seed)?;
    let settings = tuned(source.defaults(&log), &args.tuning)?;
    let filters = [FilterName::Core, FilterName::RbSingle];
    let mut runs = Vec::new();
    for name in filters {
        let choice = Choice::of(name, None).map_err(Failure::input)?;
        let settings = chosen(&choice, settings.clone());
        let label = choice.filter.name(settings.filter.likelihood);
        let progress = Progress::new(label.into(), log.frames.len());
        let session = session::run(&log, &settings, choice.filter, args.seed, &mut |frames| progress.at(frames))?;
        runs.push((label, session.record));
    }
    let runs: Vec<_> = runs.iter().map(|(label, record)| (*label, record)).collect();
    Ok(match number {
        "7.5" => vec![("7.5", plot::trajectories(&log, &runs)), ("7.5-section", plot::figure(&log, &runs[..1]))],
        "7.6" => vec![("7.6", plot::maps(&log, &runs))],
        _ => vec![("7.7", plot::squared_errors(&log, &runs))],
    })
}

/// Filter and reference in lockstep over an underwater scenario, in every precision asked for.
pub fn compare(args: CompareArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let source = Source::Scenario(args.source.to_string_lossy().into_owned(), args.scenario_seed.scenario_seed);
    let log = source.log(seed)?;
    if args.out.is_some() {
        return Err(Failure::input("--out: not for underwater scenarios"));
    }
    let outputs = Outputs { json: args.json, out: None };
    outputs.check()?;
    let mut settings = tuned(source.defaults(&log), &args.tuning)?;
    settings.filter.particles = args.tuning.particles.unwrap_or(compare::PARTICLES);
    settings.filter.samples = args.tuning.samples.unwrap_or(compare::SAMPLES);
    let mut compared = Vec::new();
    for &precision in args.precision.each() {
        let progress = Progress::new(format!("compare {}", compare::name(precision)), log.frames.len());
        let frames = log.frames.len();
        let step = || lockstep::compare(&log, &settings, precision, seed, frames, |done| progress.at(done));
        let differences = with_roomy_stack(step)
            .map_err(|error| Failure::Internal(format!("cannot start a thread: {error}")))?
            .map_err(|refusal| Failure::input(format_args!("the filter refuses: {refusal}")))?;
        compared.push(Compared {
            format: Format,
            log: log.name.clone(),
            precision: compare::name(precision).into(),
            particles: settings.filter.particles,
            samples: settings.filter.samples,
            seed,
            differences,
            settings: serde_json::to_value(&settings).unwrap_or_default(),
        });
    }
    if let Some(path) = &outputs.json {
        comparison::write_json(path, &compared)?;
    }
    outputs.print(&comparison::render(&compared))
}
