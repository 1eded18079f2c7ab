//! What a run starts from: a log and its settings.
//!
//! A name that may be a scenario or a folder is looked up in one order by all commands: a built-in scenario goes first, so that what
//! a command does depends on its words and not on what lies in the working directory; `./NAME` is always a folder. `run` and `export`
//! take scenarios alone, `replay` folders alone.

use super::args::{Switch, Tuning};
use super::failure::Failure;
use super::underwater;
use scphd_sim::log::Log;
use scphd_sim::log_folder;
use scphd_sim::scenario::{SCENARIOS, WORLDS, by_name, thesis_run};
use scphd_sim::settings::{Origin, Origins, OutOfRange, Settings};
use std::borrow::Cow;
use std::path::Path;

/// Where the log of a run with a certain seed comes from.
pub enum Source {
    /// One log for all seeds.
    Fixed(Box<Log>),
    /// A scenario that is made anew with every seed; this is its name.
    Seeded(String),
    /// A scenario of one seed for all.
    Frozen(String, Box<Log>),
}

impl Source {
    /// A scenario in the plane, with a seed of its own or with that of the run.
    pub fn scenario(name: String, seed: Option<u64>) -> Result<Self, Failure> {
        Ok(match seed {
            Some(seed) => {
                let log = scenario(&name, seed)?;
                Self::Frozen(name, Box::new(log))
            }
            None => Self::Seeded(name),
        })
    }

    /// The log of a folder.
    pub fn folder(dir: &Path) -> Result<Self, Failure> {
        let log = log_folder::read(dir).map_err(|error| Failure::of_log(dir, &error))?;
        Ok(Self::Fixed(Box::new(log)))
    }

    /// The settings a log of this source is run with unless told otherwise: those that suit the log, and what the
    /// thesis says about its scenario.
    pub fn defaults(&self, log: &Log) -> Settings {
        match self {
            Self::Fixed(_) => Settings::for_log(log),
            Self::Seeded(name) | Self::Frozen(name, _) => Settings::for_scenario(name, log),
        }
    }

    /// Where each of the [`defaults`](Self::defaults) is from.
    pub fn origins(&self, log: &Log) -> Origins {
        let mut origins = Origins::of_log(log);
        origins.set_changed(&Settings::for_log(log), &self.defaults(log), &Origin::Experiment);
        origins
    }

    /// Whether it is a log, or a random world, which is as good as one: an experiment of the thesis is neither.
    pub fn is_log(&self) -> bool {
        match self {
            Self::Fixed(_) => true,
            Self::Seeded(name) | Self::Frozen(name, _) => WORLDS.contains(&name.as_str()),
        }
    }

    /// Runs with each input, where the thesis says so.
    pub fn runs_per_input(&self) -> Option<usize> {
        match self {
            Self::Fixed(_) => None,
            Self::Seeded(name) | Self::Frozen(name, _) => thesis_run(name).map(|run| run.runs_per_input),
        }
    }

    /// The log for a run with `seed`.
    pub fn log(&self, seed: u64) -> Result<Cow<'_, Log>, Failure> {
        match self {
            Self::Fixed(log) | Self::Frozen(_, log) => Ok(Cow::Borrowed(log)),
            Self::Seeded(name) => scenario(name, seed).map(Cow::Owned),
        }
    }
}

/// What a name stands for.
pub enum Found {
    /// Something in the plane.
    Planar(Source),
    /// Something in space.
    Underwater(underwater::Source),
}

/// Whether there is a scenario in the plane of that name.
fn is_planar(name: &str) -> bool {
    SCENARIOS.iter().any(|(known, _)| *known == name)
}

impl Found {
    /// The scenario of that name, with a seed of its own or with that of the run; otherwise the log in that folder.
    pub fn find(argument: &Path, scenario_seed: Option<u64>) -> Result<Self, Failure> {
        match argument.to_str() {
            Some(name) if is_planar(name) || underwater::is_scenario(name) => Self::scenario(name, scenario_seed),
            _ if argument.is_dir() => Self::folder(argument),
            _ => {
                let name = argument.display();
                Err(Failure::input(format_args!("no scenario and no folder '{name}'; scenarios are {}", scenarios())))
            }
        }
    }

    /// The scenario of that name, with a seed of its own or with that of the run.
    pub fn scenario(name: &str, seed: Option<u64>) -> Result<Self, Failure> {
        if underwater::is_scenario(name) {
            return Ok(Self::Underwater(underwater::Source::Scenario(name.to_owned(), seed)));
        }
        if is_planar(name) { Source::scenario(name.to_owned(), seed).map(Self::Planar) } else { Err(no_scenario(name)) }
    }

