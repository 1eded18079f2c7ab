//! `scphd-sim tune`.

use super::args::TuneArgs;
use super::failure::{Failure, notice};
use super::outputs::{check_file, print_beside, write_file};
use super::progress::Progress;
use super::source::{Found, tuned};
use scphd_sim::output::tuning;
use scphd_sim::tune;

/// Proposes settings, prints what has changed, and writes all of them where asked to.
pub fn tune(args: TuneArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let source = Found::find(&args.source, args.scenario_seed.scenario_seed)?.planar("tune")?;
    let log = source.log(seed)?;
    let settings = tuned(source.defaults(&log), &args.tuning)?;
    if let Some(path) = &args.out {
        check_file("--out", path)?;
    }
    let rounds = usize::from(args.rounds);
    let progress = Progress::new(format!("tune {}", log.name), rounds * log.scans.len());
    let found = tune::tune(&log, &settings, seed, rounds, &mut |scans| progress.at(scans))?;
    drop(progress);
    if let Some(path) = &args.out {
        let text = found.settings.to_toml().map_err(|error| Failure::Internal(error.to_string()))?;
        write_file("--out", path, text.as_bytes())?;
        notice(format_args!("settings are in {}", path.display()));
    }
    print_beside(args.out.as_deref(), &tuning::render(&log.name, &found.proposed))
}
