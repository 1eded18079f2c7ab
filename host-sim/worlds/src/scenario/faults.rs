//! The scenario with a sequence of faults.

use super::simulation::{Imperfection, ROWS_PER_SCAN};
use super::thesis_dynamic::two_laps;
use scphd_log::angle::wrap;
use scphd_log::log::Log;
use scphd_log::noise::Noise;
use scphd_stream::planar::MEASUREMENTS;
use std::f64::consts::PI;
use std::ops::Range;

/// Mean number of false measurements a scan without faults: the capacity of a scan suffices for nearly all of ten times as many.
const CLUTTER_PER_SCAN: f64 = 4.0;

/// Faults, of the same size as in the sequencer's tests of faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    /// Ten times as many false measurements.
    Clutter,
    /// One landmark in ten is detected.
    Blind,
    /// The sensor repeats its last scan.
    StuckScan,
    /// All ranges are a metre too long.
    RangeBias,
    /// All bearings have an error of ten degrees.
    BearingBias,
    /// The wheels turn twice as fast as the vehicle moves.
    Slip,
    /// The odometry reports a vehicle at rest.
    StuckOdometry,
    /// There are no scans.
    NoScans,
}

/// The faults, each with its scans among the 601 at 10 Hz, at least three seconds apart. The last one removes scans.
const PLAN: [(Fault, Range<usize>); 8] = [
    (Fault::Clutter, 60..90),
    (Fault::Blind, 120..150),
    (Fault::StuckScan, 180..210),
    (Fault::RangeBias, 240..270),
    (Fault::BearingBias, 300..330),
    (Fault::Slip, 360..390),
    (Fault::StuckOdometry, 420..450),
    (Fault::NoScans, 480..580),
];

/// The loop of `thesis-dynamic` twice, with its static and moving landmarks, 4 false measurements a scan, and a sequence of
/// faults of 3 s each: ten times the clutter, p_D 0.1, the last scan repeated, errors of the ranges of 1 m and of the bearings of
/// 10°, doubled speeds, controls of zero; then no scan for 10 s. 501 scans of up to 64 measurements, the most that the sensor
/// sends.
pub fn faults(seed: u64) -> Log {
    let mut log = undisturbed(seed);
    // A separate random number generator, so that everything else is as without faults.
    let mut noise = Noise::new(seed ^ 0xfa17_5eed);
    for (fault, during) in PLAN {
        fault.befall(&mut log, during, &mut noise);
    }
    for scan in &mut log.scans {
        scan.detections.truncate(MEASUREMENTS);
        scan.labels.truncate(MEASUREMENTS);
    }
    log
}

const SIGHT: Imperfection = Imperfection { clutter_per_scan: CLUTTER_PER_SCAN, ..Imperfection::OF_5_3_1 };

fn undisturbed(seed: u64) -> Log {
    two_laps("faults", SIGHT).log(seed)
}

impl Fault {
    /// Applies the fault to sensor and odometry during these scans.
    fn befall(self, log: &mut Log, during: Range<usize>, noise: &mut Noise) {
        let rows = ROWS_PER_SCAN * during.start..ROWS_PER_SCAN * during.end;
        match self {
            Self::Clutter => {
                look_again(log, during, Imperfection { clutter_per_scan: 10.0 * CLUTTER_PER_SCAN, ..SIGHT }, noise);
            }
            Self::Blind => look_again(log, during, Imperfection { detection_probability: 0.1, ..SIGHT }, noise),
            Self::StuckScan => {
                let last = log.scans[during.start - 1].clone();
                for scan in &mut log.scans[during] {
                    scan.detections.clone_from(&last.detections);
                    scan.labels.clone_from(&last.labels);
                }
            }
            Self::RangeBias => of_detections(log, during, |[range, bearing]| [range + 1.0, bearing]),
            Self::BearingBias => {
                of_detections(log, during, |[range, bearing]| [range, wrap(bearing + PI / 18.0)]);
            }
            Self::Slip => log.odometry[rows].iter_mut().for_each(|row| row.control[0] *= 2.0),
            Self::StuckOdometry => log.odometry[rows].iter_mut().for_each(|row| row.control = [0.0; 3]),
            Self::NoScans => drop(log.scans.drain(during)),
        }
    }
}

