//! The noise of odometry, from what the detections of two scans tell of the motion between them.

use super::VehicleSettings;
use super::defaults::turn_rate_variance;
use super::moving_objects::first_after;
use super::white::{MOST_COMPARED, Pair, matched, seen_from};
use nalgebra::{Matrix2x3, Matrix3, Vector3};
use scphd_log::log::{Log, Mounting, Odometry, Scan};
use scphd_log::vehicle::Way;

/// Time between two scans, s: in it odometry's errors exceed the sensor's, those that last add up, and landmarks stay in view.
const APART_S: f64 = 4.0;
/// Greatest time between two scans, relative to that asked.
const AT_MOST: f64 = 3.0;
/// Least number of detections of the same landmarks in both scans.
const LEAST_PAIRS: usize = 3;
/// Fits to the detections of two scans.
const ROUNDS: usize = 3;
/// Greatest counted square of an error relative to its variance, and the mean of χ² with one degree of freedom that is cut there.
const GREATEST: f64 = 9.0;
const MEAN: f64 = 0.9944;
/// Factor for the measured variance, since some errors last longer than the time between the scans.
const MARGIN: f64 = 1.2;
/// Number of measured errors that count as much as the default.
const DEFAULT_COUNTS: f64 = 3.0;
/// Duration of a motion whose change of heading gives the turn rate, s.
const STEP_S: f64 = 1e-3;
/// Least correlation time that the measured variance may amount to, s.
const LEAST_S: f64 = 0.02;

/// The error of odometry between two scans in one coordinate.
struct Error {
    square: f64,
    /// Its variance by the noise of the sensor, and for the heading by that of the speed.
    of_sensor: f64,
    /// Its variance by the noise of odometry, for a correlation time of 1 s.
    of_odometry: f64,
    /// Time from the scan before the first one, s.
    since_s: f64,
}

/// The correlation times of the errors of speed and turn, s, with which the settings' standard deviations have the measured effect;
/// not more than that of the settings, since false detections add to what is measured.
/// `sigmas` are the standard deviations of range and bearing of each sensor at a range.
pub(super) fn correlation_times(
    log: &Log,
    vehicle: &VehicleSettings,
    sigmas: impl Fn(usize, f64) -> [f64; 2],
) -> [f64; 2] {
    let way = Way::of(log);
    let variances = Variances::of(log, vehicle);
    let (mut errors, mut by_speed) = ([Vec::new(), Vec::new()], Vec::new());
    for (index, (_, sensor, _)) in log.sensors().enumerate() {
        let scans: Vec<_> = log.scans.iter().filter(|scan| scan.sensor == index).collect();
        let later = |first: usize| {
            let later = first_after(&scans, first, APART_S)?;
            (scans[later].t_s <= scans[first].t_s + AT_MOST * APART_S).then_some([first, later])
        };
        let pairs: Vec<_> = (0..scans.len()).filter_map(later).collect();
        let compared: usize =
            pairs.iter().map(|pair| pair.map(|scan| scans[scan].detections.len())).map(|[a, b]| a * b).sum();
        let mut before_s = f64::NEG_INFINITY;
        for pair in pairs.into_iter().step_by(compared / MOST_COMPARED + 1) {
            let [first, second] = pair.map(|scan| scans[scan]);
            let since_s = (first.t_s - before_s).min(APART_S);
            before_s = first.t_s;
            let of_odometry = variances.between(first.t_s, second.t_s);
            let [way_m2, by_turn, of_speed] = of_odometry.map(|variance| variance * vehicle.noise_interval_s);
            let noise = [way_m2, by_turn + of_speed];
            let sigmas = |range_m| sigmas(index, range_m);
            let Some(found) = motion_error(&way, [first, second], &sensor.mounting, noise, sigmas) else { continue };
            for (k, (square, of_sensor)) in found.into_iter().enumerate() {
                errors[k].push(Error { square, of_sensor, of_odometry: of_odometry[k], since_s });
            }
            by_speed.push(of_odometry[2]);
        }
    }
    let [of_speed, mut of_turn] = errors;
    let speed_s = correlation_time(&of_speed, vehicle.noise_interval_s);
    for (error, by_speed) in of_turn.iter_mut().zip(by_speed) {
        error.of_sensor += speed_s * by_speed;
    }
    [speed_s, correlation_time(&of_turn, vehicle.noise_interval_s)]
}

