//! Studies over random worlds, which can be interrupted and continued.

use super::args::MonteCarloArgs;
use super::contender::Contender;
use super::device::{self, Input, On};
use super::failure::{Failure, notice};
use super::monte_carlo::distinct;
use super::offer::Offer;
use super::outputs::{Outputs, check_file};
use super::progress::Progress;
use super::repeat::in_parallel;
use super::source::{OfKind, Source};
use scphd_filters::kind::Kind;
use scphd_filters::slam::Slam;
use scphd_log::dimensions::{Coordinates, Dimensions, Planar, Underwater};
use scphd_run::monte_carlo::variants::best_of;
use scphd_run::monte_carlo::worlds::{Standing, WorldRun, lines, standing, told, write_json};
use scphd_run::session;
use scphd_score::results::json::Summary;
use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Default number of worlds of a study.
const DEFAULT_RUNS: u32 = 100;

/// The kind of random worlds, in the plane or in space, if `monte-carlo` is requested for them.
pub fn asked_for(args: &MonteCarloArgs) -> Option<OfKind<&'static str, &'static str>> {
    let [source] = &args.sources[..] else { return None };
    let of = |worlds: &'static [&'static str]| worlds.iter().copied().find(|name| source.as_os_str() == *name);
    of(Planar::WORLDS).map(OfKind::Planar).or_else(|| of(Underwater::WORLDS).map(OfKind::Underwater))
}

/// Runs every filter in every world, and prints a line for each world and the filters' standings. Runs in the file of `--out` are
/// not repeated.
pub fn study<K: Offer>(name: &str, args: MonteCarloArgs) -> Result<(), Failure> {
    if args.input_sets.is_some() {
        return Err(Failure::input("--input-sets: not with worlds"));
    }
    let outputs = Outputs { json: args.json.clone(), out: None };
    outputs.check()?;
    let source = Source::<K>::scenario(name.to_owned(), None)?;
    let contenders = Contender::all(&args, source.is_joint_usual())?;
    let runs = args.runs.unwrap_or(DEFAULT_RUNS);
    let end = args.seed.checked_add(u64::from(runs));
    let end = end.ok_or_else(|| Failure::input(format_args!("--seed {}: too large for --runs {runs}", args.seed)))?;
    let seeds: Vec<u64> = (args.seed..end).collect();
    // Invalid settings are reported before any run.
    let first = &*source.log(args.seed)?;
    let choices: Vec<_> = contenders.iter().map(Contender::choice).collect();
    let first = source.tuned(first, &args.tuning, &choices)?;
    let name = |contender: &Contender| Ok(contender.name::<K>(&contender.settings::<K>(first.clone())?));
    let names = distinct(contenders.iter().map(name).collect::<Result<Vec<_>, Failure>>()?)?;
    let journal = args.out.as_deref().map(Journal::open).transpose()?;

    let jobs: Vec<(u64, usize)> =
        seeds.iter().flat_map(|&seed| (0..contenders.len()).map(move |place| (seed, place))).collect();
    let threads = args.jobs.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    let progress = Progress::new(format!("{} runs", jobs.len()), jobs.len());
    let done = AtomicUsize::new(0);
    let input = |&(seed, place): &(u64, usize)| -> Result<Input<'_, K>, Failure> {
        let log = source.log(seed)?;
        let settings = contenders[place].settings::<K>(source.tuned(&log, &args.tuning, &choices)?)?;
        Ok((log, settings, seed))
    };
    let advance = || progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
    let finish = |place: usize, settings: &K::Settings, summary: &Summary| {
        let run = WorldRun::of(summary, &fingerprint::<K>(settings)?)
            .ok_or_else(|| Failure::Internal(format!("{}: a world without truth", summary.log)))?;
        let run = WorldRun { filter: names[place].clone(), ..run };
        journal.as_ref().map_or(Ok(()), |journal| journal.add(&run))?;
        advance();
        Ok(run)
    };
    // On a device all runs of a filter follow these, which are in the file already, or are done here.
    let runs = in_parallel(&jobs, threads, |job| {
        if args.device.is_some() && journal.is_none() {
            return Ok(None);
        }
        let (log, settings, seed) = input(job)?;
        let name = &names[job.1];
        if let Some(journal) = &journal
            && let Some(run) = journal.find(K::name(&log), name, &fingerprint::<K>(&settings)?)
        {
            advance();
            return Ok(Some(run));
        }
        if args.device.is_some() {
            return Ok(None);
        }
        let session = session::run::<K>(&log, &settings, contenders[job.1].filter(), seed, &mut |_| ())?;
        finish(job.1, &settings, &session.summary).map(Some)
    })?;
    let mut of_device: Vec<VecDeque<WorldRun>> = Vec::new();
    for (place, contender) in contenders.iter().enumerate() {
        let missing = jobs.iter().zip(&runs).filter(|(job, run)| job.1 == place && run.is_none());
        let missing: Vec<_> = missing.map(|(job, _)| job).collect();
        of_device.push(match args.device {
            Some(device) if !missing.is_empty() => {
                let finish = |_, slam: &mut dyn Slam<K>, input: &Input<'_, K>| {
                    finish(place, &input.1, &device::session(slam, contender.filter(), input)?.summary)
                };
                let on = On { filter: contender.filter(), threads, predicted: false };
                K::run_on(device, on, missing.len(), |run| input(missing[run]), finish)?.into()
            }
            _ => VecDeque::new(),
        });
    }
    let runs = jobs.iter().zip(runs).filter_map(|(job, run)| run.or_else(|| of_device[job.1].pop_front()));
    let runs: Vec<WorldRun> = runs.collect();
    drop(progress);

    let worlds: Vec<&str> = runs.iter().step_by(contenders.len()).map(|run| run.world.as_str()).collect();
    let dimension = <K as Dimensions>::Position::COUNT;
    let mut report = Report { dimension, runs: &runs, lines: Vec::new(), standings: Vec::new() };
    if contenders.iter().any(Contender::is_variant) {
        let mut rest = &contenders[..];
        while let Some(first) = rest.first() {
            let (team, others) =
                rest.split_at(rest.iter().take_while(|other| other.is_of_the_filter_of(first)).count());
            let place = contenders.len() - rest.len();
            report.variants(&names[place..place + team.len()], &worlds);
            rest = others;
        }
    } else {
        report.filters(&names, &worlds);
    }
    if let Some(path) = &outputs.json {
        write_json(path, &report.standings)?;
    }
    if let Some(out) = &args.out {
        notice(format_args!("the runs are in {}", out.display()));
    }
    let told: Vec<String> = report.standings.iter().map(|standing| told(dimension, standing)).collect();
    outputs.print(&format!("{}\n\n{}", report.lines.join("\n\n"), told.join("\n")))
}

