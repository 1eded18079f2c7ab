//! Vehicles in the plane with a range-bearing sensor.

use super::{Kind, View};
use crate::ekf::Ekf;
use crate::settings::{FileProblem, FilterSettings, OutOfRange, SensorSettings, Settings};
use crate::slam::{
    Filter, PlanarWatch, ReferenceFilter, Refusal, Slam, WatchesFixes, core_filter, joint_filter, started_nearby,
};
use crate::window::Window;
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::{Log, MovingLandmark, Scan, TruePose};
use scphd_log::vehicle;

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

    fn truth_sigma_m(log: &Log) -> f64 {
        log.truth_sigma_m
    }

    fn landmarks(log: &Log) -> Vec<[f64; 2]> {
        log.landmarks.clone()
    }

    fn moving(log: &Log) -> Option<&[MovingLandmark]> {
        // A simulation without a list of moving landmarks has none; for a real log they are unknown.
        let known = !log.moving.is_empty() || (log.simulated && !log.landmarks.is_empty());
        known.then_some(&log.moving)
    }

    fn start(log: &Log) -> [f64; 2] {
        [log.initial_pose[0], log.initial_pose[1]]
    }

    fn view<'a>(_log: &'a Log, settings: &Settings) -> View<'a, Self> {
        let windows: Vec<Window> = settings.sensors().map(Window::of_settings).collect();
        // In view of any sensor; not in view if that is known for all sensors.
        Box::new(move |pose, point| {
            let held = windows.iter().map(|window| window.holds(pose, point));
            held.reduce(|one, other| if one == Some(false) || other == Some(true) { other } else { one })?
        })
    }

    fn place(
        log: &Log,
        settings: &Settings,
        scan: usize,
        pose: &[f64; 3],
        [range_m, bearing_rad]: &[f64; 2],
    ) -> Option<([f64; 2], f64)> {
        let sensor = settings.sensors().nth(log.scans[scan].sensor)?;
        let [x, y, heading] = sensor.mounting().seat(*pose);
        let angle = heading + bearing_rad;
        let place = [x + range_m * libm::cos(angle), y + range_m * libm::sin(angle)];
        Some((place, sensor.range_sigma_at(*range_m).max(range_m.abs() * sensor.bearing_sigma_rad)))
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
            Filter::Core(precision) => started_nearby(precision, log.initial_pose, |initial_pose| {
                Ok(core_filter(settings, &log.vehicle, initial_pose, precision, seed)?)
            }),
            Filter::Joint(precision) => started_nearby(precision, log.initial_pose, |initial_pose| {
                Ok(joint_filter(settings, &log.vehicle, initial_pose, precision)?)
            }),
            Filter::Reference if !log.fixes.is_empty() => {
                Err(Refusal("the reference takes no fixes of the pose; core, joint and ekf do".into()))
            }
            Filter::Reference if settings.calibration.is_some() => {
                Err(Refusal("calibration: the reference takes odometry as it is; --filter joint learns".into()))
            }
            Filter::Reference => Ok(Box::new(ReferenceFilter::start(settings, &log.vehicle, log.initial_pose, seed))),
            Filter::Ekf(association) => Ok(Box::new(Ekf::start(log, association)?)),
        }
    }

    fn fix_watch(settings: &Settings) -> Result<Box<dyn WatchesFixes<Self>>, Refusal> {
        Ok(Box::new(PlanarWatch::of(&settings.fixes.unwrap_or_default())?))
    }

    fn recursion(settings: &Settings) -> &FilterSettings {
        &settings.filter
    }

    fn recursion_mut(settings: &mut Settings) -> &mut FilterSettings {
        &mut settings.filter
    }

    fn unexplained_per_scan(log: &Log, settings: &Settings) -> f64 {
        let births = settings.filter.birth_intensity + settings.moving.birth_intensity;
        let of_a_scan =
            |sensor: &SensorSettings| sensor.clutter_per_scan + sensor.birth_factor * births * sensor.measure();
        let scans = |of: usize| log.scans.iter().filter(|scan| scan.sensor == of).count() as f64;
        let share = |of: usize| if log.others.is_empty() { 1.0 } else { scans(of) / log.scans.len() as f64 };
        settings.sensors().enumerate().map(|(of, sensor)| share(of) * of_a_scan(sensor)).sum()
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
