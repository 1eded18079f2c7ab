//! The scenarios, log folders and default settings of each kind of vehicle.

use super::args::DeviceName;
use super::device::{self, Input, On};
use super::failure::Failure;
use scphd_boards::stream::{self, Recorded, Stream};
use scphd_check::Checked;
use scphd_exchange::mcap::Exported;
use scphd_filters::settings::{Origin, Origins, Settings};
use scphd_filters::slam::{Refusal, Slam};
use scphd_filters::underwater::settings as in_space;
use scphd_log::dimensions::{Planar, Underwater};
use scphd_log::log::Log;
use scphd_run::compare::Lockstep;
use scphd_run::tune::Learn;
use scphd_stream::Scalar;
use scphd_worlds::scenario::{SCENARIOS, WORLDS, by_name, is_of_thesis, thesis_run};
use scphd_worlds::underwater;

/// A kind of vehicle for the commands.
pub trait Offer: Lockstep + Learn + Checked + Exported {
    /// The scenarios with a different world for every seed.
    const WORLDS: &'static [&'static str];

    /// Names of the scenarios, each with a description.
    const SCENARIOS: &'static [(&'static str, &'static str)];

    fn scenario(name: &str, seed: u64) -> Option<Self::Log>;

    fn defaults(scenario: Option<&str>, log: &Self::Log) -> Self::Settings;

    fn origins(scenario: Option<&str>, log: &Self::Log) -> Origins;

    /// Changes default settings for a log to those for a joint map.
    fn set_for_joint_map(settings: &mut Self::Settings, log: &Self::Log);

    fn set_moving(settings: &mut Self::Settings, moving: bool) -> Result<(), &'static str>;

    fn set_hypotheses(settings: &mut Self::Settings, hypotheses: usize) -> Result<(), &'static str>;

    /// The log as a stream for a vehicle computer.
    fn stream(
        log: &Self::Log,
        settings: &Self::Settings,
        filter: Recorded,
        seed: u64,
        scalar: Scalar,
        scans: usize,
    ) -> Result<Stream, Refusal>;

    /// The stream with a snapshot after every `every` scans.
    fn with_snapshots(stream: Stream, scalar: Scalar, every: u32) -> Result<Stream, Refusal>;

    /// Whether the joint map is the default filter.
    fn is_joint_usual(scenario: Option<&str>) -> bool;

    /// Number of runs with each input, if the thesis states it.
    fn runs_per_input(_scenario: &str) -> Option<usize> {
        None
    }

    /// Runs a filter with all inputs on a [device], and passes each run as a filter to `finish`.
    fn run_on<'l, R: Send>(
        _device: DeviceName,
        _on: On,
        _runs: usize,
        _input: impl Fn(usize) -> Result<Input<'l, Self>, Failure> + Sync,
        _finish: impl Fn(usize, &mut dyn Slam<Self>, &Input<'l, Self>) -> Result<R, Failure> + Sync,
    ) -> Result<Vec<R>, Failure>
    where
        Self::Log: 'l,
    {
        Err(Failure::input("--device: for vehicles in the plane only"))
    }
}

