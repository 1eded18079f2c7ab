//! The logs of the checks, from a scenario that is simulated for every seed or from a recorded log; and the settings.

use scphd_filters::settings::Settings;
use scphd_filters::slam::{Filter, Precision};
use scphd_gpu::{Failure, Input};
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_worlds::scenario::{SCENARIOS, by_name};
use std::borrow::Cow;
use std::path::Path;

/// The filter, and changes to the settings of a scenario, as in `scphd-sim monte-carlo`.
#[derive(Debug, Default, clap::Args)]
pub struct Tuning {
    /// The joint map, not the mixture with particles.
    #[arg(long)]
    pub joint: bool,
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
    pub scenario: String,
    pub tuning: Tuning,
}

impl Source {
    /// The first scans of the log of a seed, with settings. A recorded log is the same for all seeds.
    pub fn input(&self, seed: u64, most_scans: usize) -> Result<Input<'static>, Failure> {
        let mut log = match self.folder() {
            Some(folder) => log_folder::read(folder).map_err(|error| Failure::Other(error.to_string()))?,
            None => by_name(&self.scenario, seed).ok_or_else(|| {
                let known = SCENARIOS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
                Failure::Other(format!("no scenario '{}', there are {known}", self.scenario))
            })?,
        };
        let settings = self.settings(&log)?;
        log.scans.truncate(most_scans);
        Ok((Cow::Owned(log), settings, seed))
    }

    fn folder(&self) -> Option<&Path> {
        Some(Path::new(&self.scenario)).filter(|path| path.is_dir())
    }

    /// The settings for a log of the source: those of the scenario, overridden by the file, then by the other fields of the
    /// tuning.
    fn settings(&self, log: &Log) -> Result<Settings, Failure> {
        let Tuning { particles, settings: file, joint } = &self.tuning;
        let mut settings = match self.folder() {
            Some(_) => Settings::for_log(log),
            None => Settings::for_scenario(&self.scenario, log),
        };
        if *joint {
            settings.set_for_joint_map(log);
        }
        if let Some(text) = file {
            settings = settings.with_toml(text).map_err(|problem| Failure::Other(format!("settings: {problem}")))?;
        }
        settings.filter.particles = particles.unwrap_or(settings.filter.particles);
        settings.check().map_err(|problem| Failure::Other(format!("settings: {problem}")))?;
        Ok(settings)
    }

    pub fn filter(&self) -> Filter {
        if self.tuning.joint { Filter::Joint(Precision::F32) } else { Filter::Core(Precision::F32) }
    }
}
