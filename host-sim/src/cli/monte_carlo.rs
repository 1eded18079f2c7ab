//! The commands for Monte Carlo studies.

use super::args::{DeviceName, MonteCarloArgs, Tuning};
use super::contender::Contender;
use super::device::{self, Input, On};
use super::failure::{Failure, notice};
use super::offer::Offer;
use super::outputs::{Outputs, make};
use super::progress::Progress;
use super::source::{Found, Source, Sources, either};
use scphd_filters::slam::Slam;
use scphd_run::monte_carlo::{self, Job, Plan, RunResult, Study, overview};
use scphd_run::session;
use scphd_view::output::{self, studies};
use scphd_view::plot::study;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// The inputs of a study: a scenario, or logs.
pub struct Inputs<K: Offer>(Vec<Source<K>>);

impl<K: Offer> Inputs<K> {
    pub fn of_scenario(name: &str) -> Result<Self, Failure> {
        Ok(Self(vec![Source::scenario(name.to_owned(), None)?]))
    }

    /// The source of input set `input`.
    fn source(&self, input: usize) -> &Source<K> {
        &self.0[input % self.0.len()]
    }

    /// Number of different inputs, if it is fixed.
    fn sets(&self) -> Option<usize> {
        match &self.0[..] {
            [Source::Seeded(_)] => None,
            logs => Some(logs.len()),
        }
    }

    /// Names of the logs or the scenario.
    fn name(&self, seed: u64) -> Result<String, Failure> {
        let names = self.0.iter().map(|source| Ok(K::name(&*source.log(seed)?).to_owned()));
        Ok(names.collect::<Result<Vec<_>, Failure>>()?.join(", "))
    }

    fn settings(&self, job: &Job, tuning: &Tuning, contenders: &[Contender]) -> Result<K::Settings, Failure> {
        let source = self.source(job.input);
        let choices: Vec<_> = contenders.iter().map(Contender::choice).collect();
        source.tuned(&*source.log(job.scenario_seed)?, tuning, &choices)
    }
}

/// Number of runs and inputs, and the seed.
pub struct Extent {
    pub runs: usize,
    pub input_sets: Option<usize>,
    pub seed: u64,
}

impl Extent {
    /// The extent that the command line requests; the default for logs is a run for each.
    fn of(args: &MonteCarloArgs, logs: Option<usize>) -> Self {
        let runs = args.runs.map_or_else(|| logs.unwrap_or(DEFAULT_RUNS), |runs| runs as usize);
        Self { runs, input_sets: args.input_sets.map(|sets| sets as usize), seed: args.seed }
    }
}

/// Number of different inputs: that of `logs`, the requested one, the default `usual`, or the number of runs.
fn input_sets(extent: &Extent, logs: Option<usize>, usual: Option<usize>) -> Result<usize, Failure> {
    let runs = extent.runs;
    let input_sets = match (logs, extent.input_sets) {
        (Some(logs), Some(sets)) if logs != sets => {
            return Err(Failure::input(format_args!("--input-sets {sets}: the logs make {logs}")));
        }
        (Some(logs), _) => logs,
        (None, asked) => asked.or(usual).unwrap_or(runs),
    };
    if !runs.is_multiple_of(input_sets) {
        return Err(Failure::input(format_args!("--runs {runs}: must be a multiple of the {input_sets} input sets")));
    }
    Ok(input_sets)
}

/// The names of the filters of a study, which must be distinct.
pub fn distinct(names: impl IntoIterator<Item = String>) -> Result<Vec<String>, Failure> {
    let mut distinct: Vec<String> = Vec::new();
    for name in names {
        if distinct.contains(&name) {
            return Err(Failure::input(format_args!("--filter: {name} is there twice")));
        }
        distinct.push(name);
    }
    Ok(distinct)
}

/// The plan of a study with `contenders`.
pub fn plan<K: Offer>(
    inputs: &Inputs<K>,
    contenders: &[Contender],
    tuning: &Tuning,
    extent: &Extent,
) -> Result<Plan, Failure> {
    let runs = extent.runs;
    let usual = inputs.0[0].runs_per_input().filter(|&n| runs.is_multiple_of(n)).map(|n| runs / n);
    let input_sets = input_sets(extent, inputs.sets(), usual)?;
    let mut plan = Plan {
        scenario: inputs.name(extent.seed)?,
        filters: Vec::new(),
        runs,
        input_sets,
        seed: extent.seed,
        settings: String::new(),
        variants: Vec::new(),
    };
    let first = inputs.settings(&plan.job(0), tuning, contenders)?;
    // Invalid settings for one of several logs are reported before any run.
    for input in 1..inputs.sets().unwrap_or(1) {
        let settings = inputs.settings(&plan.job(input * (runs / input_sets)), tuning, contenders)?;
        contenders.iter().try_for_each(|contender| contender.settings::<K>(settings.clone()).map(drop))?;
    }
    let all =
        contenders.iter().map(|contender| contender.settings::<K>(first.clone())).collect::<Result<Vec<_>, _>>()?;
    plan.filters = distinct(contenders.iter().zip(&all).map(|(contender, settings)| contender.name::<K>(settings)))?;
    let toml = |settings: &K::Settings| toml::to_string(settings).map_err(Failure::from);
    plan.settings = toml(&first)?;
    if contenders.iter().any(Contender::is_variant) {
        plan.variants = all.iter().map(toml).collect::<Result<_, _>>()?;
    }
    Ok(plan)
}

