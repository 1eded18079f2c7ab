//! Removal and correction of invalid detections of a recording.

use super::Draft;
use scphd_log::angle::wrap;
use scphd_log::log::Scan;
use std::f64::consts::PI;

/// Largest bearing that is kept as it is, rad: logs have π with a few digits, and simulated numbers keep their bits.
const HALF_TURN_RAD: f64 = PI + 1e-3;
/// Largest bearing that is wrapped, rad: other conventions of bearings stay within it; beyond, it is not an angle in radians.
const TURNS_RAD: f64 = 2.5 * PI;
/// Relative difference within which ranges are equal,
const SAME: f64 = 1e-5;
/// The greatest range means "no return" with at least this number of detections, and this share of all,
const COUNT: usize = 20;
const SHARE: f64 = 0.01;
/// with at least this many times the detections of the band of this relative width below it, and with bearings farther apart than
/// this, rad, because parts of the vehicle itself stand still.
const TIMES: usize = 5;
const BAND: f64 = 0.03;
const APART_RAD: f64 = 0.1;

impl Draft {
    /// Removes invalid detections and wraps bearings. With `simulated`, ranges may be negative, because of noise.
    pub(super) fn clean(&mut self, simulated: bool) {
        let Self { scans, sensors, told, range_below_m, .. } = self;
        for (place, (name, _)) in sensors.iter().enumerate() {
            let named = if name.is_empty() { "detections".to_owned() } else { format!("detections of {name}") };
            let mut of_sensor: Vec<&mut Scan> = scans.iter_mut().filter(|scan| scan.sensor == place).collect();
            if let Some(below_m) = *range_below_m {
                let count = leave(&mut of_sensor, |range| range < below_m);
                if count > 0 {
                    told.push(format!("{count} {named} are left out whose range is not below {below_m} m"));
                }
            }
            if !simulated {
                let count = leave(&mut of_sensor, |range| range > 0.0);
                if count > 0 {
                    told.push(format!("{count} {named} without a range (0 or less) are left out"));
                }
            }
            let bearings = of_sensor.iter().flat_map(|scan| &scan.detections).map(|[_, bearing]| bearing.abs());
            let greatest = bearings.fold(0.0, f64::max);
            if greatest > HALF_TURN_RAD && greatest <= TURNS_RAD {
                let all = of_sensor.iter_mut().flat_map(|scan| &mut scan.detections);
                let beyond = all.filter(|[_, bearing]| bearing.abs() > HALF_TURN_RAD);
                let count = beyond.map(|[_, bearing]| *bearing = wrap(*bearing)).count();
                told.push(format!("{count} {named} have bearings beyond half a turn: whole turns are taken off"));
            }
            if let Some((count, all, range_m)) = repeated(&of_sensor).filter(|_| !simulated) {
                let below_m = (1e3 * range_m * (1.0 - 10.0 * SAME)).floor() / 1e3;
                told.push(format!(
                    "warning: {count} of {all} {named} have the range {range_m:.3} m to the last digit, whatever their bearing: so sensors write that \
                     nothing came back; --range-below {below_m} leaves them out"
                ));
            }
        }
    }
}

/// Removes detections whose range is not kept. Returns their number.
fn leave(scans: &mut [&mut Scan], kept: impl Fn(f64) -> bool) -> usize {
    let mut count = 0;
    for scan in scans {
        let keep: Vec<bool> = scan.detections.iter().map(|[range, _]| kept(*range)).collect();
        count += keep.iter().filter(|keep| !**keep).count();
        let mut of_detection = keep.iter();
        scan.detections.retain(|_| *of_detection.next().unwrap_or(&true));
        let mut of_label = keep.iter();
        scan.labels.retain(|_| *of_label.next().unwrap_or(&true));
    }
    count
}

