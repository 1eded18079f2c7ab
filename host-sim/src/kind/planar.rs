//! Vehicles in the plane with a range-bearing sensor.

use super::{Kind, View};
use crate::dimensions::Planar;
use crate::ekf::Ekf;
use crate::events::{Event, events};
use crate::log::{Log, MovingLandmark, Scan, TruePose};
use crate::settings::{FileProblem, FilterSettings, OutOfRange, Settings};
use crate::slam::{Filter, ReferenceFilter, Refusal, Slam, core_filter, joint_filter};
use crate::truth::window::Window;
use crate::vehicle;

impl Kind for Planar {
    type Log = Log;
    type Settings = Settings;

    const SCANS_A_MAP_ERROR: usize = 1;

    fn name(log: &Log) -> &str {
        &log.name
    }

    fn scans(log: &Log) -> &[Scan] {
        &log.scans
    }

    fn truth(log: &Log) -> &[TruePose] {
        &log.truth
    }

    fn landmarks(log: &Log) -> Vec<[f64; 2]> {
        log.landmarks.clone()
    }

    fn moving(log: &Log) -> Option<&[MovingLandmark]> {
        // A simulation that lists no moving landmark has none; a real log may just not know.
        let known = !log.moving.is_empty() || (log.simulated && !log.landmarks.is_empty());
        known.then_some(&log.moving)
    }

    fn start(log: &Log) -> [f64; 2] {
        [log.initial_pose[0], log.initial_pose[1]]
    }

    fn view<'a>(_log: &'a Log, settings: &Settings) -> View<'a, Self> {
        let window = Window::of_settings(&settings.sensor);
        Box::new(move |pose, point| window.holds(pose, point))
    }

    fn events(log: &Log, _settings: &Settings) -> Result<Vec<Event>, Refusal> {
        Ok(events(log).collect())
    }

    fn row_t_s(log: &Log, row: usize) -> f64 {
        log.odometry[row].t_s
    }

    fn dead_reckoning(log: &Log, _settings: &Settings) -> Result<Vec<[f64; 3]>, Refusal> {
        Ok(vehicle::dead_reckoning(log))
    }

    fn slam(filter: Filter, log: &Log, settings: &Settings, seed: u64) -> Result<Box<dyn Slam>, Refusal> {
        match filter {
            Filter::Core(precision) => Ok(core_filter(settings, &log.vehicle, log.initial_pose, precision, seed)?),
            Filter::Joint(precision) => joint_filter(settings, &log.vehicle, log.initial_pose, precision),
            Filter::Reference => Ok(Box::new(ReferenceFilter::start(settings, &log.vehicle, log.initial_pose, seed))),
            Filter::Ekf(association) => Ok(Box::new(Ekf::start(log, association)?)),
        }
    }

    fn recursion(settings: &Settings) -> &FilterSettings {
        &settings.filter
    }

    fn recursion_mut(settings: &mut Settings) -> &mut FilterSettings {
        &mut settings.filter
    }

    fn unexplained_per_scan(_log: &Log, settings: &Settings) -> f64 {
        let births = settings.filter.birth_intensity + settings.moving.birth_intensity;
        settings.sensor.clutter_per_scan + births * settings.sensor.measure()
    }

    fn of_reference(log: &Log) -> Settings {
        let mut settings = Settings::for_log(log);
        settings.restrict_to_reference();
        settings
    }

    fn with_toml(settings: &Settings, text: &str) -> Result<Settings, FileProblem> {
        settings.with_toml(text)
    }

    fn check(_log: &Log, settings: &Settings) -> Result<(), OutOfRange> {
        settings.check()
    }
}