/// Replaces scans by those of a sensor with other errors at the same poses.
fn look_again(log: &mut Log, during: Range<usize>, sight: Imperfection, noise: &mut Noise) {
    let times = log.truth.len();
    for index in during {
        let truth = log.truth[index];
        let pose = [truth.position[0], truth.position[1], truth.heading_rad.unwrap_or(0.0)];
        let moving = log.moving.chunks(times).map(|track| track[index].position);
        let seen = sight.scan(&pose, log.landmarks.iter().copied().chain(moving), noise);
        (log.scans[index].detections, log.scans[index].labels) = seen.into_iter().unzip();
    }
}

fn of_detections(log: &mut Log, during: Range<usize>, wrong: impl Fn([f64; 2]) -> [f64; 2]) {
    let detections = log.scans[during].iter_mut().flat_map(|scan| scan.detections.iter_mut());
    detections.for_each(|detection| *detection = wrong(*detection));
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::log::Scan;

    fn of(fault: Fault) -> Range<usize> {
        PLAN.into_iter().find(|(other, _)| *other == fault).unwrap().1
    }

    fn mean(scans: &[Scan]) -> f64 {
        scans.iter().map(|scan| scan.detections.len()).sum::<usize>() as f64 / scans.len() as f64
    }

    #[test]
    fn every_fault_is_there_and_nothing_else() {
        let (log, right) = (faults(3), undisturbed(3));
        let (silent, all) = (of(Fault::NoScans), right.scans.len());
        assert_eq!((log.scans.len(), all, log.truth.len()), (501, 601, 601));
        assert!((log.scans[silent.start].t_s - log.scans[silent.start - 1].t_s - 10.1).abs() < 1e-9);
        let [clutter, blind, stuck, range, bearing] =
            [Fault::Clutter, Fault::Blind, Fault::StuckScan, Fault::RangeBias, Fault::BearingBias].map(of);
        // Faults of the sensor.
        let wrong = [&clutter, &blind, &stuck, &range, &bearing];
        for (index, scan) in log.scans.iter().enumerate().take(silent.start) {
            assert_eq!(*scan != right.scans[index], wrong.iter().any(|during| during.contains(&index)), "{index}");
        }
        let more = mean(&log.scans[clutter.clone()]) - mean(&right.scans[clutter]);
        assert!((30.0..40.0).contains(&more), "{more}");
        assert!(log.scans.iter().any(|scan| scan.detections.len() > 55));
        assert!(log.scans.iter().all(|scan| scan.detections.len() <= MEASUREMENTS));
        let left = mean(&log.scans[blind.clone()]) - CLUTTER_PER_SCAN;
        assert!(left < 0.2 * mean(&right.scans[blind]), "{left}");
        let before = &log.scans[stuck.start - 1].detections;
        assert!(log.scans[stuck].iter().all(|scan| scan.detections == *before));
        let off = |during: Range<usize>, k: usize| {
            let pairs = log.scans[during.clone()].iter().zip(&right.scans[during]);
            let pairs = pairs.flat_map(|(wrong, right)| wrong.detections.iter().zip(&right.detections));
            pairs.map(|(wrong, right)| wrap(wrong[k] - right[k])).collect::<Vec<_>>()
        };
        assert!(off(range, 0).iter().all(|off| (off - 1.0).abs() < 1e-12));
        assert!(off(bearing, 1).iter().all(|off| (off - 10_f64.to_radians()).abs() < 1e-12));
        // Faults of the odometry.
        let [slip, standing] = [Fault::Slip, Fault::StuckOdometry].map(of);
        for (row, (says, right)) in log.odometry.iter().zip(&right.odometry).enumerate() {
            let [speed, steering, _] = right.control;
            let expected = match row / ROWS_PER_SCAN {
                scan if slip.contains(&scan) => [2.0 * speed, steering, 0.0],
                scan if standing.contains(&scan) => [0.0; 3],
                _ => [speed, steering, 0.0],
            };
            assert_eq!(says.control, expected, "{row}");
        }
    }

    #[test]
    fn there_is_time_between_the_faults() {
        for pair in PLAN.windows(2) {
            assert!(pair[0].1.end + 30 <= pair[1].1.start && pair[0].1.len() == 30);
        }
        assert!(PLAN[7].1.end < 600);
    }
}
