//! Settings proposed from a log: the filter is run over it, and what its innovations say about noise, detection and
//! clutter becomes the settings of the next round.
//!
//! Nothing here knows the truth. What the innovations cannot tell apart stays as it is: correlated odometry errors, a
//! view that is narrower than said, and everything that concerns the recursion itself. The errors of real detectors repeat
//! from scan to scan, which innovations take for the feature's place: so real noise never goes below what the log calls
//! its own, and many rounds make a real log's settings worse.

mod detection;
mod measurement_noise;
mod odometry_noise;
mod pairs;

use crate::events::{Event, events};
use crate::log::Log;
use crate::record::MapFeature;
use crate::session::{SessionError, with_roomy_stack};
use crate::settings::Settings;
use crate::slam::{Precision, core_filter, range_bearing};
use detection::{Clutter, Detections};
use measurement_noise::MeasurementNoise;
use odometry_noise::OdometryNoise;
use pairs::{Pair, Place, pairs};

/// A setting, what it was, what the log says, and on how many observations that rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposed {
    /// `section.field`.
    pub name: &'static str,
    /// What the run started from.
    pub before: f64,
    /// What is proposed.
    pub after: f64,
    /// Innovations, corrections or measurements behind it.
    pub observations: usize,
}

/// The outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// The settings with everything proposed put in.
    pub settings: Settings,
    /// What has been looked at, in the order of the settings file.
    pub proposed: Vec<Proposed>,
}

/// Fewer observations than this change nothing.
const LEAST_OBSERVATIONS: usize = 50;
/// No setting changes by more than this factor a round: statistics of a filter that is far off are far off themselves.
const GREATEST_STEP: f64 = 2.0;
/// A detector that never fails, or never works, leaves no filter that could find out.
const DETECTION: [f64; 2] = [0.02, 0.98];
/// Clutter below this a scan would make every measurement a feature.
const LEAST_CLUTTER: f64 = 0.01;

