//! The white part of the measurement noise, from a log's successive scans.

use scphd_log::angle::wrap;
use scphd_log::log::{Log, Nominal, Scan, Sensor};
use scphd_log::vehicle::Way;
use std::f64::consts::SQRT_2;

/// Median of χ² with one degree of freedom.
const MEDIAN: f64 = 0.4549;
/// Detections whose differences are together above this many standard deviations are of different objects.
const GATE: f64 = 5.0;
/// Least number of pairs of detections.
const LEAST_PAIRS: usize = 100;
/// Greatest number of compared pairs of detections in all scans; of longer logs every n-th scan counts.
const MOST_COMPARED: usize = 10_000_000;
/// Least number of pairs in a scan from which their common error of the bearing, which is odometry's, is estimated.
const LEAST_COMMON: usize = 3;

/// The white part of the variances of range and bearing, relative to the stated ones, for one sensor of `log`; `None` if there
/// are too few detections.
///
/// This is the two-sample (Allan) variance. A detection is compared with that of the same object in the next scan, as expected
/// from there by odometry. The difference of two independent errors has twice their variance; errors that last for many scans
/// cancel. The median is insensitive to moving objects, false detections and outliers.
pub(super) fn white_shares(log: &Log, index: usize, sensor: &Sensor, nominal: &Nominal) -> Option<[f64; 2]> {
    let way = Way::of(log);
    let scans: Vec<&Scan> = log.scans.iter().filter(|scan| scan.sensor == index).collect();
    let compared: usize = scans.windows(2).map(|two| two[0].detections.len() * two[1].detections.len()).sum();
    let mut squares = [Vec::new(), Vec::new()];
    for two in scans.windows(2).step_by(compared / MOST_COMPARED + 1) {
        let [from, to] = [two[0], two[1]].map(|scan| sensor.mounting.seat(way.at(scan.t_s)));
        let expected: Vec<_> = two[0].detections.iter().map(|&z| seen_from(to, from, z)).collect();
        let differences = matched(sensor, nominal, &expected, &two[1].detections);
        let count = differences.len() as f64;
        // The variance of n differences about their own mean is smaller by 1 − 1/n.
        let (common, factor) = if differences.len() < LEAST_COMMON {
            (0.0, 1.0)
        } else {
            (differences.iter().map(|d| d[1]).sum::<f64>() / count, count / (count - 1.0))
        };
        squares[0].extend(differences.iter().map(|d| d[0] * d[0]));
        squares[1].extend(differences.iter().map(|d| (d[1] - common) * (d[1] - common) * factor));
    }
    (squares[0].len() >= LEAST_PAIRS).then(|| squares.map(median_over_expected))
}

/// Range and bearing from the pose `to` of what is measured from the pose `from`.
fn seen_from(to: [f64; 3], from: [f64; 3], [range, bearing]: [f64; 2]) -> [f64; 2] {
    let direction = from[2] + bearing;
    let ahead = [from[0] + range * libm::cos(direction) - to[0], from[1] + range * libm::sin(direction) - to[1]];
    [libm::hypot(ahead[0], ahead[1]), wrap(libm::atan2(ahead[1], ahead[0]) - to[2])]
}

/// The differences of range and bearing between mutually nearest detections, in standard deviations of a difference.
fn matched(sensor: &Sensor, nominal: &Nominal, expected: &[[f64; 2]], detections: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let difference = |of: &[f64; 2], z: &[f64; 2]| {
        let [range_sigma_m, bearing_sigma_rad] = nominal.sigmas_at(sensor, of[0]);
        [(z[0] - of[0]) / (SQRT_2 * range_sigma_m), wrap(z[1] - of[1]) / (SQRT_2 * bearing_sigma_rad)]
    };
    let distance = |of: &[f64; 2], z: &[f64; 2]| difference(of, z).iter().map(|d| d * d).sum::<f64>();
    let nearest = |of: &[f64; 2]| detections.iter().min_by(|a, b| distance(of, a).total_cmp(&distance(of, b)));
    let mutual = |of: &[f64; 2], z: &[f64; 2]| expected.iter().all(|other| distance(other, z) >= distance(of, z));
    let pairs = expected.iter().filter_map(|of| Some((of, nearest(of)?)));
    let same = pairs.filter(|(of, z)| distance(of, z) <= GATE * GATE && mutual(of, z));
    same.map(|(of, z)| difference(of, z)).collect()
}

/// The median of squares over that of normal variables with variance 1.
fn median_over_expected(mut squares: Vec<f64>) -> f64 {
    squares.sort_by(f64::total_cmp);
    squares[squares.len() / 2] / MEDIAN
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_worlds::scenario;
    use scphd_worlds::scenario::worlds::{self, Misbehaviour};

    fn shares(log: &Log) -> [f64; 2] {
        white_shares(log, 0, &log.sensor, &log.nominal).unwrap()
    }

    #[test]
    fn independent_errors_are_white_with_the_stated_variance() {
        for seed in 0..4 {
            let [range, bearing] = shares(&worlds::misbehaving(seed, Misbehaviour::NONE));
            // The errors of odometry between two scans add to those of the bearing.
            assert!((range - 1.0).abs() < 0.15 && (0.9..1.4).contains(&bearing), "{seed}: {range} {bearing}");
        }
    }

    #[test]
    fn twice_the_stated_noise_has_a_quarter_of_its_variance() {
        let mut log = worlds::misbehaving(1, Misbehaviour::NONE);
        let before = shares(&log);
        let nominal = &mut log.nominal;
        (nominal.range_sigma_m, nominal.bearing_sigma_rad) =
            (nominal.range_sigma_m.map(|sigma| 2.0 * sigma), nominal.bearing_sigma_rad.map(|sigma| 2.0 * sigma));
        let ratio = shares(&log)[0] / before[0];
        assert!((ratio - 0.25).abs() < 0.03, "{ratio}");
    }

    #[test]
    fn errors_that_last_are_not_white() {
        let mut log = scenario::survey(1);
        let first = log.scans[0].clone();
        log.scans.iter_mut().for_each(|scan| scan.detections.clone_from(&first.detections));
        log.odometry.iter_mut().for_each(|row| row.control = [0.0; 3]);
        assert!(shares(&log).iter().all(|&share| share < 1e-20));
        log.scans.truncate(3);
        assert_eq!(white_shares(&log, 0, &log.sensor, &log.nominal), None);
    }
}