/// Number of detections with the greatest range, number of all, and this range, m; `None` if it is a measured range.
fn repeated(scans: &[&mut Scan]) -> Option<(usize, usize, f64)> {
    let all = || scans.iter().flat_map(|scan| &scan.detections);
    let (count, range_m) = (all().count(), all().map(|[range, _]| *range).fold(0.0, f64::max));
    let same = |range: f64| range > range_m * (1.0 - SAME);
    let bearings: Vec<f64> = all().filter(|[range, _]| same(*range)).map(|[_, bearing]| *bearing).collect();
    let below = all().filter(|[range, _]| *range > range_m * (1.0 - BAND) && !same(*range)).count();
    let first = bearings.first()?;
    let apart = bearings.iter().any(|bearing| wrap(bearing - first).abs() > APART_RAD);
    let many = bearings.len() >= COUNT.max((SHARE * count as f64) as usize) && bearings.len() >= TIMES * below;
    (many && apart).then_some((bearings.len(), count, range_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draft(detections: Vec<[f64; 2]>) -> Draft {
        let labels = (0..).take(detections.len()).collect();
        let scans = vec![Scan { detections, labels, ..Scan::default() }];
        Draft { sensors: vec![(String::new(), None)], scans, ..Draft::default() }
    }

    #[test]
    fn bearings_are_wrapped_unless_they_are_in_degrees() {
        let mut turns = draft(vec![[1.0, 6.0], [2.0, 0.5], [3.0, -4.0], [4.0, PI + 5e-4]]);
        turns.clean(true);
        let found: Vec<f64> = turns.scans[0].detections.iter().map(|[_, bearing]| *bearing).collect();
        for (found, right) in found.iter().zip([6.0 - 2.0 * PI, 0.5, 2.0 * PI - 4.0, PI + 5e-4]) {
            assert!((found - right).abs() < 1e-12, "{found}");
        }
        assert!(turns.told[0].contains("2 detections have bearings beyond half a turn"), "{:?}", turns.told);
        let degrees = vec![[1.0, 45.0], [2.0, 0.5], [3.0, -4.0]];
        let mut kept = draft(degrees.clone());
        kept.clean(false);
        assert!(kept.scans[0].detections == degrees && kept.told.is_empty());
    }

    #[test]
    fn ranges_that_mean_no_return_are_reported_and_left_out() {
        let spread = |k: u32| -1.0 + 0.02 * f64::from(k);
        let measured = (0..100).map(|k| [5.0 + 0.2 * f64::from(k), spread(k)]);
        let nothing = (0..100).map(|k| [30.0 * if k % 2 == 0 { 1.0 } else { 1.0 - 1e-7 }, spread(k)]);
        let mut found = draft(measured.clone().chain(nothing).collect());
        found.clean(false);
        let told = found.told.join("\n");
        assert!(
            told.contains("100 of 200 detections have the range 30.000 m") && told.contains("--range-below 29.997"),
            "{told}"
        );
        found.range_below_m = Some(29.997);
        found.clean(false);
        assert_eq!((found.scans[0].detections.len(), found.scans[0].labels.last()), (100, Some(&99)));
        // A part of the vehicle; ranges of a sensor with a resolution of a centimetre.
        let body = (0..100).map(|_| [30.0, 0.5]);
        let steps = (0..1000).map(|k| [0.01 * f64::from(k % 50) + 29.0, spread(k % 100)]);
        for detections in [body.collect::<Vec<_>>(), steps.collect()] {
            let mut kept = draft(detections);
            kept.clean(false);
            assert!(kept.told.is_empty(), "{:?}", kept.told);
        }
        let mut zeros = draft(measured.chain((0..9).map(|k| [if k < 3 { -1.0 } else { 0.0 }, 0.1])).collect());
        zeros.clean(true);
        assert_eq!(zeros.scans[0].detections.len(), 109);
        zeros.clean(false);
        assert!(zeros.scans[0].detections.len() == 100 && zeros.told[0].contains("9 detections without a range"));
    }
}
