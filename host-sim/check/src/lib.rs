//! Checks of a log: units, clocks, repeated scans, views, dead reckoning compared with the truth.
//!
//! The reader of folders ([`scphd_log::log_folder`]) refuses what no vehicle and no sensor can do. A log that it reads may still
//! be wrong: a turn rate in degrees a second, bearings that grow to the right, scans written twice. Each [`Finding`] has a place,
//! an observation with its figures, and advice. `docs/check.md` lists all with their thresholds. A threshold is a physical limit
//! of a vehicle or sensor, or compares two readings of the same log; none was fitted to a log.

mod advice;
mod agreement;
mod clock;
mod detections;
mod facts;
mod files;
mod finding;
mod fixes;
mod headings;
mod intervals;
mod jumps;
mod reading;
mod returns;
mod reverse;
mod shift;
mod sideways;
mod sight;
mod space;
mod spike;
mod still;
mod view;
mod way;

pub use facts::Facts;
pub use finding::{Finding, Severity};

use finding::{Findings, Motion};
use scphd_filters::kind::Kind;
use scphd_filters::settings::Settings;
use scphd_filters::underwater::settings::Settings as UnderwaterSettings;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Planar, Underwater};
use scphd_log::log::{Log, Vehicle};
use scphd_log::log_folder::{self, LogError};
use scphd_log::underwater;
use scphd_score::results::OutputError;
use scphd_score::results::json::{self, Format};
use serde::Serialize;
use std::path::Path;

/// The result of a check, in its serialised form.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    pub format: Format,
    /// Name of the log, or of the folder if the log cannot be read.
    pub log: String,
    /// The measured figures; `None` if the log cannot be read.
    pub facts: Option<Facts>,
    /// The findings, the worst first.
    pub findings: Vec<Finding>,
}

impl Report {
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }
}

/// Writes reports to `path` as one JSON object, or a list of several; the file is complete or not written.
pub fn write(path: &Path, reports: &[Report]) -> Result<(), OutputError> {
    match reports {
        [one] => json::write(path, one),
        several => json::write(path, several),
    }
}

/// The parts of a check that depend on the kind of vehicle.
pub trait Checked: Kind {
    /// Reads a folder.
    fn read(dir: &Path) -> Result<Self::Log, Vec<LogError>>;

    fn settings(log: &Self::Log) -> Self::Settings;

    /// Corrects obvious errors before a run. Returns a description of each correction.
    fn mend(_log: &mut Self::Log) -> Vec<String> {
        Vec::new()
    }

    /// Reports false rows of the truth. Returns the log without them if there are any.
    fn truth_only(_log: &Self::Log, _findings: &mut Vec<Finding>) -> Option<Self::Log> {
        None
    }

    #[doc(hidden)]
    fn in_detail(log: &Self::Log) -> Detail;
}

/// The results of the checks that differ between the kinds of vehicles.
#[doc(hidden)]
#[derive(Debug)]
pub struct Detail {
    motion: Vec<Motion>,
    /// Range of the sensors, m.
    reach_m: f64,
    simulated: bool,
    out_of_view: Option<f64>,
    findings: Findings,
}

impl Checked for Planar {
    fn read(dir: &Path) -> Result<Log, Vec<LogError>> {
        log_folder::read_or_all(dir)
    }

    fn settings(log: &Log) -> Settings {
        Settings::for_log(log)
    }

    fn mend(log: &mut Log) -> Vec<String> {
        let mut done = Vec::new();
        let found = jumps::false_truth(log);
        if !found.is_empty() {
            done.push(format!("truth.csv: {} of {} rows are not scored [truth-jumps]", found.len(), log.truth.len()));
            *log = jumps::without(log, &found);
        }
        let left_out = still::leave_out(log, &agreement::zones(log));
        if left_out > 0 {
            done.push(format!(
                "detections.csv: {left_out} detections of what stands still in the view are left out, as scphd-sim check proposes [fixed-in-view]"
            ));
        }
        if let Some(off_rad) = headings::start_off(log) {
            let [_, _, heading] = &mut log.initial_pose;
            let turned = wrap(*heading + off_rad);
            done.push(format!(
                "the heading at the start is {turned:.3} rad by the first positions of fixes.csv, not {heading:.3} [start-heading]"
            ));
            *heading = turned;
        }
        done
    }

    fn truth_only(log: &Log, findings: &mut Vec<Finding>) -> Option<Log> {
        let found = jumps::false_truth(log);
        if found.is_empty() {
            return None;
        }
        let mut named = Findings::default();
        jumps::truth(log, &found, &mut named);
        findings.extend(named.0);
        Some(jumps::without(log, &found))
    }

