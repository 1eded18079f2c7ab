//! Sources of runs: logs and their settings.
//!
//! A name that may be a scenario or a folder is resolved in the same order by all commands: a built-in scenario takes precedence,
//! so that a command does not depend on the working directory; `./NAME` is always a folder. `run` and `export` accept scenarios
//! only, `replay` folders only.

use super::args::{Choice, Switch, Tuning};
use super::check;
use super::failure::{Failure, warning};
use super::offer::Offer;
use scphd_filters::kind::Kind;
use scphd_filters::settings::{Origin, Origins, OutOfRange, changed, users_of};
use scphd_filters::slam::Filter;
use scphd_log::dimensions::{Planar, Underwater};
use scphd_log::log_folder;
use std::borrow::Cow;
use std::path::Path;

/// The source of the log for a run with a seed.
pub enum Source<K: Kind = Planar> {
    /// One log for all seeds.
    Fixed(Box<K::Log>),
    /// A scenario that is made again for every seed, by name.
    Seeded(String),
    /// A scenario with one seed for all runs.
    Frozen(String, Box<K::Log>),
}

impl<K: Offer> Source<K> {
    /// A scenario, with this seed or with that of the run.
    pub fn scenario(name: String, seed: Option<u64>) -> Result<Self, Failure> {
        Ok(match seed {
            Some(seed) => {
                let log = scenario::<K>(&name, seed)?;
                Self::Frozen(name, Box::new(log))
            }
            None => Self::Seeded(name),
        })
    }

    pub fn folder(dir: &Path) -> Result<Self, Failure> {
        let mut log = K::read(dir).map_err(|errors| Failure::of_log(dir, &errors))?;
        let done = K::mend(&mut log);
        done.iter().for_each(|what| warning(format_args!("warning: {}: {what}", K::name(&log))));
        Ok(Self::Fixed(Box::new(log)))
    }

    /// Prints the warnings of a quick check of a folder; scenarios need no check.
    pub fn warn(&self) {
        if let Self::Fixed(log) = self {
            check::warn::<K>(log);
        }
    }

    /// The name of the scenario, if it is one.
    fn name(&self) -> Option<&str> {
        match self {
            Self::Fixed(_) => None,
            Self::Seeded(name) | Self::Frozen(name, _) => Some(name),
        }
    }

    /// Origins of the default settings for a log of this source.
    pub fn origins(&self, log: &K::Log) -> Origins {
        K::origins(self.name(), log)
    }

    /// The default settings for these filters: those for a joint map, unless a mixture or the reference has the same settings.
    pub fn defaults(&self, log: &K::Log, filters: &[Choice]) -> K::Settings {
        let mut defaults = K::defaults(self.name(), log);
        let is_joint = |choice: &Choice| matches!(choice.filter, Filter::Joint(_));
        let is_baseline = |choice: &Choice| matches!(choice.filter, Filter::Ekf(_));
        if filters.iter().any(is_joint) && filters.iter().all(|choice| is_joint(choice) || is_baseline(choice)) {
            K::set_for_joint_map(&mut defaults, log);
        }
        defaults
    }

    /// The settings for these filters: the defaults, overridden by the settings file, then by the command line.
    pub fn tuned(&self, log: &K::Log, tuning: &Tuning, filters: &[Choice]) -> Result<K::Settings, Failure> {
        self.tuned_from(&mut Origins::default(), log, tuning, filters)
    }

    /// [`tuned`](Self::tuned), with defaults that all filters have, not those for a joint map.
    pub fn tuned_alike(&self, log: &K::Log, tuning: &Tuning, filters: &[Choice]) -> Result<K::Settings, Failure> {
        tuned::<K>(K::defaults(self.name(), log), &mut Origins::default(), log, tuning, filters)
    }

    /// [`tuned`](Self::tuned), with the origin of each setting; `origins` has those of the defaults.
    pub fn tuned_from(
        &self,
        origins: &mut Origins,
        log: &K::Log,
        tuning: &Tuning,
        filters: &[Choice],
    ) -> Result<K::Settings, Failure> {
        tuned::<K>(self.defaults(log, filters), origins, log, tuning, filters)
    }

    /// Whether the joint map is the default filter here.
    pub fn is_joint_usual(&self) -> bool {
        K::is_joint_usual(self.name())
    }