/// The squared error of odometry ahead, m², and of the heading, rad², between two scans, each with its variance by the noise of the
/// sensor: by a least squares fit to the differences of detections, which are matched anew with its result. `noise` are the variances of
/// way and heading by odometry.
fn motion_error(
    way: &Way<'_>,
    scans: [&Scan; 2],
    mounting: &Mounting,
    [ahead, turn]: [f64; 2],
    sigmas: impl Fn(f64) -> [f64; 2],
) -> Option<[(f64, f64); 2]> {
    let [start, end] = scans.map(|scan| way.at(scan.t_s));
    let from = mounting.seat(start);
    let length_m = libm::hypot(end[0] - start[0], end[1] - start[1]);
    // A turn at a random time moves the end of the way to the side.
    let mut place = ahead + length_m * length_m * turn / 3.0;
    let mut heading = turn;
    let of_sensor = |range_m: f64| sigmas(range_m).map(|sigma| 2.0 * sigma * sigma);
    let (mut error, mut covariance) = (Vector3::zeros(), Matrix3::zeros());
    for _ in 0..ROUNDS {
        let (s, c) = (libm::sin(end[2]), libm::cos(end[2]));
        let to = mounting.seat([
            end[0] + c * error[0] - s * error[1],
            end[1] + s * error[0] + c * error[1],
            end[2] + error[2],
        ]);
        let unit = |range_m: f64| {
            let [range, bearing] = of_sensor(range_m);
            [(range + place).sqrt(), (bearing + place / (range_m * range_m) + heading).sqrt()]
        };
        let expected: Vec<_> = scans[0].detections.iter().map(|&z| seen_from(to, from, z)).collect();
        let pairs = matched(&unit, &expected, &scans[1].detections);
        if pairs.len() < LEAST_PAIRS {
            return None;
        }
        let (mut information, mut weighted) = (Matrix3::zeros(), Vector3::zeros());
        for Pair { expected: [range, bearing], difference } in pairs {
            let (s, c) = (libm::sin(bearing + mounting.yaw_rad), libm::cos(bearing + mounting.yaw_rad));
            let (x, y) = (mounting.forward_m + range * c, mounting.left_m + range * s);
            // An error of the motion (ahead, to the left, turn) moves the place (x, y) in the vehicle's frame.
            let slope = -Matrix2x3::new(c, s, s * x - c * y, -s / range, c / range, (c * x + s * y) / range);
            let weights = of_sensor(range).map(f64::recip);
            for k in 0..2 {
                let row = slope.row(k);
                information += weights[k] * row.transpose() * row;
                weighted += weights[k] * unit(range)[k] * difference[k] * row.transpose();
            }
        }
        covariance = information.try_inverse()?;
        error += covariance * weighted;
        (place, heading) = (covariance[(0, 0)].max(covariance[(1, 1)]), covariance[(2, 2)]);
    }
    Some([0, 2].map(|k| (error[k] * error[k], covariance[(k, k)])))
}

/// The correlation time for which the squared errors are as expected in the mean. Errors that the sensor's noise hides count less, and
/// few errors less than the default.
fn correlation_time(errors: &[Error], default_s: f64) -> f64 {
    let variance = |error: &Error, time_s: f64| error.of_sensor + time_s * error.of_odometry;
    let weight = |error: &Error| (default_s * error.of_odometry / variance(error, default_s)).powi(2);
    let total: f64 = errors.iter().map(weight).sum();
    let count: f64 = errors.iter().map(|error| weight(error) * error.since_s / APART_S).sum();
    let are_greater = |time_s: f64| {
        let cut = |error: &Error| weight(error) * (error.square / variance(error, time_s)).min(GREATEST);
        errors.iter().map(cut).sum::<f64>() > MEAN * total
    };
    let (mut low, mut high) = (LEAST_S / MARGIN, default_s);
    for _ in 0..40 {
        let middle = (low * high).sqrt();
        if are_greater(middle) { low = middle } else { high = middle }
    }
    ((count * MARGIN * low + DEFAULT_COUNTS * default_s) / (count + DEFAULT_COUNTS)).min(default_s)
}

/// The variances by the noise of odometry since the first row, for a correlation time of 1 s.
struct Variances<'a> {
    rows: &'a [Odometry],
    /// Of the way, m²/s, and of the heading by errors of turn and of speed, rad²/s, in each row.
    rates: Vec<[f64; 3]>,
    /// At the begin of each row.
    sums: Vec<[f64; 3]>,
}

