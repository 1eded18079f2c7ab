//! Whether a log says what its author means: units, clocks, doubled scans, views, dead reckoning beside the truth.
//!
//! The reader of folders ([`crate::log_folder`]) refuses what no vehicle and no sensor can do. What it reads may still be wrong: a turn rate in
//! degrees a second, bearings that grow to the right, scans written twice. Each [`Finding`] says where, what, with its figures, and what
//! to do. `docs/check.md` lists all, with their thresholds. A threshold is the bound of what a vehicle or a sensor does, or compares two readings of the
//! same log; none was fitted to a log.

mod advice;
mod agreement;
mod clock;
mod facts;
mod files;
mod space;
mod view;
mod way;

pub use facts::Facts;

use crate::dimensions::{Planar, Underwater};
use crate::kind::Kind;
use crate::log::{Log, Vehicle};
use crate::log_folder::{self, LogError};
use crate::output::json::Format;
use crate::settings::Settings;
use crate::underwater;
use serde::Serialize;
use std::path::Path;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Read as it is; nothing has to be done.
    Note,
    /// The log can be run, and what comes of it is probably wrong.
    Warning,
    /// The log cannot be read.
    Error,
}

impl Severity {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// Something about a log that its author should know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// A name that stays from release to release.
    pub code: &'static str,
    /// File, and row, column or key where there is one.
    pub place: String,
    /// What is found, with its figures.
    pub what: String,
    /// What to do.
    pub advice: String,
}

/// What a check leaves behind; serialised as it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The format of the keys.
    pub format: Format,
    /// The name of the log; the folder's where the log cannot be read.
    pub log: String,
    /// What was measured; `None` where the log cannot be read.
    pub facts: Option<Facts>,
    /// What is found, the worst first.
    pub findings: Vec<Finding>,
}

impl Report {
    /// How many findings are so bad.
    #[must_use]
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }
}

/// Findings as they come up.
#[derive(Debug, Default)]
struct Findings(Vec<Finding>);

impl Findings {
    fn add(
        &mut self,
        severity: Severity,
        code: &'static str,
        place: impl Into<String>,
        what: String,
        advice: impl Into<String>,
    ) {
        self.0.push(Finding { severity, code, place: place.into(), what, advice: advice.into() });
    }

    fn warn(&mut self, code: &'static str, place: &str, what: String, advice: impl Into<String>) {
        self.add(Severity::Warning, code, place, what, advice);
    }

    fn note(&mut self, code: &'static str, place: &str, what: String, advice: impl Into<String>) {
        self.add(Severity::Note, code, place, what, advice);
    }
}

/// Motion in force from a time on, whatever the vehicle.
#[derive(Debug, Clone, Copy)]
struct Motion {
    t_s: f64,
    /// Without sign, m/s; `None` where nothing was measured.
    speed_mps: Option<f64>,
    turn_radps: f64,
}

/// What a check has to know of a kind of vehicle.
pub trait Checked: Kind {
    /// Reads a folder.
    ///
    /// # Errors
    /// The first thing wrong with the folder.
    fn read(dir: &Path) -> Result<Self::Log, LogError>;

    /// Settings that fit the log.
    fn settings(log: &Self::Log) -> Self::Settings;

    #[doc(hidden)]
    fn in_detail(log: &Self::Log) -> Detail;
}

/// What is looked at in a way of its own for each kind.
#[doc(hidden)]
#[derive(Debug)]
pub struct Detail {
    motion: Vec<Motion>,
    /// How far the sensors see, m.
    reach_m: f64,
    simulated: bool,
    out_of_view: Option<f64>,
    findings: Findings,
}

impl Checked for Planar {
    fn read(dir: &Path) -> Result<Log, LogError> {
        log_folder::read(dir)
    }

    fn settings(log: &Log) -> Settings {
        Settings::for_log(log)
    }

    fn in_detail(log: &Log) -> Detail {
        let turn = |[speed, second]: [f64; 2]| match log.vehicle {
            Vehicle::Ackermann { wheelbase_m, .. } => speed * libm::tan(second) / wheelbase_m,
            Vehicle::Unicycle | Vehicle::UnicycleArc => second,
        };
        let motion = log.odometry.iter().map(|row| Motion {
            t_s: row.t_s,
            speed_mps: Some(row.control[0].abs()),
            turn_radps: turn(row.control),
        });
        let mut findings = Findings::default();
        let out_of_view = view::planar(log, &mut findings);
        agreement::planar(log, &mut findings);
        let reach_m = log.sensors().map(|(_, sensor, _)| sensor.range_max_m).fold(0.0, f64::max);
        Detail { motion: motion.collect(), reach_m, simulated: log.simulated, out_of_view, findings }
    }
}

impl Checked for Underwater {
    fn read(dir: &Path) -> Result<underwater::log::Log, LogError> {
        log_folder::read_underwater(dir)
    }

    fn settings(log: &underwater::log::Log) -> underwater::settings::Settings {
        underwater::settings::Settings::for_real_log(log)
    }

    fn in_detail(log: &underwater::log::Log) -> Detail {
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

/// Checks a folder: its files as they are written, then what they say.
#[must_use]
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
        Err(error) => {
            advice::refusal(&error, &mut findings);
            finished(dir.display().to_string(), None, findings)
        }
    }
}

fn finished(log: String, facts: Option<Facts>, mut findings: Findings) -> Report {
    findings.0.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Report { format: Format, log, facts, findings: findings.0 }
}

/// Checks what a log says: the part that runs before every replay.
#[must_use]
pub fn log_of<K: Checked>(log: &K::Log) -> (Facts, Vec<Finding>) {
    let Detail { motion, reach_m, simulated, out_of_view, mut findings } = K::in_detail(log);
    let mut facts = Facts { detections_out_of_view: out_of_view, ..Facts::of::<K>(log, &motion) };
    clock::look_over::<K>(log, &motion, reach_m, &mut findings);
    way::look_over::<K>(log, &motion, (reach_m, simulated), &mut facts, &mut findings);
    (facts, findings.0)
}

/// The number that a share of all numbers stays under; `None` of none.
fn quantile(mut numbers: Vec<f64>, share: f64) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    numbers.get(((last as f64) * share).round() as usize).copied()
}

/// A number with three digits that count.
fn short(number: f64) -> String {
    let size = if number == 0.0 { 0.0 } else { number.abs().log10().floor() };
    if !(-4.0..6.0).contains(&size) {
        return format!("{number:.2e}");
    }
    format!("{number:.*}", (2.0 - size).max(0.0) as usize)
}

/// A share as a percentage.
fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}
