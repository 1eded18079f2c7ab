//! What a kind of vehicle supplies: its log, settings and truth, and filters that fit it. Sessions, studies, tables and pictures are
//! written once, for any kind.

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

/// Whether a sensor sees a place, m, from a true pose; `None` where that would take what the truth does not know.
pub type View<'a, D> = Box<dyn Fn(&TruePose<D>, <D as Dimensions>::Position) -> Option<bool> + 'a>;

/// A kind of vehicle with its sensor.
pub trait Kind: Dimensions {
    /// A log.
    type Log: Debug + Clone + PartialEq + Send + Sync;
    /// What a run over it can be tuned with.
    type Settings: Debug + Clone + PartialEq + Serialize + DeserializeOwned + Send + Sync;

    /// A map is compared with the truth at every so many scans only, and at the last.
    const SCANS_A_MAP_ERROR: usize;

    /// The name of the log.
    fn name(log: &Self::Log) -> &str;

    /// Its scans in order of time.
    fn scans(log: &Self::Log) -> &[Scan<Self>];

    /// Its true trajectory in order of time; empty if unknown.
    fn truth(log: &Self::Log) -> &[TruePose<Self>];

    /// Standard deviation of a coordinate of its positions, m.
    fn truth_sigma_m(log: &Self::Log) -> f64;

    /// The true static landmarks that a map should have, m; empty if unknown.
    fn landmarks(log: &Self::Log) -> Vec<Self::Position>;

    /// Other true features, m, which a map need not have: they are seldom detected.
    fn seldom(_log: &Self::Log) -> Vec<Self::Position> {
        Vec::new()
    }

    /// True tracks of what moves; `None` where the log does not know whether anything does.
    fn moving(log: &Self::Log) -> Option<&[MovingLandmark<Self>]>;

    /// Where the vehicle starts, m.
    fn start(log: &Self::Log) -> Self::Position;

    /// What its sensor sees.
    fn view<'a>(log: &'a Self::Log, settings: &Self::Settings) -> View<'a, Self>;

    /// Where a measurement of a scan lies in the map, m, if the vehicle is at `pose`, and the standard deviation of its noise there in its worst
    /// direction, m; `None` where it has no place.
    fn place(
        log: &Self::Log,
        settings: &Self::Settings,
        scan: usize,
        pose: &Self::Pose,
        measurement: &Self::Measurement,
    ) -> Option<(Self::Position, f64)>;

    /// Motion and scans in the order in which a filter needs them.
    ///
    /// # Errors
    /// The log or the settings say what no filter can be told.
    fn events(log: &Self::Log, settings: &Self::Settings) -> Result<Vec<Event<Self>>, Refusal>;

    /// The time of a row of odometry, s.
    fn row_t_s(log: &Self::Log, row: usize) -> f64;

    /// Where the vehicle is at every scan by odometry, or instruments, alone.
    ///
    /// # Errors
    /// As for [`events`](Self::events).
    fn dead_reckoning(log: &Self::Log, settings: &Self::Settings) -> Result<Vec<Self::Reckoned>, Refusal>;

    /// A filter at the start of the log.
    ///
    /// # Errors
    /// There is no such filter for this kind, or it cannot work with the settings.
    fn slam(
        filter: Filter,
        log: &Self::Log,
        settings: &Self::Settings,
        seed: u64,
    ) -> Result<Box<dyn Slam<Self>>, Refusal>;

    /// What watches the fixes that a filter refuses.
    ///
    /// # Errors
    /// Their noise is out of range.
    fn fix_watch(settings: &Self::Settings) -> Result<Box<dyn WatchesFixes<Self>>, Refusal>;

    /// The recursion's part of the settings.
    fn recursion(settings: &Self::Settings) -> &FilterSettings;

    /// The same, to be changed.
    fn recursion_mut(settings: &mut Self::Settings) -> &mut FilterSettings;

    /// Mean number of false measurements and births in a scan, ∫ κ + w dz.
    fn unexplained_per_scan(log: &Self::Log, settings: &Self::Settings) -> f64;

    /// Settings of the recursion of the thesis, which is all that the reference has.
    fn of_reference(log: &Self::Log) -> Self::Settings;

    /// These settings with the fields in `text` put over them.
    ///
    /// # Errors
    /// `text` is no settings file.
    fn with_toml(settings: &Self::Settings, text: &str) -> Result<Self::Settings, FileProblem>;

    /// The first field that is out of range for runs over this log, if any.
    ///
    /// # Errors
    /// Names the field and its range.
    fn check(log: &Self::Log, settings: &Self::Settings) -> Result<(), OutOfRange>;
}
