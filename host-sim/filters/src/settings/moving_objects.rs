//! Whether a log shows moving objects, from its detections and odometry.

use super::{MovingSettings, SensorSettings};
use scphd_log::log::{Log, Scan, Sensor};
use scphd_log::vehicle::Way;

/// Times between the three scans that are compared, s: in a short time slow objects hardly move, in a long time odometry drifts.
const APART_S: [f64; 2] = [0.5, 1.0];
/// Greatest number of times between scans, relative to those asked.
const AT_MOST: f64 = 3.0;
/// Greatest number of first scans; of longer logs every n-th is one.
const SCANS: usize = 1000;
/// Detections closer than this many standard deviations may be of the same place.
const GATE: f64 = 3.0;
/// Objects faster than this many standard deviations of the velocity are not looked for.
const FASTEST: f64 = 3.0;
/// Least share of detections that are seen again at the same place: otherwise odometry, or the stated noise, is wrong.
const STILL: f64 = 0.5;
/// Least share of detections of moving objects, and least number of standard deviations by which they are more than by chance.
const MOVING: f64 = 0.002;
const SIGNIFICANT: f64 = 3.0;

/// A detection in the frame of the odometry, m, with a standard deviation that holds for both coordinates.
struct Place {
    at: [f64; 2],
    sigma_m: f64,
}

/// Detections of first scans, and what becomes of them in the second and third.
#[derive(Default)]
struct Count {
    all: usize,
    /// Detected at the same place again.
    still: usize,
    /// Detected at a second place, and at a third one where an even motion leads, and at no place twice.
    moving: usize,
    /// The same with a quarter turn, to the right or to the left, after the second place.
    turning: usize,
}

/// Whether objects that move are detected by the sensor with this index.
pub(super) fn are_seen(
    log: &Log,
    way: &Way<'_>,
    index: usize,
    sensor: &Sensor,
    noise: &SensorSettings,
    prior: &MovingSettings,
) -> bool {
    let scans: Vec<_> = log.scans.iter().filter(|scan| scan.sensor == index).collect();
    let places: Vec<_> = scans.iter().map(|scan| places(way, scan, sensor, noise)).collect();
    APART_S.into_iter().any(|apart_s| {
        let mut count = Count::default();
        let after = |scan: usize| {
            first_after(&scans, scan, apart_s).filter(|&next| scans[next].t_s < scans[scan].t_s + AT_MOST * apart_s)
        };
        for first in (0..scans.len()).step_by(scans.len() / SCANS + 1) {
            let Some((second, third)) = after(first).and_then(|second| Some((second, after(second)?))) else {
                continue;
            };
            let [to_second, to_third] = [[first, second], [second, third]].map(|[a, b]| scans[b].t_s - scans[a].t_s);
            let reach_m = FASTEST * prior.velocity_sigma_mps * to_second;
            count.add([first, second, third].map(|scan| places[scan].as_slice()), reach_m, to_third / to_second);
        }
        count.is_of_moving()
    })
}

/// The index of the first scan at least `apart_s` after the one with the index `scan`.
pub(super) fn first_after(scans: &[&Scan], scan: usize, apart_s: f64) -> Option<usize> {
    let later = |later: &&Scan| later.t_s >= scans[scan].t_s + apart_s;
    scans[scan + 1..].iter().position(later).map(|next| scan + 1 + next)
}

fn places(way: &Way<'_>, scan: &Scan, sensor: &Sensor, noise: &SensorSettings) -> Vec<Place> {
    let [x, y, heading] = sensor.mounting.seat(way.at(scan.t_s));
    let place = |&[range, bearing]: &[f64; 2]| {
        let angle = heading + bearing;
        Place {
            at: [x + range * libm::cos(angle), y + range * libm::sin(angle)],
            sigma_m: noise.range_sigma_at(range).max(range * noise.bearing_sigma_rad),
        }
    };
    scan.detections.iter().map(place).collect()
}

impl Place {
    /// Whether one of these places is at most this many standard deviations from `at`.
    fn is_any(places: &[Self], at: [f64; 2], gate: f64) -> bool {
        places.iter().any(|place| libm::hypot(at[0] - place.at[0], at[1] - place.at[1]) < gate * place.sigma_m)
    }
}

impl Count {
    /// Adds the detections of a first scan. The time from the second to the third is `ratio` times that from the first to the second.
    fn add(&mut self, [first, second, third]: [&[Place]; 3], reach_m: f64, ratio: f64) {
        // The variance of a difference, and that of an extrapolation by the difference.
        let (same, ahead) = (2.0_f64.sqrt() * GATE, (1.0 + ratio * ratio + (1.0 + ratio).powi(2)).sqrt() * GATE);
        let is_new = |place: &&Place| ![first, third].into_iter().any(|places| Place::is_any(places, place.at, same));
        let new: Vec<_> = second.iter().filter(is_new).collect();
        for from in first {
            self.all += 1;
            if [second, third].into_iter().any(|places| Place::is_any(places, from.at, same)) {
                self.still += 1;
                continue;
            }
            for to in &new {
                let [x, y] = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
                if libm::hypot(x, y) < reach_m {
                    let leads = |[x, y]: [f64; 2]| {
                        usize::from(Place::is_any(third, [to.at[0] + ratio * x, to.at[1] + ratio * y], ahead))
                    };
                    self.moving += leads([x, y]);
                    self.turning += leads([-y, x]) + leads([y, -x]);
                }
            }
        }
    }

    fn is_of_moving(&self) -> bool {
        let [all, still, moving, turning] = [self.all, self.still, self.moving, self.turning].map(|count| count as f64);
        let more = moving - 0.5 * turning;
        still >= STILL * all && more >= MOVING * all && more >= SIGNIFICANT * (1.0 + moving + 0.25 * turning).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use scphd_worlds::scenario::worlds::{Kind, world};

    fn shows(log: &Log) -> bool {
        let settings = Settings::for_log(log);
        are_seen(log, &Way::of(log), 0, &log.sensor, &settings.sensor, &settings.moving)
    }

    #[test]
    fn they_are_seen_in_most_worlds_with_them_and_in_none_without() {
        let count = |kind| (0..12).filter(|seed| shows(&world(kind, 900_000 + seed))).count();
        assert_eq!(count(Kind::DataSheet), 0);
        let seen = count(Kind::Moving);
        assert!(seen >= 9, "{seen}");
    }

    #[test]
    fn a_scale_error_of_the_odometry_is_no_motion_of_objects() {
        for seed in 0..12 {
            for factor in [0.9, 1.1] {
                let mut log = world(Kind::DataSheet, seed);
                log.odometry.iter_mut().for_each(|row| row.control[0] *= factor);
                assert!(!shows(&log), "{seed} {factor}");
            }
        }
    }
}