    /// Number of runs with each input, if the thesis states it.
    pub fn runs_per_input(&self) -> Option<usize> {
        self.name().and_then(K::runs_per_input)
    }

    /// Whether the log differs for every seed.
    pub fn is_seeded(&self) -> bool {
        matches!(self, Self::Seeded(_))
    }

    pub fn log(&self, seed: u64) -> Result<Cow<'_, K::Log>, Failure> {
        match self {
            Self::Fixed(log) | Self::Frozen(_, log) => Ok(Cow::Borrowed(log)),
            Self::Seeded(name) => scenario::<K>(name, seed).map(Cow::Owned),
        }
    }
}

/// A value for one kind of vehicle or the other.
pub enum OfKind<P, U> {
    Planar(P),
    Underwater(U),
}

/// The same expression for either kind.
macro_rules! either {
    ($found:expr, $one:ident => $done:expr) => {
        match $found {
            $crate::cli::source::OfKind::Planar($one) => $done,
            $crate::cli::source::OfKind::Underwater($one) => $done,
        }
    };
}
pub(super) use either;

pub type Found = OfKind<Source<Planar>, Source<Underwater>>;

fn is_of<K: Offer>(name: &str) -> bool {
    K::SCENARIOS.iter().any(|(known, _)| *known == name)
}

impl Found {
    /// The scenario with this name, with `scenario_seed` or the seed of the run; otherwise the log in this folder.
    pub fn find(argument: &Path, scenario_seed: Option<u64>) -> Result<Self, Failure> {
        match argument.to_str() {
            Some(name) if is_of::<Planar>(name) || is_of::<Underwater>(name) => Self::scenario(name, scenario_seed),
            _ if argument.is_dir() => Self::folder(argument),
            _ => {
                let name = argument.display();
                Err(Failure::input(format_args!("no scenario and no folder '{name}'; scenarios are {}", scenarios())))
            }
        }
    }

    /// The scenario with this name, with `seed` or that of the run.
    pub fn scenario(name: &str, seed: Option<u64>) -> Result<Self, Failure> {
        if is_of::<Underwater>(name) {
            return Source::scenario(name.to_owned(), seed).map(Self::Underwater);
        }
        if is_of::<Planar>(name) {
            return Source::scenario(name.to_owned(), seed).map(Self::Planar);
        }
        Err(no_scenario(name))
    }

    /// The log in this folder.
    pub fn folder(dir: &Path) -> Result<Self, Failure> {
        if log_folder::has_camera(dir) {
            Source::folder(dir).map(Self::Underwater)
        } else {
            Source::folder(dir).map(Self::Planar)
        }
    }

    /// Sets the standard deviation of the truth of a log.
    pub fn take_truth_for(&mut self, sigma_m: f64) -> Result<(), Failure> {
        match self {
            Self::Planar(Source::Fixed(log)) => {
                log.truth_sigma_m = sigma_m;
                Ok(())
            }
            _ => Err(Failure::input("--truth-sigma: the truth of a log in space is taken as it is")),
        }
    }

    /// Prints the warnings of a quick check of a folder.
    pub fn warn(&self) {
        either!(self, source => source.warn());
    }

    /// Whether the log differs for every seed.
    pub fn is_seeded(&self) -> bool {
        either!(self, source => source.is_seeded())
    }
}

/// Several sources of one kind.
pub type Sources = OfKind<Vec<Source<Planar>>, Vec<Source<Underwater>>>;

impl Sources {
    /// Sources that are all in the plane or all in space.
    pub fn of(found: Vec<Found>) -> Result<Self, Failure> {
        let (mut planar, mut space) = (Vec::new(), Vec::new());
        for one in found {
            match one {
                OfKind::Planar(source) => planar.push(source),
                OfKind::Underwater(source) => space.push(source),
            }
        }
        match (planar.is_empty(), space.is_empty()) {
            (_, true) => Ok(Self::Planar(planar)),
            (true, false) => Ok(Self::Underwater(space)),
            (false, false) => {
                Err(Failure::input("logs in the plane and of a stereo camera in space cannot be run together"))
            }
        }
    }
}

/// All scenarios, each with a description.
pub fn all_scenarios() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    Planar::SCENARIOS.iter().chain(Underwater::SCENARIOS)
}