    /// The log in that folder.
    pub fn folder(dir: &Path) -> Result<Self, Failure> {
        if log_folder::has_camera(dir) {
            underwater::read(dir).map(Self::Underwater)
        } else {
            Source::folder(dir).map(Self::Planar)
        }
    }

    /// Whether it is another log for every seed.
    pub fn is_seeded(&self) -> bool {
        matches!(self, Self::Planar(Source::Seeded(_)) | Self::Underwater(underwater::Source::Scenario(_, None)))
    }

    /// What a command that knows the plane alone works on.
    pub fn planar(self, command: &str) -> Result<Source, Failure> {
        match self {
            Self::Planar(source) => Ok(source),
            Self::Underwater(_) => {
                Err(Failure::input(format_args!("{command}: for the plane alone, not for a stereo camera in space")))
            }
        }
    }
}

/// Several sources of one kind.
pub enum Sources {
    Planar(Vec<Source>),
    Underwater(Vec<underwater::Source>),
}

impl Sources {
    /// All in the plane or all in space.
    pub fn of(found: Vec<Found>) -> Result<Self, Failure> {
        let (mut planar, mut space) = (Vec::new(), Vec::new());
        for one in found {
            match one {
                Found::Planar(source) => planar.push(source),
                Found::Underwater(source) => space.push(source),
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

/// The names of all scenarios.
fn scenarios() -> String {
    let all = SCENARIOS.iter().chain(scphd_sim::underwater::SCENARIOS);
    all.map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn no_scenario(name: &str) -> Failure {
    Failure::input(format_args!("no scenario '{name}', there are {}", scenarios()))
}

/// The log of a scenario in the plane with that seed.
pub fn scenario(name: &str, seed: u64) -> Result<Log, Failure> {
    by_name(name, seed).ok_or_else(|| no_scenario(name))
}

/// Which settings a run had: the command that prints them.
pub fn settings_command(source: &str, tuning: &Tuning) -> String {
    let Tuning { particles, samples, moving, settings } = tuning;
    let words = [
        particles.map(|particles| format!("--particles {particles}")),
        samples.map(|samples| format!("--samples {samples}")),
        moving.map(|moving| format!("--moving {}", if moving == Switch::On { "on" } else { "off" })),
        settings.as_ref().map(|path| format!("--settings {}", path.display())),
    ];
    let words: String = words.into_iter().flatten().map(|word| format!(" {word}")).collect();
    format!("settings: those that `scphd-sim settings {source}{words}` prints")
}

/// `defaults`, then the settings file, then the command line.
pub fn tuned(defaults: Settings, tuning: &Tuning) -> Result<Settings, Failure> {
    tuned_from(defaults, &mut Origins::default(), tuning)
}

/// [`tuned`], and where each setting is from, given where the defaults are from.
pub fn tuned_from(defaults: Settings, origins: &mut Origins, tuning: &Tuning) -> Result<Settings, Failure> {
    let mut settings = match &tuning.settings {
        Some(path) => origins.with_file(path, |text| defaults.with_toml(text))?,
        None => defaults,
    };
    of_options(origins, tuning);
    settings.filter.particles = tuning.particles.unwrap_or(settings.filter.particles);
    settings.filter.samples = tuning.samples.unwrap_or(settings.filter.samples);
    if let Some(moving) = tuning.moving {
        settings.set_moving(moving == Switch::On);
    }
    settings.check().map_err(|error| out_of_range(&error, tuning))?;
    Ok(settings)
}

/// What the options of the command line set is from there.
pub fn of_options(origins: &mut Origins, tuning: &Tuning) {
    let given = [
        (tuning.particles.is_some(), "filter.particles", "--particles"),
        (tuning.samples.is_some(), "filter.samples", "--samples"),
        (tuning.moving.is_some(), "moving.birth_intensity", "--moving"),
    ];
    for (_, field, option) in given.into_iter().filter(|(given, ..)| *given) {
        origins.set(field, Origin::CommandLine(option));
    }
}

/// A setting that is out of range, by the argument that sets it if that is given.
pub fn out_of_range(error: &OutOfRange, tuning: &Tuning) -> Failure {
    let OutOfRange { field, found, range } = error;
    match *field {
        "filter.particles" if tuning.particles.is_some() => {
            Failure::input(format_args!("--particles {found}: must be {range}"))
        }
        "filter.samples" if tuning.samples.is_some() => {
            Failure::input(format_args!("--samples {found}: must be {range}"))
        }
        _ => Failure::input(format_args!("settings: {error}")),
    }
}
