//! Advice for a folder that cannot be read.

use super::finding::{Finding, Findings, Severity};
use scphd_log::log_folder::{LogError, Place, Problem};

pub(super) const EMPTY: &str = "write its rows, or of a file that may be absent take the file away; scphd-sim export survey DIR writes a log to look at";

/// Adds the reason why the folder cannot be read, unless the checks of its files have already reported it.
pub(super) fn refusal(error: &LogError, findings: &mut Findings) {
    let place = error.place.to_string();
    let file = |place: &str| place.split(',').next().map(str::to_owned);
    let told = |finding: &Finding| {
        finding.severity == Severity::Error
            && (finding.place == place
                || (matches!(finding.code, "separator" | "comment") && file(&place) == file(&finding.place)))
    };
    let encoding = |finding: &Finding| finding.code == "encoding" && finding.place == place;
    if findings.0.iter().any(|finding| told(finding) || encoding(finding)) {
        return;
    }
    findings.add(Severity::Error, code(error), place, error.problem.to_string(), advice(error));
}

fn code(error: &LogError) -> &'static str {
    match &error.problem {
        Problem::Missing => "missing",
        Problem::Empty => "file-empty",
        Problem::FarApart { .. } => "time-unit",
        Problem::NotRadians { .. } => "angle-unit",
        Problem::OutOfReach { .. } => "range-unit",
        Problem::DrivesTooFar { .. } => "way-unit",
        Problem::OtherClock { .. }
        | Problem::LateOdometry { .. }
        | Problem::LateFixes { .. }
        | Problem::EarlyFix { .. } => "other-clock",
        Problem::Backwards { .. } | Problem::ScanOrder { .. } => "order",
        Problem::NotText => "encoding",
        _ => "unreadable",
    }
}

fn advice(error: &LogError) -> String {
    let text = match &error.problem {
        Problem::Missing => match error.place {
            Place::Folder(_) => "name the folder of a log; scphd-sim export survey DIR writes one to look at",
            Place::Key(_) => "write the key; scphd-sim export survey DIR writes a log.toml to look at",
            _ => "write it; scphd-sim export survey DIR writes a log to look at",
        },
        Problem::Empty => EMPTY,
        Problem::FarApart { unit, .. } => match *unit {
            "milliseconds" => "divide all times, of every file, by 1e3",
            "microseconds" => "divide all times, of every file, by 1e6",
            "nanoseconds" => "divide all times, of every file, by 1e9",
            _ => "write all times, of every file, in seconds",
        },
        Problem::NotRadians { degrees: true, .. } => "multiply the whole column, or key, by 0.0174533",
        Problem::NotRadians { .. } => "write angles between -3.1416 and 3.1416 rad",
        Problem::OutOfReach { .. } => {
            "divide ranges in millimetres by 1000, in centimetres by 100; if they are in metres, range_max_m is too small"
        }
        Problem::DrivesTooFar { .. } => {
            "divide speeds in mm/s by 1000, in km/h by 3.6, times in ms by 1e3; if all are right, write scans more often"
        }
        Problem::OtherClock { .. }
        | Problem::LateOdometry { .. }
        | Problem::LateFixes { .. }
        | Problem::EarlyFix { .. } => "give all files the same clock, in seconds",
        Problem::Backwards { .. } => "sort the rows by time; if a clock was set in the drive, cut the log there",
        Problem::ScanOrder { .. } => {
            "number the scans upwards in order of time, and sort detections.csv by scan; write no scan twice"
        }
        Problem::NoSuchScan(_) => "write every scan that has detections into scans.csv",
        Problem::NotText => "save the file as UTF-8",
        Problem::Fields { .. } => "write points, not commas, in numbers, and as many fields as the header has",
        Problem::TooLarge(_) => "leave the detection out: no sensor measures that",
        Problem::NotFinite(_) => "write a number with a point; leave out rows that have none",
        Problem::NegativeRange(_) => {
            "leave the detection out; if many are negative, the columns are exchanged, or hold x and y instead of range and bearing"
        }
        Problem::Unknown { .. } | Problem::Unused { .. } => "mend the name of the key, or leave it out",
        _ => "mend it, and check again",
    };
    text.to_owned()
}
