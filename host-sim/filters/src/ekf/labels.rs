//! The labels of the log for detections of static landmarks, as far as they are right.

use libm::{cos, sin};
use scphd_log::log::{Log, Scan};
use scphd_log::truth;
use std::collections::{BTreeMap, BTreeSet};

/// Least distance, m, of a detection's true position from the median of its label at which it is not of the landmark: this
/// constant, for errors of truth and clocks, plus this number of standard deviations of the measurement. The label is then wrong,
/// or its object has moved.
const APART_M: f64 = 0.5;
const APART_SIGMAS: f64 = 5.0;
/// Share of such detections above which the object of a label moves.
const MOVES_SHARE: f64 = 0.2;

/// The label of every detection of a static landmark; `None` if the log has no labels.
///
/// The association is given, so the truth may be used for it too: with labels of a robot, or of a landmark that is not there, the
/// filter would be worse than one that has to find the associations.
pub(super) fn of(log: &Log) -> Option<Vec<Vec<Option<i64>>>> {
    let labelled = log.scans.iter().any(|scan| !scan.labels.is_empty());
    if !labelled {
        return None;
    }
    let listed: BTreeSet<i64> = log.moving.iter().map(|row| row.subject).collect();
    let is_static = |label: &i64| *label >= 0 && !listed.contains(label);
    let mut all: Vec<Vec<Option<i64>>> =
        log.scans.iter().map(|scan| scan.labels.iter().map(|label| Some(*label).filter(is_static)).collect()).collect();
    for places in by_label(log, &all).values() {
        let middle = middle(places);
        let far = places.iter().filter(|seen| seen.is_far_from(middle)).count();
        let moves = far as f64 > MOVES_SHARE * places.len() as f64;
        for seen in places.iter().filter(|seen| moves || seen.is_far_from(middle)) {
            all[seen.scan][seen.detection] = None;
        }
    }
    Some(all)
}

/// The true position of a detection.
struct Seen {
    scan: usize,
    detection: usize,
    place: [f64; 2],
    /// Standard deviation of the measurement at this position, m.
    sigma_m: f64,
}

impl Seen {
    fn is_far_from(&self, [x, y]: [f64; 2]) -> bool {
        libm::hypot(self.place[0] - x, self.place[1] - y) > APART_M + APART_SIGMAS * self.sigma_m
    }
}

/// The detections of every label whose true position is known.
fn by_label(log: &Log, labels: &[Vec<Option<i64>>]) -> BTreeMap<i64, Vec<Seen>> {
    let sensors: Vec<_> = log.sensors().collect();
    let mut all: BTreeMap<i64, Vec<Seen>> = BTreeMap::new();
    for (scan, (Scan { t_s, sensor, detections, .. }, labels)) in log.scans.iter().zip(labels).enumerate() {
        let Some(true_pose) = truth::at(&log.truth, *t_s) else { continue };
        let (Some(heading), Some((_, sensor, nominal))) = (true_pose.heading_rad, sensors.get(*sensor)) else {
            continue;
        };
        let [x, y] = true_pose.position;
        let [x, y, heading] = sensor.mounting.seat([x, y, heading]);
        for (detection, (&[range, bearing], label)) in detections.iter().zip(labels).enumerate() {
            let Some(label) = label else { continue };
            let [range_sigma, bearing_sigma] = nominal.sigmas_at(sensor, range);
            let place = [x + range * cos(heading + bearing), y + range * sin(heading + bearing)];
            let sigma_m = libm::hypot(range_sigma, range * bearing_sigma);
            all.entry(*label).or_default().push(Seen { scan, detection, place, sigma_m });
        }
    }
    all
}

/// The median of each coordinate.
fn middle(places: &[Seen]) -> [f64; 2] {
    [0, 1].map(|k| {
        let mut numbers: Vec<f64> = places.iter().map(|seen| seen.place[k]).collect();
        numbers.sort_by(f64::total_cmp);
        numbers.get(numbers.len() / 2).copied().unwrap_or(f64::NAN)
    })
}
