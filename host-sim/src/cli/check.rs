//! `scphd-sim check`, and the check before a replay.

use super::args::CheckArgs;
use super::failure::{Failure, notice, print, warning};
use super::outputs::check_file;
use scphd_check as check;
use scphd_check::{Facts, Finding, Report, Severity};
use scphd_score::results::sink;
use std::path::Path;

/// Checks folders and prints the findings. Fails if one of them cannot be read.
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    if let Some(path) = &args.json {
        check_file("--json", path)?;
    }
    let reports: Vec<Report> = args.dirs.iter().map(|dir| check::folder(dir)).collect();
    if let Some(path) = &args.json {
        check::write(path, &reports)?;
    }
    for (dir, report) in args.dirs.iter().zip(&reports) {
        match args.json.as_deref() {
            Some(file) if sink::is_stdout(file) => notice(told(dir, report)),
            _ => print(&told(dir, report))?,
        }
    }
    let bad =
        |report: &&Report| report.count(Severity::Error) > 0 || (args.strict && report.count(Severity::Warning) > 0);
    match reports.iter().filter(bad).count() {
        0 => Ok(()),
        bad => Err(Failure::input(format_args!("{bad} of {} logs are not as they should be", reports.len()))),
    }
}

/// Prints the warnings of the quick check before a replay.
pub fn warn<K: check::Checked>(log: &K::Log) {
    let (_, findings) = check::log_of::<K>(log);
    for Finding { code, place, what, advice, .. } in findings.iter().filter(|one| one.severity == Severity::Warning) {
        warning(format_args!("warning: {}: {place}: {what}; {advice} [{code}]", K::name(log)));
    }
}

fn told(dir: &Path, report: &Report) -> String {
    let folder = dir.display().to_string();
    // If the name of a log cannot be read, it is that of the folder.
    let mut lines = vec![if report.log == folder { folder } else { format!("{} ({folder})", report.log) }];
    lines.extend(report.facts.iter().flat_map(figures));
    for Finding { severity, code, place, what, advice } in &report.findings {
        lines.push(format!("{}: {place}: {what} [{code}]", severity.name()));
        lines.push(format!("    do: {advice}"));
    }
    let count = |severity| report.count(severity);
    lines.push(match report.findings.len() {
        0 => "nothing found".to_owned(),
        _ => format!(
            "{} errors, {} warnings, {} notes",
            count(Severity::Error),
            count(Severity::Warning),
            count(Severity::Note)
        ),
    });
    lines.join("\n")
}

fn figures(facts: &Facts) -> Vec<String> {
    let number =
        |value: Option<f64>, unit: &str| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3} {unit}"));
    let Facts { scans, detections, empty_scans, odometry_rows, scans_with_truth, .. } = *facts;
    vec![
        format!(
            "  {scans} scans in {:.1} s, {} apart in the median; {detections} detections, {empty_scans} scans without any",
            facts.duration_s,
            number(facts.scan_interval_s, "s")
        ),
        format!(
            "  out of the stated view: {}",
            number(facts.detections_out_of_view.map(|share| 100.0 * share), "% of the detections")
        ),
        format!(
            "  {odometry_rows} rows of odometry, {} apart in the median, {} at most; way {}",
            number(facts.odometry_interval_s, "s"),
            number(facts.odometry_gap_s, "s"),
            number(facts.way_m, "m")
        ),
        format!(
            "  truth at {scans_with_truth} scans; dead reckoning is {} off (RMSE)",
            number(facts.dead_reckoning_rmse_m, "m")
        ),
    ]
}
