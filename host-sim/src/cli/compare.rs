//! The command that compares filter and reference in lockstep.

use super::args::{CompareArgs, ComparedFilter};
use super::failure::Failure;
use super::offer::Offer;
use super::outputs::print_beside;
use super::progress::Progress;
use super::source::{Source, tuned};
use scphd_filters::kind::Kind;
use scphd_filters::settings::Origins;
use scphd_filters::slam::{Precision, Refusal};
use scphd_run::compare::{self, Comparison, Figures};
use scphd_run::session::{Filter, with_roomy_stack};
use scphd_view::output::comparison::render;

/// Default numbers of particles and samples: the reference, which repeats every step, is slow.
const PARTICLES: usize = 32;
const SAMPLES: usize = 2;

/// Compares all requested precisions, and prints the differences.
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
    let work = Work::<K> { log: log.into_owned(), settings, seed, each: args.precision.each() };
    match filter {
        ComparedFilter::Core => work.done(Filter::Core, |work, precision, progress| {
            compare::compare::<K>(&work.log, &work.settings, precision, seed, |scans| progress.at(scans))
        }),
        ComparedFilter::Joint => work.done(Filter::Joint, |work, precision, progress| {
            compare::compare_joint::<K>(&work.log, &work.settings, precision, |scans| progress.at(scans))
        }),
    }
}

/// The inputs of a comparison.
struct Work<K: Kind> {
    log: K::Log,
    settings: K::Settings,
    seed: u64,
    each: &'static [Precision],
}

impl<K: Kind> Work<K> {
    fn done<D: Figures + Send>(
        &self,
        filter: fn(Precision) -> Filter,
        lockstep: impl Fn(&Self, Precision, &Progress) -> Result<Comparison<D>, Refusal> + Sync,
    ) -> Result<(), Failure> {
        let Self { log, settings, seed, each } = self;
        let recursion = K::recursion(settings);
        let mut parameters = Vec::new();
        let mut compared = Vec::new();
        for &precision in *each {
            let filter = filter(precision);
            let name = filter.precision();
            let progress = Progress::new(format!("compare {name}"), K::scans(log).len());
            let comparison = with_roomy_stack(|| lockstep(self, precision, &progress))
                .map_err(|error| Failure::Internal(format!("cannot start a thread: {error}")))?
                .map_err(|refusal| Failure::input(format_args!("the filter refuses: {refusal}")))?;
            if matches!(filter, Filter::Core(_)) {
                let size = format!("{} × {}", recursion.particles, recursion.samples);
                parameters = vec![("particles × samples", size), ("seed", seed.to_string())];
            }
            compared.push((name, comparison.overall));
        }
        print_beside(None, &render(K::name(log), &parameters, &compared))
    }
}
