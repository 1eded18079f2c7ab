//! The commands over underwater logs and scenarios.

use super::args::{Choice, CompareArgs, FigureArgs, FilterName, MonteCarloArgs, RunArgs, Switch, Tuning};
use super::commands::report_health;
use super::compare;
use super::failure::{Failure, notice, print, warn_of_errors};
use super::monte_carlo::{Destination, Extent, distinct, input_sets};
use super::outputs::{Outputs, label, make};
use super::progress::Progress;
use super::repeat::in_parallel;
use super::source::{of_options, out_of_range, settings_command};
use scphd_sim::log_folder;
use scphd_sim::monte_carlo::{self, Job, Plan, RunResult, Study};
use scphd_sim::output::comparison::{self, Compared};
use scphd_sim::output::json::Format;
use scphd_sim::output::{json, repeats, table};
use scphd_sim::plot::Figure;
use scphd_sim::session::with_roomy_stack;
use scphd_sim::settings::Origins;
use scphd_sim::underwater::log::Log;
use scphd_sim::underwater::session;
use scphd_sim::underwater::settings::{Settings, stated};
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

impl Source {
    /// The settings a log of this source is run with unless told otherwise: Table 7.1 for a scenario of the thesis.
    pub fn defaults(&self, log: &Log) -> Settings {
        match self {
            Self::Fixed(_) => Settings::for_real_log(log),
            Self::Scenario(..) => Settings::for_log(log),
        }
    }