    fn in_detail(log: &Log) -> Detail {
        let turn = |[speed, second, _]: [f64; 3]| match log.vehicle {
            Vehicle::Ackermann { wheelbase_m, .. } => speed * libm::tan(second) / wheelbase_m,
            Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => second,
        };
        let motion = log.odometry.iter().map(|row| Motion {
            t_s: row.t_s,
            speed_mps: Some(row.speed_mps().abs()),
            turn_radps: turn(row.control),
        });
        let mut findings = Findings::default();
        headings::truth(log, &mut findings);
        let out_of_view = view::planar(log, &mut findings);
        returns::look_over(log, &mut findings);
        agreement::planar(log, &mut findings);
        let reach_m = log.sensors().map(|(_, sensor, _)| sensor.range_max_m).fold(0.0, f64::max);
        fixes::planar(log, reach_m, &mut findings);
        jumps::fixes(log, &mut findings);
        headings::fixes(log, &mut findings);
        headings::start(log, &mut findings);
        sideways::look_over(log, reach_m, &mut findings);
        Detail { motion: motion.collect(), reach_m, simulated: log.simulated, out_of_view, findings }
    }
}

impl Checked for Underwater {
    fn read(dir: &Path) -> Result<underwater::Log, Vec<LogError>> {
        log_folder::read_underwater(dir).map_err(|error| vec![error])
    }

    fn settings(log: &underwater::Log) -> UnderwaterSettings {
        UnderwaterSettings::for_real_log(log)
    }

    fn in_detail(log: &underwater::Log) -> Detail {
        let motion = log.instruments.iter().map(|row| Motion {
            t_s: row.t_s,
            speed_mps: row.velocity_mps.map(|[x, y, z]| libm::sqrt(x * x + y * y + z * z)),
            turn_radps: row.yaw_rate_radps,
        });
        let mut findings = Findings::default();
        let out_of_view = space::camera(log, &mut findings);
        let reach_m = log.camera.depth_m[1];
        Detail { motion: motion.collect(), reach_m, simulated: log.simulated, out_of_view, findings }
    }
}

/// Checks a folder: its files, then their contents.
pub fn folder(dir: &Path) -> Report {
    if log_folder::has_camera(dir) { folder_of::<Underwater>(dir) } else { folder_of::<Planar>(dir) }
}

fn folder_of<K: Checked>(dir: &Path) -> Report {
    let mut findings = Findings::default();
    files::look_over(dir, &mut findings);
    match K::read(dir) {
        Ok(log) => {
            let (facts, more) = log_of::<K>(&log);
            findings.0.extend(more);
            finished(K::name(&log).to_owned(), Some(facts), findings)
        }
        Err(errors) => {
            errors.iter().for_each(|error| advice::refusal(error, &mut findings));
            finished(dir.display().to_string(), None, findings)
        }
    }
}

fn finished(log: String, facts: Option<Facts>, mut findings: Findings) -> Report {
    findings.0.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Report { format: Format, log, facts, findings: findings.0 }
}

/// Checks the contents of a log, as before every replay.
pub fn log_of<K: Checked>(log: &K::Log) -> (Facts, Vec<Finding>) {
    let mut named = Vec::new();
    let sound = K::truth_only(log, &mut named);
    let (facts, findings) = sound_log_of::<K>(sound.as_ref().unwrap_or(log));
    named.extend(findings);
    (facts, named)
}

/// Checks the contents of a log without false rows in its truth.
fn sound_log_of<K: Checked>(log: &K::Log) -> (Facts, Vec<Finding>) {
    let Detail { motion, reach_m, simulated, out_of_view, mut findings } = K::in_detail(log);
    let mut facts = Facts { detections_out_of_view: out_of_view, ..Facts::of::<K>(log, &motion) };
    clock::look_over::<K>(log, &motion, reach_m, &mut findings);
    detections::look_over::<K>(log, &mut findings);
    way::speeds(&motion, simulated, &mut findings);
    let is_spiked = spike::look_over(&motion, reach_m, &mut findings);
    if is_spiked {
        // A spike of the odometry displaces the vehicle between two scans: findings about the clock are not reliable.
        findings.0.retain(|finding| !matches!(finding.code, "clock-shift" | "carried-away"));
    }
    facts.way_m = way::driven(&motion, K::scans(log).last().map_or(f64::NEG_INFINITY, |scan| scan.t_s));
    way::whole_turns::<K>(log, &mut findings);
    // Settings that fit the log never make its odometry unreadable; otherwise the replay reports it.
    if let Ok(reckoned) = K::dead_reckoning(log, &K::settings(log)) {
        let mut beside = Findings::default();
        facts.dead_reckoning_rmse_m = way::beside_truth::<K>(log, &reckoned, reach_m, facts.way_m, &mut beside);
        // A spike displaces dead reckoning: findings about units and signs are not reliable.
        if !is_spiked {
            findings.0.extend(beside.0);
        }
    }
    (facts, findings.0)
}