struct Report<'r> {
    /// Dimension of a position.
    dimension: usize,
    runs: &'r [WorldRun],
    lines: Vec<String>,
    standings: Vec<Standing>,
}

impl Report<'_> {
    /// Compares the first filter with each other one.
    fn filters(&mut self, names: &[String], worlds: &[&str]) {
        self.lines.push(lines(self.dimension, self.runs, names, worlds));
        let Some(first) = names.first() else { return };
        let others = if names.len() > 1 { &names[1..] } else { names };
        self.standings.extend(others.iter().filter_map(|other| standing(self.runs, first, other, worlds)));
    }

    /// Compares every variant with the first, and the first with the best of the others in each world.
    fn variants(&mut self, names: &[String], worlds: &[&str]) {
        let Some((first, others)) = names.split_first() else { return };
        if others.is_empty() {
            return self.filters(names, worlds);
        }
        let best = format!("best of {}", others.len());
        let bests = best_of(self.runs, others, worlds, &best);
        let both: Vec<WorldRun> = self.runs.iter().filter(|run| run.filter == *first).cloned().chain(bests).collect();
        self.lines.push(lines(self.dimension, &both, &[first.clone(), best.clone()], worlds));
        self.standings.extend(others.iter().filter_map(|other| standing(self.runs, other, first, worlds)));
        self.standings.extend(standing(&both, first, &best, worlds));
    }
}

/// A fingerprint of the settings (FNV-1a), which tells whether two runs have the same ones.
fn fingerprint<K: Kind>(settings: &K::Settings) -> Result<String, Failure> {
    let hash = toml::to_string(settings)?
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    Ok(format!("{hash:016x}"))
}

/// The file of finished runs, with a row for each, written when it ends.
struct Journal {
    known: Vec<WorldRun>,
    rows: Mutex<csv::Writer<File>>,
    name: String,
}

impl Journal {
    /// Reads the existing rows, and appends new ones.
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
        // After a panic of a thread during writing, the program ends anyway.
        let mut rows = self.rows.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let written = rows.serialize(run).map_err(|error| error.to_string());
        written
            .and_then(|()| rows.flush().map_err(|error| error.to_string()))
            .map_err(|error| Failure::Internal(format!("cannot write {}: {error}", self.name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_compared_with_the_first_and_it_with_the_best_of_the_others() {
        let run = |world: &str, filter: &str, position_rmse_m| WorldRun {
            world: world.into(),
            filter: filter.into(),
            settings: "s".into(),
            position_rmse_m,
            dead_reckoning_rmse_m: 5.0,
            nees_median: None,
            scan_us_mean: None,
        };
        let names: Vec<String> = ["right", "x 2", "x 3"].map(str::to_owned).to_vec();
        let errors = [("a", [1.0, 2.0, 0.5]), ("b", [1.0, 4.0, 3.0]), ("c", [1.0, 0.2, 4.0])];
        let runs: Vec<WorldRun> = errors
            .iter()
            .flat_map(|(world, errors)| names.iter().zip(errors).map(|(name, error)| run(world, name, *error)))
            .collect();
        let mut report = Report { dimension: 2, runs: &runs, lines: Vec::new(), standings: Vec::new() };
        report.variants(&names, &["a", "b", "c"]);
        let found: Vec<(&str, &str, f64)> =
            report.standings.iter().map(|s| (&s.filter[..], &s.yardstick[..], s.ratio_median)).collect();
        // The ratios of the first to the best of the others are 2, a third and 5.
        assert_eq!(found, [("x 2", "right", 2.0), ("x 3", "right", 3.0), ("right", "best of 2", 2.0)]);
        assert_eq!(report.lines[0].lines().count(), 4, "{:?}", report.lines);
    }
}
