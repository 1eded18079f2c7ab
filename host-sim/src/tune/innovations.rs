//! What the innovations of a run say about noise, detection and clutter.
//!
//! Nothing here knows the truth, and nothing here is believed at once: the errors of real detectors repeat from scan to scan, which
//! innovations take for the feature's place, so that real noise looks smaller than a map can live with. What comes out is a
//! proposal for [`super::search`].

use super::change::{Change, Said};
use super::detection::{Clutter, Detections};
use super::measurement_noise::MeasurementNoise;
use super::odometry_noise::OdometryNoise;
use super::pairs::{Pair, Place, pairs};
use crate::events::{Event, events};
use crate::log::Log;
use crate::record::MapFeature;
use crate::session::{Filter, SessionError, with_roomy_stack};
use crate::settings::Settings;
use crate::slam::range_bearing;
use std::ops::Range;

/// Fewer observations than this change nothing.
const LEAST_OBSERVATIONS: usize = 50;
/// No setting changes by more than this factor a round: statistics of a filter that is far off are far off themselves.
const GREATEST_STEP: f64 = 2.0;
/// A detector that never fails, or never works, leaves no filter that could find out.
const DETECTION: [f64; 2] = [0.02, 0.98];
/// Clutter below this a scan would make every measurement a feature.
const LEAST_CLUTTER: f64 = 0.01;

