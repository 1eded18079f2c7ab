//! Filter and reference in lockstep, as a command.

use super::args::CompareArgs;
use super::failure::{Failure, notice};
use super::offer::Offer;
use super::outputs::{Outputs, make};
use super::progress::Progress;
use super::source::{Source, tuned};
use scphd_sim::compare::{self, Comparison};
use scphd_sim::output::comparison::{self, Compared};
use scphd_sim::output::json::Format;
use scphd_sim::session::{Filter, with_roomy_stack};
use scphd_sim::settings::Origins;
use scphd_sim::slam::Precision;

/// Particles and samples unless told otherwise: the reference takes every step again, at its own pace.
const PARTICLES: usize = 32;
const SAMPLES: usize = 2;

/// Compares in every precision asked for, prints the differences and writes them where asked to.
pub fn compare<K: Offer>(source: &Source<K>, args: CompareArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let log = source.log(seed)?;
    let mut defaults = K::of_reference(&log);
    let recursion = K::recursion_mut(&mut defaults);
    (recursion.particles, recursion.samples) = (PARTICLES, SAMPLES);
    let settings = tuned::<K>(defaults, &mut Origins::default(), &log, &args.tuning)?;
    let recursion = K::recursion(&settings);
    let outputs = Outputs { json: args.json, out: args.out };
    outputs.check()?;

    let mut overall = Vec::new();
    let mut scans = Vec::new();
    for &precision in args.precision.each() {
        let comparison = lockstep::<K>(&log, &settings, precision, seed)?;
        overall.push(Compared {
            format: Format,
            log: K::name(&log).to_owned(),
            precision: name(precision).into(),
            particles: recursion.particles,
            samples: recursion.samples,
            seed,
            differences: comparison.overall,
            settings: serde_json::to_value(&settings).unwrap_or_default(),
        });
        scans.push((precision, comparison.scans));
    }
    if let Some(out) = &outputs.out {
        make(out)?;
        for (precision, scans) in &scans {
            let rows = K::scans(&log).iter().map(|scan| scan.t_s).zip(scans.iter().copied());
            comparison::write_csv(&out.join(format!("compare-{}.csv", name(*precision))), rows)?;
        }
        notice(format_args!("tables are in {}", out.display()));
    }
    if let Some(path) = &outputs.json {
        comparison::write_json(path, &overall)?;
    }
    outputs.print(&comparison::render(&overall))
}

fn lockstep<K: Offer>(
    log: &K::Log,
    settings: &K::Settings,
    precision: Precision,
    seed: u64,
) -> Result<Comparison, Failure> {
    let progress = Progress::new(format!("compare {}", name(precision)), K::scans(log).len());
    with_roomy_stack(|| compare::compare::<K>(log, settings, precision, seed, |scans| progress.at(scans)))
        .map_err(|error| Failure::Internal(format!("cannot start a thread: {error}")))?
        .map_err(|refusal| Failure::input(format_args!("the filter refuses: {refusal}")))
}

fn name(precision: Precision) -> &'static str {
    Filter::Core(precision).precision()
}