impl<'a> Variances<'a> {
    fn of(log: &'a Log, noise: &VehicleSettings) -> Self {
        let rate = |row: &Odometry| {
            let share = noise.speed_sigma_ratio * row.control[0];
            let of_speed = noise.speed_sigma_mps * noise.speed_sigma_mps + share * share;
            let [speed, turn, left] = row.control;
            let rate = |speed| log.vehicle.step([0.0; 3], [speed, turn, left], STEP_S)[2] / STEP_S;
            let by_speed = rate(speed + 0.5) - rate(speed - 0.5);
            [of_speed, turn_rate_variance(log.vehicle, row.control, noise), by_speed * by_speed * of_speed]
        };
        let rates: Vec<_> = log.odometry.iter().map(rate).collect();
        let mut sum = [0.0; 3];
        let ends = log.odometry.windows(2).zip(&rates).map(|(rows, rate)| {
            (0..3).for_each(|k| sum[k] += rate[k] * (rows[1].t_s - rows[0].t_s));
            sum
        });
        let sums = std::iter::once([0.0; 3]).chain(ends).collect();
        Self { rows: &log.odometry, rates, sums }
    }

    fn until(&self, t_s: f64) -> [f64; 3] {
        let Some(row) = self.rows.partition_point(|row| row.t_s <= t_s).checked_sub(1) else { return [0.0; 3] };
        std::array::from_fn(|k| self.sums[row][k] + self.rates[row][k] * (t_s - self.rows[row].t_s))
    }

    fn between(&self, from_s: f64, to_s: f64) -> [f64; 3] {
        let (from, to) = (self.until(from_s), self.until(to_s));
        [0, 1, 2].map(|k| to[k] - from[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use scphd_worlds::scenario::worlds::{self, Misbehaviour};

    const DEFAULT_S: f64 = 0.5;

    /// The standard deviations of speed, m/s, and turn, rad or rad/s: several times those of the world without these errors.
    fn sigmas(log: &Log) -> [f64; 2] {
        [0.02 * log.sensor.range_max_m, 0.03]
    }

    /// A drive with white errors of speed and turn.
    fn drive(seed: u64) -> Log {
        let mut log = worlds::misbehaving(seed, Misbehaviour::NONE);
        let sigmas = sigmas(&log);
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        for row in &mut log.odometry {
            for (control, sigma) in row.control.iter_mut().zip(sigmas) {
                bits ^= bits << 13;
                bits ^= bits >> 7;
                bits ^= bits << 17;
                *control += if bits >> 63 == 0 { sigma } else { -sigma };
            }
        }
        log
    }

    fn times(log: &Log) -> [f64; 2] {
        let Settings { mut vehicle, sensor, .. } = Settings::for_log(log);
        [vehicle.speed_sigma_mps, vehicle.turn_sigma] = sigmas(log);
        [vehicle.speed_sigma_ratio, vehicle.turn_sigma_ratio, vehicle.noise_interval_s] = [0.0, 0.0, DEFAULT_S];
        // The settings have 1.5 times the noise of a data sheet.
        let sigmas = |_, range_m| [sensor.range_sigma_at(range_m), sensor.bearing_sigma_rad].map(|sigma| sigma / 1.5);
        correlation_times(log, &vehicle, sigmas)
    }

    #[test]
    fn white_errors_last_for_one_row() {
        let of_rows = |seed| {
            let log = drive(seed);
            let row_s = log.odometry[1].t_s - log.odometry[0].t_s;
            times(&log).map(|time_s| time_s / (MARGIN * row_s))
        };
        let mut rows: Vec<f64> = (0..8).flat_map(of_rows).collect();
        rows.sort_by(f64::total_cmp);
        // The world has errors too, and where few landmarks are seen twice, the default, 4.2, adds to it.
        assert!(rows[0] > 0.7 && rows[8] < 1.7 && rows[15] < 3.0, "{rows:?}");
    }

    #[test]
    fn an_error_of_the_turn_rate_that_lasts_is_measured() {
        let mut log = drive(1);
        let [_, white] = times(&log);
        log.odometry.iter_mut().for_each(|row| row.control[1] += 0.03);
        let [_, lasting] = times(&log);
        assert!(lasting > 1.5 * white, "{lasting} {white}");
    }

    #[test]
    fn without_landmarks_seen_twice_it_is_the_default() {
        let mut log = drive(1);
        log.scans.iter_mut().for_each(|scan| scan.detections.truncate(2));
        assert_eq!(times(&log), [DEFAULT_S; 2]);
        log.odometry.clear();
        assert_eq!(times(&log), [DEFAULT_S; 2]);
    }
}