    /// Where each of the [`defaults`](Self::defaults) is from.
    pub fn origins(&self, log: &Log) -> Origins {
        Origins::of(&self.defaults(log), stated(matches!(self, Self::Scenario(..))))
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

    /// The defaults, then the settings file, then the command line.
    pub fn tuned(&self, log: &Log, tuning: &Tuning) -> Result<Settings, Failure> {
        tuned(self.defaults(log), log, tuning)
    }
}

/// `defaults`, then the settings file, then the command line.
fn tuned(defaults: Settings, log: &Log, tuning: &Tuning) -> Result<Settings, Failure> {
    tuned_from(defaults, &mut Origins::default(), log, tuning)
}

/// [`tuned`], and where each setting is from, given where the defaults are from.
fn tuned_from(defaults: Settings, origins: &mut Origins, log: &Log, tuning: &Tuning) -> Result<Settings, Failure> {
    let mut settings = defaults;
    if let Some(path) = &tuning.settings {
        settings = origins.with_file(path, |text| settings.with_toml(text))?;
    }
    of_options(origins, tuning);
    settings.filter.particles = tuning.particles.unwrap_or(settings.filter.particles);
    settings.filter.samples = tuning.samples.unwrap_or(settings.filter.samples);
    if tuning.moving == Some(Switch::On) {
        return Err(Failure::input("--moving on: underwater runs take everything for static"));
    }
    settings.check().and_then(|()| settings.check_births(log)).map_err(|error| out_of_range(&error, tuning))?;
    Ok(settings)
}

fn chosen(choice: &Choice, mut settings: Settings) -> Settings {
    settings.filter.likelihood = choice.likelihood().unwrap_or(settings.filter.likelihood);
    settings
}

/// Prints the settings of a log or scenario.
pub fn settings(source: &Source, tuning: &Tuning) -> Result<(), Failure> {
    let log = &*source.log(0)?;
    let mut origins = source.origins(log);
    let settings = tuned_from(source.defaults(log), &mut origins, log, tuning)?;
    let text = origins.annotated(&settings).map_err(|error| Failure::Internal(error.to_string()))?;
    print(text.trim_end())
}

/// One filter over one log or several, with one seed or several; `names` are what the sources were called.
pub fn run(sources: &[Source], names: &[String], args: RunArgs) -> Result<(), Failure> {
    let choice = args.filter(false).map_err(Failure::input)?;
    let (threads, seeds) = (args.threads()?, args.seeds()?);
    let outputs = Outputs { json: args.json, out: args.out };
    outputs.check()?;
    if outputs.out.is_some() && (sources.len() > 1 || args.repeat > 1) {
        return Err(Failure::input("--out: for a single run only, not with several logs or --repeat"));
    }
    let runs: Vec<(&Source, u64)> =
        sources.iter().flat_map(|source| seeds.clone().map(move |seed| (source, seed))).collect();
    let mut frames = 0;
    for (source, seed) in &runs {
        let log = source.log(*seed)?;
        source.tuned(&log, &args.tuning)?;
        frames += log.frames.len();
    }
    let (progress, done) = (Progress::new("underwater".into(), frames), AtomicUsize::new(0));
    let sessions = in_parallel(&runs, args.jobs.into(), |&(source, seed)| {
        let log = source.log(seed)?;
        let settings = chosen(&choice, source.tuned(&log, &args.tuning)?);
        let mut advance = |_| progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(session::run_on(&threads, &log, &settings, choice.filter, seed, &mut advance)?)
    })?;
    drop(progress);
    let summaries: Vec<_> = sessions.iter().map(|session| session.summary.clone()).collect();
    let [session] = &sessions[..] else {
        if let Some(path) = &outputs.json {
            json::write_summaries(path, &summaries)?;
        }
        let logs: Vec<_> = summaries.chunks(args.repeat as usize).collect();
        outputs.print(&repeats::render(&logs))?;
        logs.iter().for_each(|runs| warn_of_errors(runs));
        return Ok(());
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
        notice(format_args!("warning: a step before the frame of {t_s} s left out: {what}{rest}"));
    }
    warn_of_errors(&summaries);
    names.first().map_or(Ok(()), |name| outputs.print(&settings_command(name, &args.tuning)))
}

/// Runs a Monte Carlo study of an underwater scenario or of logs, or a part of one.
pub fn study(sources: &[Source], args: MonteCarloArgs) -> Result<(), Failure> {
    if let Some(path) = &args.variants {
        return Err(Failure::input(format_args!("--variants {}: in the plane only", path.display())));
    }
    let filters = args.filters(false).into_iter();
    let choices =
        filters.map(|name| Choice::of(name, args.precision).map_err(Failure::input)).collect::<Result<Vec<_>, _>>()?;
    let logs = match sources {
        [Source::Scenario(..)] => None,
        logs => Some(logs.len()),
    };
    let extent = Extent::of(&args, logs);
    let input_sets = input_sets(&extent, logs, None)?;
    let source = |input: usize| &sources[input % sources.len()];
    let mut plan = Plan {
        format: Format,
        scenario: String::new(),
        filters: Vec::new(),
        runs: extent.runs,
        input_sets,
        seed: args.seed,
        settings: String::new(),
        variants: Vec::new(),
    };
    // Settings that are bad for one of several logs show before any is run.
    let mut inputs = Vec::new();
    for input in 0..sources.len() {
        let log = source(input).log(args.seed)?;
        inputs.push((log.name.clone(), source(input).tuned(&log, &args.tuning)?, log.frames.len()));
    }
    let first = &inputs[0].1;
    plan.scenario = inputs.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>().join(", ");
    let name = |choice: &Choice| choice.filter.name(chosen(choice, first.clone()).filter.likelihood).to_owned();
    plan.filters = distinct(choices.iter().map(name))?;
    plan.settings = first.to_toml().map_err(|error| Failure::Internal(error.to_string()))?;
    let destination = Destination::of(args.shard, args.json, args.out)?;
    let jobs = destination.jobs(&plan);
    let label = format!("{} runs of {}", jobs.len() * choices.len(), plan.filters.join(", "));
    let frames: usize = jobs.iter().map(|job| inputs[job.input % inputs.len()].2).sum();
    let progress = Progress::new(label, frames * choices.len());
    let done = AtomicUsize::new(0);
    let threads = args.jobs.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let one = |job: &Job, filter: usize| -> Result<RunResult, Failure> {
        let choice = &choices[filter];
        let log = source(job.input).log(job.scenario_seed)?;
        let settings = chosen(choice, source(job.input).tuned(&log, &args.tuning)?);
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
    let settings = source.tuned(&log, &args.tuning)?;
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

/// Filter and reference in lockstep over an underwater scenario or log, in every precision asked for, with the recursion of the
/// thesis, which is all that the reference has.
pub fn compare(source: &Source, args: CompareArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let log = source.log(seed)?;
    if args.out.is_some() {
        return Err(Failure::input("--out: not in space"));
    }
    let outputs = Outputs { json: args.json, out: None };
    outputs.check()?;
    let mut settings = tuned(Settings::for_log(&log), &log, &args.tuning)?;
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
