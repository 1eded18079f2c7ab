//! Ranges that repeat to the last digit: what a sensor writes where nothing came back.

use super::finding::{Findings, percent};
use scphd_log::log::Log;
use std::collections::HashMap;

/// Noise does not repeat itself, but for the last digit that is written. A range is none if it comes so many times as often as any other,
const TIMES: usize = 10;
/// so often,
const REPEATED: usize = 20;
/// and in this share of the detections.
const SHARE: f64 = 0.005;

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
        counts.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
        let [(count, range_m), (second, _), ..] = counts[..] else { continue };
        let share = count as f64 / all as f64;
        if count < REPEATED || share < SHARE || count < TIMES * second {
            continue;
        }
        findings.warn(
            "no-return",
            "detections.csv, column range_m",
            format!(
                "{} of the detections have a range of {range_m} m to the last digit, the next most frequent range comes {second} times: this is \
                 what the sensor writes where nothing came back",
                percent(share)
            ),
            format!(
                "leave them out: no_return_m = {range_m:?} in log.toml, section {}",
                if name.is_empty() { "[sensor]".to_owned() } else { format!("[[sensors]] of {name}") }
            ),
        );
    }
}
