//! Many runs of one filter: several logs, several seeds.

use super::args::RunArgs;
use super::failure::{Failure, warn_of_errors};
use super::offer::Offer;
use super::outputs::Outputs;
use super::progress::Progress;
use super::source::{Source, used};
use scphd_log::dimensions::Coordinates;
use scphd_run::session;
use scphd_score::results::json::{self, Summary};
use scphd_view::output::repeats;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Runs every log with every seed, and prints a row for each log.
pub fn repeat<K: Offer>(sources: &[Source<K>], args: RunArgs) -> Result<(), Failure> {
    let choice = args.filter(sources.iter().all(Source::is_joint_usual)).map_err(Failure::input)?;
    let threads = args.threads()?;
    args.options().into_iter().try_for_each(|option| used(&[choice], option, ""))?;
    let files = [
        (args.out.is_some(), "--out"),
        (args.html.is_some(), "--html"),
        (args.mcap.is_some(), "--mcap"),
        (args.map.is_some() || args.save_map.is_some(), "--map and --save-map"),
    ];
    if let Some((_, option)) = files.into_iter().find(|(given, _)| *given) {
        let why = "for a single run only, not with several logs or --repeat";
        return Err(Failure::input(format_args!("{option}: {why}")));
    }
    let seeds = args.seeds()?;
    let outputs = Outputs { json: args.json, out: None };
    outputs.check()?;
    // Invalid settings for a log are reported before any run.
    let mut scans = 0;
    let mut name = String::new();
    for source in sources {
        let log = source.log(args.seed.seed)?;
        let settings = choice.settings::<K>(source.tuned(&log, &args.tuning, &[choice])?);
        name = format!("{} {}", choice.filter.name(K::recursion(&settings).likelihood), choice.filter.precision());
        scans += K::scans(&log).len() * args.repeat as usize;
    }

    let progress = Progress::new(name, scans);
    let done = AtomicUsize::new(0);
    let runs: Vec<(&Source<K>, u64)> =
        sources.iter().flat_map(|source| seeds.clone().map(move |seed| (source, seed))).collect();
    let summaries = in_parallel(&runs, args.jobs.into(), |&(source, seed)| {
        let log = source.log(seed)?;
        let settings = choice.settings::<K>(source.tuned(&log, &args.tuning, &[choice])?);
        let mut advance = |_| progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(session::run_on::<K>(&threads, &log, &settings, choice.filter, seed, &mut advance)?.summary)
    })?;
    drop(progress);

    if let Some(path) = &outputs.json {
        json::write_summaries(path, &summaries)?;
    }
    let logs: Vec<&[Summary]> = summaries.chunks(args.repeat as usize).collect();
    // The runs of a log differ only by the filter's random numbers: their errors are not independent.
    let seeded = logs.iter().zip(sources).filter(|(_, source)| source.is_seeded());
    let together = seeded.filter_map(|(runs, _)| repeats::consistency(runs, K::Position::COUNT));
    let text: Vec<String> = std::iter::once(repeats::render(&logs)).chain(together).collect();
    outputs.print(&text.join("\n"))?;
    logs.iter().for_each(|runs| warn_of_errors(runs));
    Ok(())
}

/// The results of `work` for all items, in order, by `jobs` threads; of several failures that of the first item.
pub(super) fn in_parallel<I: Sync, T: Send>(
    items: &[I],
    jobs: usize,
    work: impl Fn(&I) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let next = AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let (sender, receiver) = mpsc::channel();
    // Items are started in order and always finished, so that every item before a failed one has its result.
    let worker = || {
        let sender = sender.clone();
        while !failed.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { break };
            let result = work(item);
            failed.fetch_or(result.is_err(), Ordering::Relaxed);
            // The receiver outlives the threads.
            let _ = sender.send((index, result));
        }
    };
    thread::scope(|scope| -> Result<(), Failure> {
        for _ in 1..jobs.min(items.len()) {
            thread::Builder::new()
                .spawn_scoped(scope, worker)
                .map_err(|error| Failure::Internal(format!("cannot start a thread: {error}")))?;
        }
        worker();
        Ok(())
    })?;
    drop(sender);
    let mut results: Vec<_> = receiver.into_iter().collect();
    results.sort_by_key(|&(index, _)| index);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_for_any_number_of_threads() {
        let items: Vec<usize> = (0..50).collect();
        for jobs in [1, 2, 7, 100] {
            assert_eq!(in_parallel(&items, jobs, |&item| Ok(2 * item)).unwrap()[49], 98);
            let failure = in_parallel(&items, jobs, |&item| match item {
                20.. => Err(Failure::input(item)),
                _ => Ok(item),
            });
            assert!(matches!(failure, Err(Failure::Input(text)) if text == "20"));
        }
    }
}
