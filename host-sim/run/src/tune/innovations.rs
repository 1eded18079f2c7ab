//! Estimates of noise, detection and clutter from the innovations of a run.
//!
//! The truth is not used, and the results are not applied directly: errors of real detectors repeat from scan to scan and are
//! absorbed by the positions of features, so that the noise appears smaller than the filter needs. The results are candidates for
//! [`super::search`].

use super::change::{BIRTHS, Said, changed, scaled, size_of};
use super::detection::{Clutter, Detections};
use super::learn::{Learn, NoiseOf};
use super::measurement_noise::MeasurementNoise;
use super::odometry_noise::OdometryNoise;
use super::over::{Step, over};
use super::pairs::{is_explained, matrix, pairs};
use super::plan::Plan;
use crate::session::{SessionError, with_roomy_stack};
use scphd_score::record::MapFeature;

/// Least number of observations for a change.
const LEAST_OBSERVATIONS: usize = 50;
/// Greatest factor of a change in a round: statistics of a filter with wrong settings are wrong too.
const GREATEST_STEP: f64 = 2.0;
/// Bounds of p_D: with a detector that never or always detects, a filter could not learn otherwise.
const DETECTION: [f64; 2] = [0.02, 0.98];
/// Least clutter a scan; with less, every measurement would become a feature.
const LEAST_CLUTTER: f64 = 0.01;

/// Estimates from the innovations of the scans to learn from, over the plan's rounds; each is a run with the results of the round
/// before. `progress` is called after each round.
pub fn innovations<K: Learn>(
    log: &K::Log,
    settings: &K::Settings,
    plan: &Plan,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Said>, SessionError> {
    let mut said = Vec::new();
    let mut now = settings.clone();
    for _ in 0..plan.rounds {
        let statistics = with_roomy_stack(|| observe::<K>(log, &now, plan));
        (now, said) = statistics.map_err(SessionError::Thread)??.propose::<K>(log, settings, &now);
        progress();
    }
    Ok(said)
}

/// The statistics of one run over a part of a log.
#[derive(Debug, Default)]
struct Statistics {
    noise: MeasurementNoise,
    odometry: OdometryNoise,
    detections: Detections,
    clutter: Clutter,
}

/// Results while they are collected.
struct Gathered<S> {
    first: S,
    settings: S,
    said: Vec<Said>,
}

impl<S: serde::Serialize + serde::de::DeserializeOwned> Gathered<S> {
    /// Adds a result for a field, from this number of observations, within bounds.
    fn say(&mut self, field: &'static str, found: Option<f64>, [least, greatest]: [f64; 2], observations: usize) {
        let (first, now) = (size_of(&self.first, field), size_of(&self.settings, field));
        let Some((before, now)) = first.zip(now) else { return };
        let mut said = Said { field, now: before, to: None, clamped: false, observations };
        if let Some(found) = found.filter(|_| observations >= LEAST_OBSERVATIONS) {
            let within = found.clamp(now / GREATEST_STEP, now * GREATEST_STEP).clamp(least, greatest);
            said.clamped = within != found;
            said.to = Some(within);
            if let Ok(settings) = changed(&self.settings, &scaled(&self.settings, &[field], within / now)) {
                self.settings = settings;
            }
        }
        self.said.push(said);
    }

    fn now(&self, field: &str) -> f64 {
        size_of(&self.settings, field).unwrap_or(0.0)
    }
}

impl Statistics {
    /// The results relative to `first`, and the settings of the next round.
    fn propose<K: Learn>(&self, log: &K::Log, first: &K::Settings, now: &K::Settings) -> (K::Settings, Vec<Said>) {
        let mut all = Gathered { first: first.clone(), settings: now.clone(), said: Vec::new() };
        for (fields, ratio) in K::ODOMETRY.into_iter().zip(self.odometry.ratios()) {
            for &field in fields.iter().filter(|field| K::decides(log, field)) {
                let found = ratio.map(|ratio| all.now(field) * ratio);
                all.say(field, found, [0.0, f64::INFINITY], self.odometry.corrections());
            }
        }
        let scheme = K::scheme(log);
        for NoiseOf { fields, coordinates } in K::NOISE {
            let ratio = self.noise.ratio(coordinates);
            for &field in *fields {
                let found = ratio.map(|ratio| all.now(field) * ratio);
                // The default settings add noise to a data sheet for lasting errors, which innovations do not show.
                let bounded = K::states(log, field) && !K::is_simulated(log);
                let sizes = size_of(&scheme, field).zip(size_of(first, field)).filter(|_| bounded);
                let least = sizes.map_or(0.0, |(scheme, first)| scheme.min(first));
                all.say(field, found, [least, f64::INFINITY], self.noise.residuals());
            }
        }
        let ends = self.detections.line();
        for (place, &field) in K::DETECTION.iter().enumerate() {
            let found = if K::DETECTION.len() == 1 { self.detections.share() } else { ends.map(|ends| ends[place]) };
            all.say(field, found, DETECTION, self.detections.expected());
        }
        let before = all.now(K::CLUTTER);
        all.say(K::CLUTTER, self.clutter.per_scan(), [LEAST_CLUTTER, f64::INFINITY], self.clutter.measurements());
        // The ratio of births to clutter is the user's judgement; it is kept.
        let births = scaled(&all.settings, BIRTHS, all.now(K::CLUTTER) / before);
        let settings = if before > 0.0 { changed(&all.settings, &births).ok() } else { None };
        (settings.unwrap_or(all.settings), all.said)
    }
}

/// Runs a filter over the log up to the end of the part to learn from.
fn observe<K: Learn>(log: &K::Log, settings: &K::Settings, plan: &Plan) -> Result<Statistics, SessionError> {
    let eye = K::eye(log, settings).map_err(SessionError::Start)?;
    let learn = &plan.learn;
    let mut statistics =
        Statistics { detections: Detections::over(K::reach_m(log, settings)), ..Statistics::default() };
    let mut map: Vec<MapFeature<K>> = Vec::new();
    let mut left_over = Vec::new();
    let mut slam = K::slam(plan.filter, log, settings, plan.effort.seed).map_err(SessionError::Start)?;
    over::<K>(&mut *slam, log, settings, learn.end, true, |step| match step {
        Step::Moved { scan, control, dt_s } if learn.contains(&scan) => {
            statistics.odometry.predict(K::added(log, settings, control, dt_s));
        }
        Step::Moved { .. } => {}
        Step::Seen { scan, taken, before, after, map: seen } => {
            let known = std::mem::replace(&mut map, seen);
            if learn.contains(&scan) {
                let (found, expected) = pairs(&*eye, scan, &known, &before, &taken.detections);
                statistics.odometry.correct::<K>(&before.0, &after);
                statistics.noise.scan(&found, &matrix::<K::Pose>(&before.1));
                statistics.detections.scan(&expected);
                let unpaired = |index: &usize| found.iter().all(|pair| pair.detection != *index);
                let unpaired = (0..taken.detections.len()).filter(unpaired);
                left_over.extend(unpaired.filter_map(|index| eye.place(scan, &after, &taken.detections[index])));
                statistics.clutter.scan(taken.detections.len());
            }
        }
    })?;
    // A measurement that was unexplained at first may have become a feature since.
    statistics.clutter.conclude(left_over.iter().filter(|place| !is_explained::<K>(place, &map)).count());
    Ok(statistics)
}
