//! The white part of the measurement noise, from a log's successive scans.

use super::moving_objects::first_after;
use crate::settings::VehicleSettings;
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Nominal, Scan, Sensor};
use scphd_log::vehicle::Way;
use std::f64::consts::SQRT_2;

/// Median of χ² with one degree of freedom.
const MEDIAN: f64 = 0.4549;
/// Detections whose differences are together above this many standard deviations are of different objects.
const GATE: f64 = 5.0;
/// Time after which an object that stands is detected at its place again, s.
const STANDS_S: f64 = 1.0;
/// Least number of pairs of detections.
const LEAST_PAIRS: usize = 100;
/// Greatest number of compared pairs of detections in all scans; of longer logs every n-th scan counts.
pub(super) const MOST_COMPARED: usize = 10_000_000;
/// Least number of pairs in a scan from which their common error of the bearing, which is odometry's, is estimated.
const LEAST_COMMON: usize = 3;

/// Rounds in which pairs are found anew with the noise of the last round, if it is greater.
const ROUNDS: usize = 4;
/// Greatest white part of the variance, relative to the stated one, of which the log's noise is taken as stated: odometry adds to it.
pub(super) const AS_STATED: f64 = 1.5;

/// The white part of the variances of range and bearing of one sensor, relative to the stated ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WhitePart {
    /// Including errors of odometry between two scans.
    pub(super) shares: [f64; 2],
    /// What the stated or usual noise of odometry, with errors that last from one scan to the next, contributes to them.
    pub(super) of_odometry: [f64; 2],
}

impl WhitePart {
    /// The white part for the sensor with this index; `None` if there are too few detections.
    ///
    /// This is the two-sample (Allan) variance. A detection is compared with that of the same object in the next scan, as expected
    /// from there by odometry. The difference of two independent errors has twice their variance; errors that last for many scans
    /// cancel. What is not detected at the same place a second later is not counted, since it may move. The median is insensitive to
    /// other false detections and outliers.
    pub(super) fn of(
        log: &Log,
        index: usize,
        sensor: &Sensor,
        nominal: &Nominal,
        vehicle: &VehicleSettings,
    ) -> Option<Self> {
        let (way, scans) = (Way::of(log), log.scans.iter().filter(|scan| scan.sensor == index).collect::<Vec<_>>());
        let part = |scale| Self::with(&way, &scans, sensor, nominal, vehicle, scale);
        let (mut scale, mut found) = ([1.0; 2], part([1.0; 2])?);
        for _ in 1..ROUNDS {
            let greater = found.shares.map(|share| if share > AS_STATED { share.sqrt() } else { 1.0 });
            if greater == [1.0; 2] {
                break;
            }
            scale = std::array::from_fn(|k| scale[k] * greater[k]);
            found = part(scale)?;
        }
        let stated = |shares: [f64; 2]| std::array::from_fn(|k| shares[k] * scale[k] * scale[k]);
        Some(Self { shares: stated(found.shares), of_odometry: stated(found.of_odometry) })
    }