impl Offer for Planar {
    const WORLDS: &'static [&'static str] = &WORLDS;

    const SCENARIOS: &'static [(&'static str, &'static str)] = SCENARIOS;

    fn scenario(name: &str, seed: u64) -> Option<Log> {
        by_name(name, seed)
    }

    /// The defaults for the log, and the thesis's parameters for its scenario.
    fn defaults(scenario: Option<&str>, log: &Log) -> Settings {
        scenario.map_or_else(|| Settings::for_log(log), |name| Settings::for_scenario(name, log))
    }

    fn origins(scenario: Option<&str>, log: &Log) -> Origins {
        let mut origins = Origins::of_log(log);
        origins.set_changed(&Settings::for_log(log), &Self::defaults(scenario, log), &Origin::Experiment);
        origins
    }

    fn set_for_joint_map(settings: &mut Settings, log: &Log) {
        settings.set_for_joint_map(log);
    }

    fn set_moving(settings: &mut Settings, moving: bool) -> Result<(), &'static str> {
        settings.set_moving(moving);
        Ok(())
    }

    fn set_hypotheses(settings: &mut Settings, hypotheses: usize) -> Result<(), &'static str> {
        settings.joint.hypotheses = hypotheses;
        Ok(())
    }

    fn stream(
        log: &Log,
        settings: &Settings,
        filter: Recorded,
        seed: u64,
        scalar: Scalar,
        scans: usize,
    ) -> Result<Stream, Refusal> {
        stream::write(log, settings, filter, seed, scalar, scans)
    }

    fn with_snapshots(stream: Stream, scalar: Scalar, every: u32) -> Result<Stream, Refusal> {
        stream.with_snapshots(scalar, every)
    }

    /// For a log, or a scenario like one; not for an experiment of the thesis.
    fn is_joint_usual(scenario: Option<&str>) -> bool {
        scenario.is_none_or(|name| !is_of_thesis(name))
    }

    fn runs_per_input(scenario: &str) -> Option<usize> {
        thesis_run(scenario).map(|run| run.runs_per_input)
    }

    fn run_on<'l, R: Send>(
        device: DeviceName,
        on: On,
        runs: usize,
        input: impl Fn(usize) -> Result<Input<'l, Self>, Failure> + Sync,
        finish: impl Fn(usize, &mut dyn Slam<Self>, &Input<'l, Self>) -> Result<R, Failure> + Sync,
    ) -> Result<Vec<R>, Failure> {
        device::run(device, on, runs, input, finish)
    }
}

impl Offer for Underwater {
    const WORLDS: &'static [&'static str] = &underwater::WORLDS;

    const SCENARIOS: &'static [(&'static str, &'static str)] = underwater::SCENARIOS;

    fn scenario(name: &str, seed: u64) -> Option<scphd_log::underwater::Log> {
        underwater::by_name(name, seed)
    }

    /// Table 7.1 for a scenario of the thesis; a random world has the settings of a recorded log.
    fn defaults(scenario: Option<&str>, log: &scphd_log::underwater::Log) -> in_space::Settings {
        if Self::is_joint_usual(scenario) {
            in_space::Settings::for_real_log(log)
        } else {
            in_space::Settings::for_log(log)
        }
    }

    /// For a log and a random world; not for the experiment of the thesis.
    fn is_joint_usual(scenario: Option<&str>) -> bool {
        scenario.is_none_or(|name| underwater::WORLDS.contains(&name))
    }

    fn origins(scenario: Option<&str>, log: &scphd_log::underwater::Log) -> Origins {
        Origins::of(&Self::defaults(scenario, log), in_space::stated(scenario.is_some(), log))
    }

    fn set_for_joint_map(_settings: &mut in_space::Settings, _log: &scphd_log::underwater::Log) {}

    fn set_moving(_settings: &mut in_space::Settings, moving: bool) -> Result<(), &'static str> {
        if moving { Err("underwater runs take everything for static") } else { Ok(()) }
    }

    fn set_hypotheses(_settings: &mut in_space::Settings, hypotheses: usize) -> Result<(), &'static str> {
        if hypotheses == 1 { Ok(()) } else { Err("under water the joint map has one") }
    }

    fn stream(
        log: &scphd_log::underwater::Log,
        settings: &in_space::Settings,
        filter: Recorded,
        seed: u64,
        scalar: Scalar,
        scans: usize,
    ) -> Result<Stream, Refusal> {
        stream::write_underwater(log, settings, filter, seed, scalar, scans)
    }

    fn with_snapshots(stream: Stream, scalar: Scalar, every: u32) -> Result<Stream, Refusal> {
        stream.with_snapshots_under_water(scalar, every)
    }
}
