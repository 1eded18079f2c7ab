//! What a run starts from: a log and its settings.

use super::args::{Switch, Tuning};
use super::failure::Failure;
use scphd_sim::log::Log;
use scphd_sim::log_folder;
use scphd_sim::scenario::{SCENARIOS, by_name, thesis_run};
use scphd_sim::settings::Settings;
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
    /// A scenario, with a seed of its own or with that of the run.
    pub fn scenario(name: String, seed: Option<u64>) -> Result<Self, Failure> {
        Ok(match seed {
            Some(seed) => {
                let log = scenario(&name, seed)?;
                Self::Frozen(name, Box::new(log))
            }
            None => Self::Seeded(name),
        })
    }

    /// A scenario where the argument names one, or the log of a folder; with the scenario's seed.
    pub fn scenario_or_folder(argument: &Path, seed: u64) -> Result<Self, Failure> {
        match argument.to_str().filter(|name| SCENARIOS.iter().any(|(known, _)| known == name)) {
            Some(name) => Self::scenario(name.to_owned(), Some(seed)),
            None => Self::folder(argument),
        }
    }

    /// The log of a folder where there is one, or a scenario.
    pub fn folder_or_scenario(argument: &Path, seed: u64) -> Result<Self, Failure> {
        if argument.is_dir() {
            Self::folder(argument)
        } else {
            Self::scenario(argument.to_string_lossy().into_owned(), Some(seed))
        }
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

/// The log of a scenario with that seed.
pub fn scenario(name: &str, seed: u64) -> Result<Log, Failure> {
    by_name(name, seed).ok_or_else(|| {
        let known: Vec<&str> = SCENARIOS.iter().map(|(name, _)| *name).collect();
        Failure::input(format_args!("no scenario '{name}', there are: {}", known.join(", ")))
    })
}

/// `defaults`, then the settings file, then the command line.
pub fn tuned(defaults: Settings, tuning: &Tuning) -> Result<Settings, Failure> {
    let mut settings = match &tuning.settings {
        Some(path) => defaults.with_file(path)?,
        None => defaults,
    };
    settings.filter.particles = tuning.particles.unwrap_or(settings.filter.particles);
    settings.filter.samples = tuning.samples.unwrap_or(settings.filter.samples);
    if let Some(moving) = tuning.moving {
        settings.set_moving(moving == Switch::On);
    }
    // The defaults and the file are within the limits, so whatever is not comes from an argument of the same name.
    settings.check().map_err(|error| {
        let name = error.field.rsplit('.').next().unwrap_or(error.field);
        Failure::input(format_args!("--{name} {}: must be {}", error.found, error.range))
    })?;
    Ok(settings)
}