fn scenarios() -> String {
    all_scenarios().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn no_scenario(name: &str) -> Failure {
    Failure::input(format_args!("no scenario '{name}', there are {}", scenarios()))
}

/// The log of a scenario with this seed.
pub fn scenario<K: Offer>(name: &str, seed: u64) -> Result<K::Log, Failure> {
    K::scenario(name, seed).ok_or_else(|| no_scenario(name))
}

/// The command that prints the settings of a run.
pub fn settings_command(source: &str, tuning: &Tuning) -> String {
    let Tuning { particles, samples, moving, hypotheses, settings } = tuning;
    let words = [
        particles.map(|particles| format!("--particles {particles}")),
        samples.map(|samples| format!("--samples {samples}")),
        moving.map(|moving| format!("--moving {}", if moving == Switch::On { "on" } else { "off" })),
        hypotheses.map(|hypotheses| format!("--hypotheses {hypotheses}")),
        settings.as_ref().map(|path| format!("--settings {}", path.display())),
    ];
    let words: String = words.into_iter().flatten().map(|word| format!(" {word}")).collect();
    format!("settings: those that `scphd-sim settings {source}{words}` prints")
}

/// `defaults`, overridden by the settings file, then by the command line, with the origin of each setting; `origins` has those of
/// the defaults. A setting or option that none of `filters` uses is refused; without filters, all are accepted.
pub fn tuned<K: Offer>(
    defaults: K::Settings,
    origins: &mut Origins,
    log: &K::Log,
    tuning: &Tuning,
    filters: &[Choice],
) -> Result<K::Settings, Failure> {
    tuning.options().into_iter().try_for_each(|option| used(filters, option, ""))?;
    let mut settings = match &tuning.settings {
        Some(path) => {
            let settings = origins.with_file(path, |text| K::with_toml(&defaults, text))?;
            let asked_for = changed(&defaults, &settings);
            let file = format!("{}: ", path.display());
            asked_for.iter().try_for_each(|field| used(filters, field, &file))?;
            settings
        }
        None => defaults,
    };
    let given = [
        (tuning.particles.is_some(), "filter.particles", "--particles"),
        (tuning.samples.is_some(), "filter.samples", "--samples"),
        (tuning.moving.is_some(), "moving.birth_intensity", "--moving"),
        (tuning.hypotheses.is_some(), "joint.hypotheses", "--hypotheses"),
    ];
    for (_, field, option) in given.into_iter().filter(|(given, ..)| *given) {
        origins.set(field, Origin::CommandLine(option));
    }
    let recursion = K::recursion_mut(&mut settings);
    recursion.particles = tuning.particles.unwrap_or(recursion.particles);
    recursion.samples = tuning.samples.unwrap_or(recursion.samples);
    if let Some(moving) = tuning.moving {
        K::set_moving(&mut settings, moving == Switch::On)
            .map_err(|why| Failure::input(format_args!("--moving on: {why}")))?;
    }
    if let Some(hypotheses) = tuning.hypotheses {
        K::set_hypotheses(&mut settings, hypotheses)
            .map_err(|why| Failure::input(format_args!("--hypotheses {hypotheses}: {why}")))?;
    }
    K::check(log, &settings).map_err(|error| out_of_range(&error, tuning))?;
    Ok(settings)
}

/// Checks that any of these filters uses a setting or an option; `place` is the file or option that it is from.
pub fn used(filters: &[Choice], what: &str, place: &str) -> Result<(), Failure> {
    if filters.is_empty() || filters.iter().any(|choice| choice.uses(what)) {
        return Ok(());
    }
    let names: Vec<&str> = filters.iter().map(Choice::name).collect();
    let (names, users) = (names.join(", "), users_of(what));
    Err(Failure::input(format_args!("{place}{what}: not used by --filter {names}, but by {users}; leave it out")))
}

/// The error for a setting out of range, with the argument that set it, if one was given.
fn out_of_range(error: &OutOfRange, tuning: &Tuning) -> Failure {
    let OutOfRange { field, found, range } = error;
    match &**field {
        "filter.particles" if tuning.particles.is_some() => {
            Failure::input(format_args!("--particles {found}: must be {range}"))
        }
        "joint.hypotheses" if tuning.hypotheses.is_some() => {
            Failure::input(format_args!("--hypotheses {found}: must be {range}"))
        }
        "filter.samples" if tuning.samples.is_some() => {
            Failure::input(format_args!("--samples {found}: must be {range}"))
        }
        _ => Failure::input(format_args!("settings: {error}")),
    }
}
