//! The logs of a study, from a scenario that is simulated for every seed or from a recorded log; and the settings.

use crate::batch::Sort;
use crate::failure::Failure;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_gpu_kernels::PARTICLES;
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_run::monte_carlo::Plan;
use scphd_run::session::Filter;
use scphd_worlds::scenario::{SCENARIOS, by_name, thesis_run};
use std::path::Path;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum FilterName {
    /// The mixture with particles.
    #[default]
    Core,
    /// The joint map.
    Joint,
}

/// The filter, and changes to the settings of a scenario, as in `scphd-sim monte-carlo`.
#[derive(Debug, Default, clap::Args)]
pub struct Tuning {
    /// The filter.
    #[arg(long, value_enum, default_value_t)]
    pub filter: FilterName,
    /// Number of particles; more than 32 are one large filter for each run.
    #[arg(long, value_name = "N")]
    pub particles: Option<usize>,
    /// Settings in TOML that replace those of the scenario.
    #[arg(long, value_name = "FILE.toml", value_parser = |path: &str| std::fs::read_to_string(path))]
    pub settings: Option<String>,
}

/// A scenario, or the folder of a recorded log, and the settings.
#[derive(Debug)]
pub struct Source {
    scenario: String,
    tuning: Tuning,
}

impl Source {
    /// The scenario of that name, or the log in that folder, with the tuning.
    pub fn new(scenario: &str, tuning: Tuning) -> Result<Self, Failure> {
        let source = Self { scenario: scenario.into(), tuning };
        source.settings(&source.log(0)?)?;
        Ok(source)
    }

    /// The log of a seed. A recorded log is the same for all seeds.
    pub fn log(&self, seed: u64) -> Result<Log, Failure> {
        if let Some(folder) = self.folder() {
            return log_folder::read(folder).map_err(|error| Failure::Other(error.to_string()));
        }
        let known = || SCENARIOS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        by_name(&self.scenario, seed)
            .ok_or_else(|| Failure::Other(format!("no scenario '{}', there are {}", self.scenario, known())))
    }

    fn folder(&self) -> Option<&Path> {
        Some(Path::new(&self.scenario)).filter(|path| path.is_dir())
    }

    /// The settings for a log of the source: those of the scenario, overridden by the file, then by the other fields of the
    /// tuning.
    pub fn settings(&self, log: &Log) -> Result<Settings, Failure> {
        let Tuning { particles, settings: file, .. } = &self.tuning;
        let mut settings = match self.folder() {
            Some(_) => Settings::for_log(log),
            None => Settings::for_scenario(&self.scenario, log),
        };
        if self.is_joint() {
            settings.set_for_joint_map(log);
        }
        if let Some(text) = file {
            settings = settings.with_toml(text).map_err(|problem| Failure::Other(format!("settings: {problem}")))?;
        }
        settings.filter.particles = particles.unwrap_or(settings.filter.particles);
        settings.check().map_err(|problem| Failure::Other(format!("settings: {problem}")))?;
        Ok(settings)
    }

    fn is_joint(&self) -> bool {
        self.tuning.filter == FilterName::Joint
    }

    pub fn filter(&self) -> Filter {
        if self.is_joint() { Filter::Joint(Precision::F32) } else { Filter::Core(Precision::F32) }
    }

    pub fn sort(&self, settings: &Settings) -> Sort {
        match settings.filter.particles {
            _ if self.is_joint() => Sort::Joint,
            ..=PARTICLES => Sort::Many,
            _ => Sort::Large,
        }
    }

    /// The plan of a study of `runs` runs with seeds from `seed` on, and the given number of input sets; by default, that of the
    /// thesis.
    pub fn plan(&self, runs: usize, input_sets: Option<usize>, seed: u64) -> Result<Plan, Failure> {
        let usual = thesis_run(&self.scenario).map(|run| run.runs_per_input);
        let usual = usual.filter(|&each| runs.is_multiple_of(each)).map(|each| runs / each);
        let input_sets = input_sets.or(usual).unwrap_or(runs);
        if runs == 0 || input_sets == 0 || !runs.is_multiple_of(input_sets) {
            return Err(Failure::Other(format!("{runs} runs: must be a multiple of the {input_sets} input sets")));
        }
        let settings = self.settings(&self.log(seed)?)?;
        Ok(Plan {
            scenario: self.scenario.clone(),
            filters: vec![self.filter().name(settings.filter.likelihood).into()],
            runs,
            input_sets,
            seed,
            settings: toml::to_string(&settings).map_err(|error| Failure::Other(error.to_string()))?,
            variants: Vec::new(),
        })
    }
}