/// Executes a plan.
pub fn run<K: Offer>(
    plan: &Plan,
    inputs: &Inputs<K>,
    contenders: &[Contender],
    tuning: &Tuning,
    (threads, device): (Option<u16>, Option<DeviceName>),
) -> Result<Study, Failure> {
    let threads = threads.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let jobs = plan.jobs();
    let mut scans = 0;
    for job in &jobs {
        match inputs.source(job.input) {
            Source::Fixed(log) | Source::Frozen(_, log) => scans += K::scans(log).len(),
            // All seeds of a scenario have the same number of scans.
            source @ Source::Seeded(_) => {
                scans = K::scans(&*source.log(job.scenario_seed)?).len() * jobs.len();
                break;
            }
        }
    }
    let label = format!("{} runs of {}", jobs.len() * contenders.len(), plan.filters.join(", "));
    let progress = Progress::new(label, scans * contenders.len());
    let done = AtomicUsize::new(0);
    let advance = |scans| progress.at(done.fetch_add(scans, Ordering::Relaxed) + scans);
    let input = |job: &Job, filter: usize| -> Result<Input<'_, K>, Failure> {
        let log = inputs.source(job.input).log(job.scenario_seed)?;
        let settings = contenders[filter].settings::<K>(inputs.settings(job, tuning, contenders)?)?;
        Ok((log, settings, job.filter_seed))
    };
    let result = |job: &Job, filter: usize, settings: &K::Settings, session| {
        let result = RunResult::of(job, K::recursion(settings).samples, session);
        RunResult { filter: plan.filters[filter].clone(), ..result }
    };
    let results = if let Some(device) = device {
        let mut all = Vec::with_capacity(jobs.len() * contenders.len());
        for (filter, contender) in contenders.iter().enumerate() {
            let finish = |run: usize, slam: &mut dyn Slam<K>, input: &Input<'_, K>| {
                let session = device::session(slam, contender.filter(), input)?;
                advance(K::scans(&input.0).len());
                Ok(result(&jobs[run], filter, &input.1, session))
            };
            let on = On { filter: contender.filter(), threads, predicted: false };
            all.extend(K::run_on(device, on, jobs.len(), |run| input(&jobs[run], filter), finish)?);
        }
        all
    } else {
        let one = |job: &Job, filter: usize| -> Result<RunResult, Failure> {
            let (log, settings, seed) = input(job, filter)?;
            let session = session::run::<K>(&log, &settings, contenders[filter].filter(), seed, &mut |_| advance(1))?;
            Ok(result(job, filter, &settings, session))
        };
        monte_carlo::execute(&jobs, contenders.len(), threads, one)?
    };
    Ok(Study { plan: plan.clone(), results })
}

pub fn study(args: MonteCarloArgs) -> Result<(), Failure> {
    let contenders = Contender::all(&args, false)?;
    let found = args.sources.iter().map(|source| Found::find(source, None)).collect::<Result<Vec<_>, _>>()?;
    if let (Some(scenario), 2..) = (found.iter().zip(&args.sources).find(|(found, _)| found.is_seeded()), found.len()) {
        let name = scenario.1.display();
        return Err(Failure::input(format_args!("{name}: a study is of one scenario or of several folders")));
    }
    either!(Sources::of(found)?, sources => study_of(&Inputs(sources), &contenders, args))
}

fn study_of<K: Offer>(inputs: &Inputs<K>, contenders: &[Contender], args: MonteCarloArgs) -> Result<(), Failure> {
    let outputs = Outputs { json: args.json.clone(), out: args.out.clone() };
    outputs.check()?;
    let extent = Extent::of(&args, inputs.sets());
    let plan = plan(inputs, contenders, &args.tuning, &extent)?;
    let study = run(&plan, inputs, contenders, &args.tuning, (args.jobs, args.device))?;
    report(&study, &outputs)
}

/// Default number of runs of a study of a scenario.
const DEFAULT_RUNS: usize = 100;

/// Writes the files, then prints the table.
fn report(study: &Study, outputs: &Outputs) -> Result<(), Failure> {
    if let Some(out) = &outputs.out {
        make(out)?;
        studies::write_tables(out, study)?;
        study::figure(study).write(out, "study")?;
        notice(format_args!("tables and plots are in {}", out.display()));
    }
    if let Some(path) = &outputs.json {
        overview::write_json(path, study)?;
    }
    outputs.print(&output::overview::render(study))?;
    for filter in &study.plan.filters {
        warn_of_study(study, filter);
    }
    Ok(())
}

/// Warns, on stderr, of a filter whose estimate is worse than dead reckoning in some runs.
fn warn_of_study(study: &Study, filter: &str) {
    let runs = study.results.iter().filter(|result| result.filter == filter);
    let (known, worse) = runs
        .filter_map(RunResult::worse_than_dead_reckoning)
        .fold((0, 0), |(known, worse), is_worse| (known + 1, worse + usize::from(is_worse)));
    if worse > 0 {
        notice(format_args!(
            "warning: {} by {filter}: the estimate is worse than dead reckoning in {worse} of {known} runs",
            study.plan.scenario
        ));
    }
}
