//! The logs of a study, from a scenario that is simulated for every seed or from a recorded log; and the settings.

use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_run::monte_carlo::Plan;
use scphd_run::session::Filter;
use scphd_score::results::json::Format;
use scphd_worlds::scenario::{SCENARIOS, by_name, thesis_run};
use std::path::Path;

pub(crate) const FILTER: Filter = Filter::Core(Precision::F32);

/// Changes to the settings of a scenario, as in `scphd-sim monte-carlo`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tuning {
    /// Number of particles.
    pub particles: Option<usize>,
    /// Number of samples of each particle.
    pub samples: Option<usize>,
    /// Whether features may move.
    pub moving: Option<bool>,
    /// Fields in TOML that override the defaults.
    pub settings: Option<String>,
}

/// A scenario, or the folder of a recorded log, and the settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    scenario: String,
    tuning: Tuning,
}

/// The reason why a study's source or number of runs is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SourceError(String);

impl Source {
    /// The scenario of that name, or the log in that folder, with the tuning.
    ///
    /// # Errors
    /// There is no such scenario or log, or its settings are out of range.
    pub fn new(scenario: &str, tuning: Tuning) -> Result<Self, SourceError> {
        let source = Self { scenario: scenario.into(), tuning };
        source.settings(&source.log(0)?)?;
        Ok(source)
    }

    /// The log of a seed. A recorded log is the same for all seeds.
    ///
    /// # Errors
    /// There is no such scenario, or the log is invalid.
    pub fn log(&self, seed: u64) -> Result<Log, SourceError> {
        if let Some(folder) = self.folder() {
            return log_folder::read(folder).map_err(|error| SourceError(error.to_string()));
        }
        let known = || SCENARIOS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        by_name(&self.scenario, seed)
            .ok_or_else(|| SourceError(format!("no scenario '{}', there are {}", self.scenario, known())))
    }

    /// The folder of the recorded log, if the source is one.
    fn folder(&self) -> Option<&Path> {
        Some(Path::new(&self.scenario)).filter(|path| path.is_dir())
    }

    /// The settings for a log of the source: those of the scenario, overridden by the file, then by the other fields of the
    /// tuning.
    ///
    /// # Errors
    /// They are out of range.
    pub fn settings(&self, log: &Log) -> Result<Settings, SourceError> {
        let Tuning { particles, samples, moving, settings: file } = &self.tuning;
        let mut settings = match self.folder() {
            Some(_) => Settings::for_log(log),
            None => Settings::for_scenario(&self.scenario, log),
        };
        if let Some(text) = file {
            settings = settings.with_toml(text).map_err(|problem| SourceError(format!("settings: {problem}")))?;
        }
        settings.filter.particles = particles.unwrap_or(settings.filter.particles);
        settings.filter.samples = samples.unwrap_or(settings.filter.samples);
        if let Some(moving) = *moving {
            settings.set_moving(moving);
        }
        settings.check().map_err(|problem| SourceError(format!("settings: {problem}")))?;
        Ok(settings)
    }

    /// The plan of a study of `runs` runs with seeds from `seed` on, and the given number of input sets; by default, that of the
    /// thesis.
    ///
    /// # Errors
    /// The number of runs is no multiple of the number of input sets.
    pub fn plan(&self, runs: usize, input_sets: Option<usize>, seed: u64) -> Result<Plan, SourceError> {
        let usual = thesis_run(&self.scenario).map(|run| run.runs_per_input);
        let usual = usual.filter(|&each| runs.is_multiple_of(each)).map(|each| runs / each);
        let input_sets = input_sets.or(usual).unwrap_or(runs);
        if runs == 0 || input_sets == 0 || !runs.is_multiple_of(input_sets) {
            return Err(SourceError(format!("{runs} runs: must be a multiple of the {input_sets} input sets")));
        }
        let settings = self.settings(&self.log(seed)?)?;
        Ok(Plan {
            format: Format,
            scenario: self.scenario.clone(),
            filters: vec![FILTER.name(settings.filter.likelihood).into()],
            runs,
            input_sets,
            seed,
            settings: toml::to_string(&settings).map_err(|error| SourceError(error.to_string()))?,
            variants: Vec::new(),
        })
    }
}