/// Proposes settings in so many rounds, each a run over the whole log with the settings of the one before. `progress` is
/// told the scans done in all.
///
/// # Errors
/// The filter refuses the settings or a step, or the system has no thread for it.
pub fn tune(
    log: &Log,
    settings: &Settings,
    seed: u64,
    rounds: usize,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Tuned, SessionError> {
    let mut tuned = Tuned { settings: settings.clone(), proposed: Vec::new() };
    for round in 0..rounds {
        let mut report = |scans| progress(round * log.scans.len() + scans);
        let statistics = with_roomy_stack(|| observe(log, &tuned.settings, seed, &mut report));
        tuned = statistics.map_err(SessionError::Thread)??.propose(log, settings, &tuned.settings);
    }
    Ok(tuned)
}

/// What one run over a log left behind.
#[derive(Debug, Default)]
struct Statistics {
    noise: MeasurementNoise,
    odometry: OdometryNoise,
    detections: Detections,
    clutter: Clutter,
}

impl Statistics {
    fn propose(&self, log: &Log, first: &Settings, now: &Settings) -> Tuned {
        let mut settings = now.clone();
        let mut proposed = Vec::new();
        let mut propose = |name, before: f64, field: &mut f64, found: Option<f64>, observations| {
            if let Some(found) = found.filter(|_| observations >= LEAST_OBSERVATIONS) {
                *field = found.clamp(*field / GREATEST_STEP, *field * GREATEST_STEP);
            }
            proposed.push(Proposed { name, before, after: *field, observations });
        };
        let [along, turning] = self.odometry.ratios();
        let (from, to) = (&first.vehicle, &mut settings.vehicle);
        for (name, before, field, ratio) in [
            ("vehicle.speed_sigma_mps", from.speed_sigma_mps, &mut to.speed_sigma_mps, along),
            ("vehicle.speed_sigma_ratio", from.speed_sigma_ratio, &mut to.speed_sigma_ratio, along),
            ("vehicle.turn_sigma", from.turn_sigma, &mut to.turn_sigma, turning),
            ("vehicle.turn_sigma_ratio", from.turn_sigma_ratio, &mut to.turn_sigma_ratio, turning),
        ] {
            let found = ratio.map(|ratio| *field * ratio);
            propose(name, before, field, found, self.odometry.corrections());
        }
        let [range, bearing] = self.noise.sigmas();
        let at_least = |own: Option<f64>| move |found: f64| found.max(own.filter(|_| !log.simulated).unwrap_or(0.0));
        let range = range.map(at_least(log.nominal.range_sigma_m));
        let bearing = bearing.map(at_least(log.nominal.bearing_sigma_rad));
        let (from, to) = (&first.sensor, &mut settings.sensor);
        let residuals = self.noise.residuals();
        propose("sensor.range_sigma_m", from.range_sigma_m, &mut to.range_sigma_m, range, residuals);
        propose("sensor.bearing_sigma_rad", from.bearing_sigma_rad, &mut to.bearing_sigma_rad, bearing, residuals);
        let line = self.detections.line(to.range_max_m);
        let [near, far] = [0, 1].map(|end| line.map(|line: [f64; 2]| line[end].clamp(DETECTION[0], DETECTION[1])));
        let expected = self.detections.expected();
        propose("sensor.detection_near", from.detection_near, &mut to.detection_near, near, expected);
        propose("sensor.detection_far", from.detection_far, &mut to.detection_far, far, expected);
        let clutter = self.clutter.per_scan().map(|found| found.max(LEAST_CLUTTER));
        let before = to.clutter_per_scan;
        propose(
            "sensor.clutter_per_scan",
            from.clutter_per_scan,
            &mut to.clutter_per_scan,
            clutter,
            self.clutter.measurements(),
        );
        // The ratio of births to clutter is the user's judgement of what is more likely; it stays.
        if before > 0.0 {
            settings.filter.birth_intensity *= settings.sensor.clutter_per_scan / before;
            settings.moving.birth_intensity *= settings.sensor.clutter_per_scan / before;
        }
        Tuned { settings, proposed }
    }
}

/// One run over the log.
fn observe(
    log: &Log,
    settings: &Settings,
    seed: u64,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Statistics, SessionError> {
    let mut slam =
        core_filter(settings, &log.vehicle, log.initial_pose, Precision::F64, seed).map_err(SessionError::Start)?;
    let sensor = range_bearing(&settings.sensor).map_err(SessionError::Start)?;
    let mut statistics = Statistics::default();
    let mut map: Vec<MapFeature> = Vec::new();
    let mut left_over: Vec<Place> = Vec::new();
    for event in events(log) {
        let scan = statistics.clutter.scans();
        let refused = |step| move |refusal| SessionError::Step { scan, t_s: log.scans[scan].t_s, step, refusal };
        match event {
            Event::Predict { control, dt_s, .. } => {
                if slam.predict(control, dt_s).map_err(refused("the prediction"))?.is_some() {
                    continue;
                }
                statistics.odometry.predict(&log.vehicle, &settings.vehicle, control, dt_s);
            }
            Event::Scan { index } => {
                let detections = &log.scans[index].detections;
                let (before, covariance) = slam.pose().map_err(refused("the pose"))?;
                let (found, expected) = pairs(&map, before, &covariance, &sensor, &settings.sensor, detections);
                slam.scan(detections).map_err(refused("the scan"))?;
                let (after, _) = slam.pose().map_err(refused("the pose"))?;
                map = slam.map().map_err(refused("the map"))?.1;
                statistics.odometry.correct(before, after);
                statistics.noise.scan(&found, &covariance, &sensor);
                statistics.detections.scan(&expected);
                left_over.extend(unpaired(detections, &found).filter_map(|z| Place::of(z, after, &sensor)));
                statistics.clutter.scan(detections.len());
                progress(statistics.clutter.scans());
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

#[cfg(test)]
mod tests;