/// What the innovations of the scans `learn` say in so many rounds, each a run with what the round before said. `progress` is told
/// each round that is done.
///
/// # Errors
/// The filter refuses the settings or a step, or the system has no thread for it.
pub fn innovations(
    log: &Log,
    settings: &Settings,
    filter: Filter,
    seed: u64,
    rounds: usize,
    learn: &Range<usize>,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Said>, SessionError> {
    let mut said = Vec::new();
    let mut now = settings.clone();
    for _ in 0..rounds {
        let statistics = with_roomy_stack(|| observe(log, &now, filter, seed, learn));
        (now, said) = statistics.map_err(SessionError::Thread)??.propose(log, settings, &now);
        progress();
    }
    Ok(said)
}

/// What one run over a part of a log left behind.
#[derive(Debug, Default)]
struct Statistics {
    noise: MeasurementNoise,
    odometry: OdometryNoise,
    detections: Detections,
    clutter: Clutter,
}

impl Statistics {
    /// What there is to say, against what there was at `first`, and the settings of the next round.
    fn propose(&self, log: &Log, first: &Settings, now: &Settings) -> (Settings, Vec<Said>) {
        let mut settings = now.clone();
        let mut said = Vec::new();
        let mut propose = |field, before: f64, value: &mut f64, found: Option<f64>, [least, greatest]: [f64; 2], n| {
            let found = found.filter(|_| n >= LEAST_OBSERVATIONS);
            let mut clamped = false;
            if let Some(found) = found {
                let within = found.clamp(*value / GREATEST_STEP, *value * GREATEST_STEP).clamp(least, greatest);
                clamped = within != found;
                *value = within;
            }
            let change = found.map(|_| Change::new(field, *value));
            said.push(Said { field, now: before, change, clamped, observations: n });
        };
        let any = [0.0, f64::INFINITY];
        let [along, turning] = self.odometry.ratios();
        let (from, to) = (&first.vehicle, &mut settings.vehicle);
        for (field, before, value, ratio) in [
            ("vehicle.speed_sigma_mps", from.speed_sigma_mps, &mut to.speed_sigma_mps, along),
            ("vehicle.speed_sigma_ratio", from.speed_sigma_ratio, &mut to.speed_sigma_ratio, along),
            ("vehicle.turn_sigma", from.turn_sigma, &mut to.turn_sigma, turning),
            ("vehicle.turn_sigma_ratio", from.turn_sigma_ratio, &mut to.turn_sigma_ratio, turning),
        ] {
            let found = ratio.map(|ratio| *value * ratio);
            propose(field, before, value, found, any, self.odometry.corrections());
        }
        let [range, bearing] = self.noise.sigmas();
        // Nobody's detector is better in the field than on its data sheet.
        let at_least = |own: Option<f64>| [own.filter(|_| !log.simulated).unwrap_or(0.0), f64::INFINITY];
        let of_range = at_least(log.nominal.range_sigma_m);
        let of_bearing = at_least(log.nominal.bearing_sigma_rad);
        let (from, to) = (&first.sensor, &mut settings.sensor);
        let residuals = self.noise.residuals();
        propose("sensor.range_sigma_m", from.range_sigma_m, &mut to.range_sigma_m, range, of_range, residuals);
        propose(
            "sensor.bearing_sigma_rad",
            from.bearing_sigma_rad,
            &mut to.bearing_sigma_rad,
            bearing,
            of_bearing,
            residuals,
        );
        let line = self.detections.line(to.range_max_m);
        let [near, far] = [0, 1].map(|end| line.map(|line: [f64; 2]| line[end]));
        let expected = self.detections.expected();
        propose("sensor.detection_near", from.detection_near, &mut to.detection_near, near, DETECTION, expected);
        propose("sensor.detection_far", from.detection_far, &mut to.detection_far, far, DETECTION, expected);
        let before = to.clutter_per_scan;
        propose(
            "sensor.clutter_per_scan",
            from.clutter_per_scan,
            &mut to.clutter_per_scan,
            self.clutter.per_scan(),
            [LEAST_CLUTTER, f64::INFINITY],
            self.clutter.measurements(),
        );
        // The ratio of births to clutter is the user's judgement of what is more likely; it stays.
        if before > 0.0 {
            settings.filter.birth_intensity *= settings.sensor.clutter_per_scan / before;
            settings.moving.birth_intensity *= settings.sensor.clutter_per_scan / before;
        }
        (settings, said)
    }
}

/// One run over the log up to the end of `learn`.
fn observe(
    log: &Log,
    settings: &Settings,
    filter: Filter,
    seed: u64,
    learn: &Range<usize>,
) -> Result<Statistics, SessionError> {
    let mut slam = filter.start(log, settings, seed).map_err(SessionError::Start)?;
    let sensor = range_bearing(&settings.sensor).map_err(SessionError::Start)?;
    let mut statistics = Statistics::default();
    let mut map: Vec<MapFeature> = Vec::new();
    let mut left_over: Vec<Place> = Vec::new();
    let mut scan = 0;
    for event in events(log) {
        if scan >= learn.end {
            break;
        }
        let refused = |step| move |refusal| SessionError::Step { scan, t_s: log.scans[scan].t_s, step, refusal };
        match event {
            Event::Predict { control, dt_s, .. } => {
                if slam.predict(control, dt_s).map_err(refused("the prediction"))?.is_none() && learn.contains(&scan) {
                    statistics.odometry.predict(&log.vehicle, &settings.vehicle, control, dt_s);
                }
            }
            Event::Scan { index } => {
                let detections = &log.scans[index].detections;
                let (before, covariance) = slam.pose().map_err(refused("the pose"))?;
                slam.scan(detections).map_err(refused("the scan"))?;
                let (after, _) = slam.pose().map_err(refused("the pose"))?;
                let known = std::mem::replace(&mut map, slam.map().map_err(refused("the map"))?.1);
                if learn.contains(&scan) {
                    let (found, expected) = pairs(&known, before, &covariance, &sensor, &settings.sensor, detections);
                    statistics.odometry.correct(before, after);
                    statistics.noise.scan(&found, &covariance, &sensor);
                    statistics.detections.scan(&expected);
                    left_over.extend(
                        unpaired(detections, &found).filter_map(|z| Place::of(z, after, &sensor, &settings.sensor)),
                    );
                    statistics.clutter.scan(detections.len());
                }
                scan = index + 1;
            }
        }
    }
    // What began as a measurement that nothing explained may have become a feature since.
    statistics.clutter.conclude(left_over.iter().filter(|place| !place.explained_by(&map)).count());
    Ok(statistics)
}

fn unpaired<'a>(detections: &'a [[f64; 2]], found: &'a [Pair]) -> impl Iterator<Item = [f64; 2]> + 'a {
    let paired = |index| found.iter().any(|pair| pair.detection == index);
    detections.iter().enumerate().filter(move |&(index, _)| !paired(index)).map(|(_, &z)| z)
}
