//! Ranges that repeat to the last digit: a sensor writes them when nothing was reflected.

use super::finding::{Findings, percent};
use scphd_log::log::Log;
use std::collections::HashMap;

/// Noise does not repeat exactly, except by rounding. Ranges are no measurements if each is at least this many times as frequent
/// as any other,
const TIMES: usize = 10;
/// occurs at least this number of times,
const REPEATED: usize = 20;
/// and together they have at least this share of the detections.
const SHARE: f64 = 0.005;
/// Greatest number of such ranges of a sensor: a greatest range, which rounding splits, and one below the least.
const VALUES: usize = 4;

pub(super) fn look_over(log: &Log, findings: &mut Findings) {
    for (sensor, (name, ..)) in log.sensors().enumerate() {
        let scans = log.scans.iter().filter(|scan| scan.sensor == sensor);
        let mut counts: HashMap<u64, usize> = HashMap::new();
        for [range_m, _] in scans.flat_map(|scan| &scan.detections) {
            *counts.entry(range_m.to_bits()).or_default() += 1;
        }
        let all: usize = counts.values().sum();
        let mut counts: Vec<(usize, f64)> =
            counts.into_iter().map(|(bits, count)| (count, f64::from_bits(bits))).collect();
        counts.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)));
        let is_last = |place: &usize| {
            let next = counts.get(place + 1).map_or(0, |one| one.0);
            counts[*place].0 >= REPEATED.max(TIMES * next) && next > 0
        };
        let Some(last) = (0..counts.len().min(VALUES)).find(is_last) else { continue };
        let (none, others) = counts.split_at(last + 1);
        let share = none.iter().map(|one| one.0).sum::<usize>() as f64 / all as f64;
        if share < SHARE {
            continue;
        }
        let mut ranges: Vec<f64> = none.iter().map(|one| one.1).collect();
        ranges.sort_by(f64::total_cmp);
        findings.warn(
            "no-return",
            "detections.csv, column range_m",
            what(&ranges, share, others),
            advice(&ranges, name),
        );
    }
}

fn what(ranges: &[f64], share: f64, others: &[(usize, f64)]) -> String {
    let second = others.first().map_or(0, |one| one.0);
    let written: Vec<String> = ranges.iter().map(|range_m| format!("{range_m} m")).collect();
    format!(
        "{} of the detections have a range of {} to the last digit, the next most frequent range comes {second} times: this is what the sensor \
         writes where nothing came back",
        percent(share),
        written.join(" or ")
    )
}

fn advice(ranges: &[f64], name: &str) -> String {
    if let [range_m] = ranges {
        let section = if name.is_empty() { "[sensor]".to_owned() } else { format!("[[sensors]] of {name}") };
        return format!("leave them out: no_return_m = {range_m:?} in log.toml, section {section}");
    }
    let (key, section) =
        if name.is_empty() { ("sensor", String::new()) } else { ("sensors", format!(", below the section of {name}")) };
    let zone = |range_m: &f64| format!("[[{key}.exclude]] range_min_m = {range_m:?}, range_max_m = {range_m:?}");
    let zones: Vec<String> = ranges.iter().map(zone).collect();
    format!("leave them out (one key a line in log.toml{section}): {}", zones.join("; "))
}
