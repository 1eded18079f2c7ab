//! Filter and reference in lockstep, as a command.

use super::args::CompareArgs;
use super::failure::{Failure, notice};
use super::outputs::{Outputs, make};
use super::progress::Progress;
use super::source::{Source, tuned};
use scphd_sim::compare::{self, Comparison};
use scphd_sim::log::Log;
use scphd_sim::output::comparison::{self, Compared};
use scphd_sim::output::json::Format;
use scphd_sim::session::{Filter, with_roomy_stack};
use scphd_sim::settings::Settings;
use scphd_sim::slam::Precision;

/// Particles and samples unless told otherwise: the reference takes every step again, at its own pace.
pub const PARTICLES: usize = 32;
pub const SAMPLES: usize = 2;

/// Compares in every precision asked for, prints the differences and writes them where asked to.
pub fn compare(source: &Source, args: CompareArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let log = source.log(seed)?;
    let mut defaults = Settings::for_log(&log);
    defaults.filter.particles = PARTICLES;
    defaults.filter.samples = SAMPLES;
    defaults.restrict_to_reference();
    let settings = tuned(defaults, &args.tuning)?;
    let outputs = Outputs { json: args.json, out: args.out };
    outputs.check()?;

    let mut overall = Vec::new();
    let mut scans = Vec::new();
    for &precision in args.precision.each() {
        let comparison = lockstep(&log, &settings, precision, seed)?;
        overall.push(Compared {
            format: Format,
            log: log.name.clone(),
            precision: name(precision).into(),
            particles: settings.filter.particles,
            samples: settings.filter.samples,
            seed,
            differences: comparison.overall,
            settings: serde_json::to_value(&settings).unwrap_or_default(),
        });
        scans.push((precision, comparison.scans));
    }
    if let Some(out) = &outputs.out {
        make(out)?;
        for (precision, scans) in &scans {
            let rows = log.scans.iter().map(|scan| scan.t_s).zip(scans.iter().copied());
            comparison::write_csv(&out.join(format!("compare-{}.csv", name(*precision))), rows)?;
        }
        notice(format_args!("tables are in {}", out.display()));
    }
    if let Some(path) = &outputs.json {
        comparison::write_json(path, &overall)?;
    }
    outputs.print(&comparison::render(&overall))
}

fn lockstep(log: &Log, settings: &Settings, precision: Precision, seed: u64) -> Result<Comparison, Failure> {
    let progress = Progress::new(format!("compare {}", name(precision)), log.scans.len());
    with_roomy_stack(|| compare::compare(log, settings, precision, seed, |scans| progress.at(scans)))
        .map_err(|error| Failure::Internal(format!("cannot start a thread: {error}")))?
        .map_err(|refusal| Failure::input(format_args!("the filter refuses: {refusal}")))
}

pub fn name(precision: Precision) -> &'static str {
    Filter::Core(precision).precision()
}
