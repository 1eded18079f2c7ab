//! The parts that depend on the kind of vehicle: log, settings, truth, and suitable filters. Sessions, studies, tables and plots
//! are generic over it.

mod planar;
mod underwater;

use crate::settings::{FileProblem, FilterSettings, OutOfRange};
use crate::slam::{Filter, Refusal, Slam, WatchesFixes};
use scphd_log::dimensions::Dimensions;
use scphd_log::events::Event;
use scphd_log::log::{MovingLandmark, Scan, TruePose};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// Whether a sensor sees a position, m, from a true pose; `None` if that needs unknown parts of the truth.
pub type View<'a, D> = Box<dyn Fn(&TruePose<D>, <D as Dimensions>::Position) -> Option<bool> + 'a>;

/// A kind of vehicle with its sensor.
pub trait Kind: Dimensions {
    type Log: Debug + Clone + PartialEq + Send + Sync;
    type Settings: Debug + Clone + PartialEq + Serialize + DeserializeOwned + Send + Sync;

    /// The map is compared with the truth at every scan whose index is a multiple of this, and at the last.
    const SCANS_A_MAP_ERROR: usize;

    fn name(log: &Self::Log) -> &str;

    /// Its scans in order of time.
    fn scans(log: &Self::Log) -> &[Scan<Self>];

    /// Its true trajectory in order of time; empty if unknown.
    fn truth(log: &Self::Log) -> &[TruePose<Self>];

    /// Standard deviation of a coordinate of the true positions, m.
    fn truth_sigma_m(log: &Self::Log) -> f64;

    /// The true static landmarks that a map should have, m; empty if unknown.
    fn landmarks(log: &Self::Log) -> Vec<Self::Position>;

    /// Other true features, m, which a map need not have because they are seldom detected.
    fn seldom(_log: &Self::Log) -> Vec<Self::Position> {
        Vec::new()
    }

    /// True tracks of moving landmarks; `None` if the log does not know whether there are any.
    fn moving(log: &Self::Log) -> Option<&[MovingLandmark<Self>]>;

    /// Initial position of the vehicle, m.
    fn start(log: &Self::Log) -> Self::Position;

    /// The view of its sensors.
    fn view<'a>(log: &'a Self::Log, settings: &Self::Settings) -> View<'a, Self>;

    /// The position of a measurement in the map, m, for a vehicle at `pose`, and the greatest standard deviation by its noise in
    /// any direction, m; `None` if it has no position.
    fn place(
        log: &Self::Log,
        settings: &Self::Settings,
        scan: usize,
        pose: &Self::Pose,
        measurement: &Self::Measurement,
    ) -> Option<(Self::Position, f64)>;

    /// Motion, fixes and scans in the order for a filter.
    fn events(log: &Self::Log, settings: &Self::Settings) -> Result<Vec<Event<Self>>, Refusal>;

    /// The time of a row of odometry, s.
    fn row_t_s(log: &Self::Log, row: usize) -> f64;

    /// The position at every scan by dead reckoning, with odometry or instruments.
    fn dead_reckoning(log: &Self::Log, settings: &Self::Settings) -> Result<Vec<Self::Reckoned>, Refusal>;

    /// Starts a filter.
    fn slam(
        filter: Filter,
        log: &Self::Log,
        settings: &Self::Settings,
        seed: u64,
    ) -> Result<Box<dyn Slam<Self>>, Refusal>;

    /// The monitor of fixes that a filter refuses.
    fn fix_watch(settings: &Self::Settings) -> Result<Box<dyn WatchesFixes<Self>>, Refusal>;

    fn recursion(settings: &Self::Settings) -> &FilterSettings;

    /// The same, mutable.
    fn recursion_mut(settings: &mut Self::Settings) -> &mut FilterSettings;

    /// Mean number of false measurements and births in a scan, ∫ κ + w dz.
    fn unexplained_per_scan(log: &Self::Log, settings: &Self::Settings) -> f64;

    /// Settings of the recursion of the thesis, without the parts that the reference does not have.
    fn of_reference(log: &Self::Log) -> Self::Settings;

    /// These settings, overridden by the fields in `text`.
    fn with_toml(settings: &Self::Settings, text: &str) -> Result<Self::Settings, FileProblem>;

    /// The first field that is out of range for runs over this log, if any.
    fn check(log: &Self::Log, settings: &Self::Settings) -> Result<(), OutOfRange>;
}