    /// The same, relative to the stated standard deviations times `scale`, which also decide which detections are of one object.
    fn with(
        way: &Way<'_>,
        scans: &[&Scan],
        sensor: &Sensor,
        nominal: &Nominal,
        vehicle: &VehicleSettings,
        scale: [f64; 2],
    ) -> Option<Self> {
        let compared: usize = scans.windows(2).map(|two| two[0].detections.len() * two[1].detections.len()).sum();
        let (mut squares, mut of_odometry) = ([Vec::new(), Vec::new()], [0.0; 2]);
        for first in (0..scans.len().saturating_sub(1)).step_by(compared / MOST_COMPARED + 1) {
            let two = &scans[first..first + 2];
            let seat = |scan: &Scan| sensor.mounting.seat(way.at(scan.t_s));
            let [from, to] = [two[0], two[1]].map(seat);
            let sigmas = |range_m: f64| {
                let stated = nominal.sigmas_at(sensor, range_m);
                std::array::from_fn(|k| SQRT_2 * stated[k] * scale[k])
            };
            let later = first_after(scans, first, STANDS_S).map(|later| scans[later]);
            let stands = |&&z: &&[f64; 2]| {
                later.is_none_or(|later| {
                    let place = seen_from(seat(later), from, z);
                    later.detections.iter().any(|again| distance(&sigmas, &place, again) <= GATE * GATE)
                })
            };
            let expected: Vec<_> = two[0].detections.iter().filter(stands).map(|&z| seen_from(to, from, z)).collect();
            let pairs = matched(&sigmas, &expected, &two[1].detections);
            let count = pairs.len() as f64;
            // The variance of n differences about their own mean is smaller by 1 − 1/n.
            let (common, factor) = if pairs.len() < LEAST_COMMON {
                (0.0, 1.0)
            } else {
                (pairs.iter().map(|pair| pair.difference[1]).sum::<f64>() / count, count / (count - 1.0))
            };
            let dt_s = two[1].t_s - two[0].t_s;
            let way_m = libm::hypot(to[0] - from[0], to[1] - from[1]);
            let moved_m = vehicle.speed_sigma_mps * dt_s + vehicle.speed_sigma_ratio * way_m;
            for Pair { expected: [range_m, _], difference: [range, bearing] } in pairs {
                squares[0].push(range * range);
                squares[1].push((bearing - common) * (bearing - common) * factor);
                let of = sigmas(range_m);
                of_odometry[0] += (moved_m / of[0]).powi(2);
                of_odometry[1] += (moved_m / range_m / of[1]).powi(2);
            }
        }
        let pairs = squares[0].len();
        (pairs >= LEAST_PAIRS).then(|| Self {
            shares: squares.map(median_over_expected),
            of_odometry: of_odometry.map(|sum| sum / pairs as f64),
        })
    }
}

/// Range and bearing from the pose `to` of what is measured from the pose `from`.
pub(super) fn seen_from(to: [f64; 3], from: [f64; 3], [range, bearing]: [f64; 2]) -> [f64; 2] {
    let direction = from[2] + bearing;
    let ahead = [from[0] + range * libm::cos(direction) - to[0], from[1] + range * libm::sin(direction) - to[1]];
    [libm::hypot(ahead[0], ahead[1]), wrap(libm::atan2(ahead[1], ahead[0]) - to[2])]
}

/// A detection, as expected from the last scan, and one of the same object.
pub(super) struct Pair {
    pub(super) expected: [f64; 2],
    /// The differences of range and bearing, in standard deviations of a difference.
    pub(super) difference: [f64; 2],
}

/// The difference of a detection from what is expected. `sigmas` are the standard deviations of the differences at a range.
fn difference(sigmas: &impl Fn(f64) -> [f64; 2], of: &[f64; 2], z: &[f64; 2]) -> [f64; 2] {
    let [range_sigma_m, bearing_sigma_rad] = sigmas(of[0]);
    [(z[0] - of[0]) / range_sigma_m, wrap(z[1] - of[1]) / bearing_sigma_rad]
}

/// The squared length of that difference.
fn distance(sigmas: &impl Fn(f64) -> [f64; 2], of: &[f64; 2], z: &[f64; 2]) -> f64 {
    difference(sigmas, of, z).iter().map(|d| d * d).sum::<f64>()
}

/// The pairs of mutually nearest detections.
pub(super) fn matched(sigmas: &impl Fn(f64) -> [f64; 2], expected: &[[f64; 2]], detections: &[[f64; 2]]) -> Vec<Pair> {
    let distance = |of: &[f64; 2], z: &[f64; 2]| distance(sigmas, of, z);
    let nearest = |of: &[f64; 2]| detections.iter().min_by(|a, b| distance(of, a).total_cmp(&distance(of, b)));
    let mutual = |of: &[f64; 2], z: &[f64; 2]| expected.iter().all(|other| distance(other, z) >= distance(of, z));
    let pairs = expected.iter().filter_map(|of| Some((of, nearest(of)?)));
    let same = pairs.filter(|(of, z)| distance(of, z) <= GATE * GATE && mutual(of, z));
    same.map(|(of, z)| Pair { expected: *of, difference: difference(sigmas, of, z) }).collect()
}

