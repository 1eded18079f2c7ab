//! Studies over random worlds, which go on where they were stopped.

use super::args::{Choice, MonteCarloArgs};
use super::failure::{Failure, notice};
use super::outputs::{Outputs, check_file};
use super::progress::Progress;
use super::repeat::in_parallel;
use super::source::{Source, tuned};
use scphd_sim::monte_carlo::worlds::{Standing, WorldRun, lines, standing, told, write_json};
use scphd_sim::scenario::WORLDS;
use scphd_sim::session;
use std::fs::{File, OpenOptions};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Worlds of a study unless told otherwise.
const DEFAULT_RUNS: u32 = 100;

/// The kind of worlds that `monte-carlo` of these sources is of, if it is of any.
pub fn asked_for(args: &MonteCarloArgs) -> Option<&'static str> {
    let [source] = &args.sources[..] else { return None };
    WORLDS.into_iter().find(|name| source.as_os_str() == *name)
}

/// Runs every filter in every world, and prints a line a world and the filters' standings. What is in the file of `--out`
/// already is not run again.
pub fn study(name: &str, args: MonteCarloArgs) -> Result<(), Failure> {
    if args.shard.is_some() || args.input_sets.is_some() {
        return Err(Failure::input(
            "--shard, --input-sets: not with worlds; give parts of them different --seed and --runs",
        ));
    }
    let choices = args
        .filter
        .iter()
        .map(|&name| Choice::of(name, args.precision).map_err(Failure::input))
        .collect::<Result<Vec<_>, _>>()?;
    let outputs = Outputs { json: args.json, out: None };
    outputs.check()?;
    let source = Source::scenario(name.to_owned(), None)?;
    let runs = args.runs.unwrap_or(DEFAULT_RUNS);
    let end = args.seed.checked_add(u64::from(runs));
    let end = end.ok_or_else(|| Failure::input(format_args!("--seed {}: too large for --runs {runs}", args.seed)))?;
    let seeds: Vec<u64> = (args.seed..end).collect();
    let journal = args.out.as_deref().map(Journal::open).transpose()?;

    let jobs: Vec<(u64, Choice)> =
        seeds.iter().flat_map(|&seed| choices.iter().map(move |&choice| (seed, choice))).collect();
    let threads = args.jobs.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let progress = Progress::new(format!("{} runs", jobs.len()), jobs.len());
    let done = AtomicUsize::new(0);
    let runs = in_parallel(&jobs, threads, |&(seed, choice)| {
        let log = source.log(seed)?;
        let settings = choice.settings(tuned(source.defaults(&log), &args.tuning)?);
        let fingerprint = fingerprint(&settings.to_toml().map_err(|error| Failure::Internal(error.to_string()))?);
        let filter = choice.filter.name(settings.filter.likelihood);
        let known = journal.as_ref().and_then(|journal| journal.find(&log.name, filter, &fingerprint));
        let run = match known {
            Some(run) => run,
            None => {
                let summary = session::run(&log, &settings, choice.filter, seed, &mut |_| ())?.summary;
                let run = WorldRun::of(&summary, &fingerprint)
                    .ok_or_else(|| Failure::Internal(format!("{}: a world without truth", log.name)))?;
                if let Some(journal) = &journal {
                    journal.add(&run)?;
                }
                run
            }
        };
        progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(run)
    })?;
    drop(progress);

    let filters: Vec<String> = runs.iter().take(choices.len()).map(|run| run.filter.clone()).collect();
    let worlds: Vec<&str> = runs.iter().step_by(choices.len()).map(|run| run.world.as_str()).collect();
    let beside = filters.iter().skip(1).filter_map(|other| standing(&runs, filters.first()?, other, &worlds));
    let mut standings: Vec<Standing> = beside.collect();
    if standings.is_empty() {
        standings.extend(filters.first().and_then(|only| standing(&runs, only, only, &worlds)));
    }
    if let Some(path) = &outputs.json {
        write_json(path, &standings)?;
    }
    if let Some(out) = &args.out {
        notice(format_args!("the runs are in {}", out.display()));
    }
    let told: Vec<String> = standings.iter().map(told).collect();
    outputs.print(&format!("{}\n\n{}", lines(&runs, &filters, &worlds), told.join("\n")))
}

/// A number that says whether two runs have the same settings (FNV-1a).
fn fingerprint(settings: &str) -> String {
    let hash = settings
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

/// The file of runs that are done, one row each, written as they end.
struct Journal {
    known: Vec<WorldRun>,
    rows: Mutex<csv::Writer<File>>,
    name: String,
}

impl Journal {
    /// Reads what is there, and goes on behind it.
    fn open(path: &Path) -> Result<Self, Failure> {
        check_file("--out", path)?;
        let bad = |error: &dyn std::fmt::Display| Failure::input(format_args!("--out {}: {error}", path.display()));
        let known: Vec<WorldRun> = match File::open(path) {
            Ok(file) => csv::Reader::from_reader(file)
                .deserialize()
                .collect::<Result<_, _>>()
                .map_err(|error| bad(&format_args!("not the runs of such a study: {error}")))?,
            Err(_) => Vec::new(),
        };
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(|error| bad(&error))?;
        let rows = csv::WriterBuilder::new().has_headers(known.is_empty()).from_writer(file);
        Ok(Self { known, rows: Mutex::new(rows), name: path.display().to_string() })
    }

    fn find(&self, world: &str, filter: &str, settings: &str) -> Option<WorldRun> {
        let same = |run: &&WorldRun| run.world == world && run.filter == filter && run.settings == settings;
        self.known.iter().find(same).cloned()
    }

    fn add(&self, run: &WorldRun) -> Result<(), Failure> {
        // A thread that panicked while it wrote has ended the program's work anyway.
        let mut rows = self.rows.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let written = rows.serialize(run).map_err(|error| error.to_string());
        written
            .and_then(|()| rows.flush().map_err(|error| error.to_string()))
            .map_err(|error| Failure::Internal(format!("cannot write {}: {error}", self.name)))
    }
}
