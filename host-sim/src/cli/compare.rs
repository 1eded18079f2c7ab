//! The command that compares filter and reference in lockstep.

use super::args::{CompareArgs, ComparedFilter};
use super::failure::{Failure, notice};
use super::offer::Offer;
use super::outputs::{Outputs, make};
use super::progress::Progress;
use super::source::{Source, tuned};
use scphd_filters::kind::Kind;
use scphd_filters::settings::Origins;
use scphd_filters::slam::{Precision, Refusal};
use scphd_run::compare::{self, Comparison};
use scphd_run::session::{Filter, with_roomy_stack};
use scphd_score::results::json::Format;
use scphd_view::output::comparison::{self, Compared, Fields};

/// Default numbers of particles and samples: the reference, which repeats every step, is slow.
const PARTICLES: usize = 32;
const SAMPLES: usize = 2;

/// Compares all requested precisions, prints the differences and writes them to the requested files.
pub fn compare<K: Offer>(source: &Source<K>, args: CompareArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let log = source.log(seed)?;
    let filter = args.filter;
    let settings = match filter {
        ComparedFilter::Core => {
            let mut defaults = K::of_reference(&log);
            let recursion = K::recursion_mut(&mut defaults);
            (recursion.particles, recursion.samples) = (PARTICLES, SAMPLES);
            tuned::<K>(defaults, &mut Origins::default(), &log, &args.tuning, &[filter.choice()])?
        }
        // The reference has one hypothesis.
        ComparedFilter::Joint => source.tuned_alike(&log, &args.tuning, &[filter.choice()])?,
    };
    let outputs = Outputs { json: args.json, out: args.out };
    outputs.check()?;
    let work = Work::<K> { log: log.into_owned(), settings, seed, each: args.precision.each(), outputs };
    match filter {
        ComparedFilter::Core => work.done(Filter::Core, |work, precision, progress| {
            compare::compare::<K>(&work.log, &work.settings, precision, seed, |scans| progress.at(scans))
        }),
        ComparedFilter::Joint => work.done(Filter::Joint, |work, precision, progress| {
            compare::compare_joint::<K>(&work.log, &work.settings, precision, |scans| progress.at(scans))
        }),
    }
}

/// The inputs of a comparison, and the files for the differences.
struct Work<K: Kind> {
    log: K::Log,
    settings: K::Settings,
    seed: u64,
    each: &'static [Precision],
    outputs: Outputs,
}

impl<K: Kind> Work<K> {
    fn done<D: Fields + Copy + Send>(
        &self,
        filter: fn(Precision) -> Filter,
        lockstep: impl Fn(&Self, Precision, &Progress) -> Result<Comparison<D>, Refusal> + Sync,
    ) -> Result<(), Failure> {
        let Self { log, settings, seed, each, outputs } = self;
        let recursion = K::recursion(settings);
        let mut overall = Vec::new();
        let mut scans = Vec::new();
        for &precision in *each {
            let filter = filter(precision);
            let name = filter.precision();
            let progress = Progress::new(format!("compare {name}"), K::scans(log).len());
            let comparison = with_roomy_stack(|| lockstep(self, precision, &progress))
                .map_err(|error| Failure::Internal(format!("cannot start a thread: {error}")))?
                .map_err(|refusal| Failure::input(format_args!("the filter refuses: {refusal}")))?;
            let is_joint = matches!(filter, Filter::Joint(_));
            let (particles, samples) = if is_joint { (1, 1) } else { (recursion.particles, recursion.samples) };
            overall.push(Compared {
                format: Format,
                log: K::name(log).to_owned(),
                precision: name.into(),
                particles,
                samples,
                seed: *seed,
                differences: comparison.overall,
                settings: serde_json::to_value(settings).unwrap_or_default(),
            });
            scans.push((name, comparison.scans));
        }
        if let Some(out) = &outputs.out {
            make(out)?;
            for (name, scans) in &scans {
                let rows = K::scans(log).iter().map(|scan| scan.t_s).zip(scans.iter().copied());
                comparison::write_csv(&out.join(format!("compare-{name}.csv")), rows)?;
            }
            notice(format_args!("tables are in {}", out.display()));
        }
        if let Some(path) = &outputs.json {
            comparison::write_json(path, &overall)?;
        }
        outputs.print(&comparison::render(&overall))
    }
}