/// The median of squares over that of normal variables with variance 1.
fn median_over_expected(mut squares: Vec<f64>) -> f64 {
    squares.sort_by(f64::total_cmp);
    squares[squares.len() / 2] / MEDIAN
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use scphd_worlds::scenario;
    use scphd_worlds::scenario::worlds::{self, Misbehaviour};

    fn part(log: &Log) -> Option<WhitePart> {
        let vehicle = Settings::for_log(log).vehicle;
        WhitePart::of(log, 0, &log.sensor, &log.nominal, &vehicle)
    }

    fn with_times_the_noise(log: &Log, factor: f64) -> Log {
        let mut log = log.clone();
        let Nominal { range_sigma_m, bearing_sigma_rad, .. } = &mut log.nominal;
        [range_sigma_m, bearing_sigma_rad].into_iter().flatten().for_each(|sigma| *sigma *= factor);
        log
    }

    #[test]
    fn independent_errors_are_white_with_the_stated_variance() {
        for seed in 0..4 {
            let WhitePart { shares: [range, bearing], .. } =
                part(&worlds::misbehaving(seed, Misbehaviour::NONE)).unwrap();
            // The errors of odometry between two scans add to those of the bearing.
            assert!((range - 1.0).abs() < 0.15 && (0.9..1.4).contains(&bearing), "{seed}: {range} {bearing}");
        }
    }

    /// Also if it is far greater than stated, so that the stated noise does not tell which detections are of one object.
    #[test]
    fn wrongly_stated_noise_is_measured() {
        let log = worlds::misbehaving(1, Misbehaviour::NONE);
        let right = part(&log).unwrap();
        for (factor, tolerance) in [(2.0, 0.08), (0.5, 0.1), (0.25, 0.1)] {
            let wrong = part(&with_times_the_noise(&log, factor)).unwrap();
            for k in 0..2 {
                let times = wrong.shares[k] / right.shares[k] * factor * factor;
                assert!((times - 1.0).abs() < tolerance, "{factor} {k}: {times}");
                let of_odometry = wrong.of_odometry[k] / right.of_odometry[k] * factor * factor;
                assert!((of_odometry - 1.0).abs() < tolerance, "{factor} {k}: {of_odometry}");
            }
        }
    }

    /// Between scans that are seconds apart, odometry explains the differences.
    #[test]
    fn errors_of_odometry_are_not_of_the_sensor() {
        let mut above = 0;
        for seed in 0..12 {
            let mut log = worlds::world(worlds::Kind::DataSheet, seed);
            log.scans = log.scans.iter().step_by(10).cloned().collect();
            let Some(WhitePart { shares, of_odometry }) = part(&log) else { continue };
            for k in 0..2 {
                above += usize::from(shares[k] > AS_STATED);
                assert!(shares[k] - of_odometry[k] <= AS_STATED, "{seed}: {shares:?} {of_odometry:?}");
            }
        }
        assert!(above > 5, "{above}");
    }

    #[test]
    fn moving_objects_hardly_change_it() {
        for seed in 0..12 {
            let [plain, moving] = [worlds::Kind::DataSheet, worlds::Kind::Moving]
                .map(|kind| part(&worlds::world(kind, seed)).unwrap().shares);
            for k in 0..2 {
                assert!((moving[k] / plain[k] - 1.0).abs() < 0.2, "{seed}: {plain:?} {moving:?}");
            }
        }
    }

    #[test]
    fn errors_that_last_are_not_white() {
        let mut log = scenario::survey(1);
        let first = log.scans[0].clone();
        log.scans.iter_mut().for_each(|scan| scan.detections.clone_from(&first.detections));
        log.odometry.iter_mut().for_each(|row| row.control = [0.0; 3]);
        assert!(part(&log).unwrap().shares.iter().all(|&share| share < 1e-20));
        log.scans.truncate(3);
        assert_eq!(part(&log), None);
    }
}
