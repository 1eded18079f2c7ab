//! Candidates and trials of logs in the plane.

use super::change::{Candidate, Change, Group, Said, scaled, value_of};
use super::foresight::{Look, Sighting, scores};
use super::search::Foreseen;
use crate::events::{Event, events};
use crate::log::Log;
use crate::session::{Filter, SessionError, with_roomy_stack};
use crate::settings::Settings;
use crate::slam::range_bearing;
use crate::truth;
use nalgebra::Vector2;
use scphd::{PlanarPose, Sensor};
use std::ops::Range;
use toml::Value;

const ODOMETRY: &[&str] =
    &["vehicle.speed_sigma_mps", "vehicle.speed_sigma_ratio", "vehicle.turn_sigma", "vehicle.turn_sigma_ratio"];
const NOISE: &[&str] = &["sensor.range_sigma_m", "sensor.bearing_sigma_rad"];
const DETECTED: &[&str] = &["sensor.detection_near", "sensor.detection_far"];
/// Births go with clutter: which of them is more likely is the user's judgement.
const CLUTTER: &[&str] = &["sensor.clutter_per_scan", "filter.birth_intensity", "moving.birth_intensity"];
/// Six groups, each in two ways.
pub(super) const MOST_CANDIDATES: usize = 12;

/// What there is to try from `settings`: what the innovations say, or half way there, of each group, of all of the sensor's and of
/// everything.
///
/// Of a log that is not a simulation odometry noise is never lowered: what lasts, a scale or an offset, is most of its errors, and
/// is not seen from one scan to the next.
#[must_use]
pub fn candidates(log: &Log, settings: &Settings, said: &[Said]) -> Vec<Candidate> {
    let mut all = Vec::new();
    let mut add = |group, how: &str, changes: Vec<Change>| {
        if !changes.is_empty() {
            all.push(Candidate { group, how: how.to_owned(), changes });
        }
    };
    for (share, how) in [(1.0, "innovations"), (0.5, "half way")] {
        let of = |fields| learnt(settings, said, fields, share);
        let more = |change: &Change| {
            value_of(settings, change.field).as_ref().and_then(Value::as_float) < change.value.as_float()
        };
        let mut odometry = of(ODOMETRY);
        odometry.retain(|change| log.simulated || more(change));
        let groups = [(Group::Noise, of(NOISE)), (Group::Detection, of(DETECTED)), (Group::Clutter, of(CLUTTER))];
        let sensor: Vec<Change> = groups.iter().flat_map(|(_, changes)| changes.clone()).collect();
        groups.into_iter().for_each(|(group, changes)| add(group, how, changes));
        add(Group::Sensor, how, sensor.clone());
        if !odometry.is_empty() {
            add(Group::Odometry, how, odometry.clone());
            add(Group::Together, how, [sensor, odometry].concat());
        }
    }
    all
}

/// What was said of these fields, a share of the way on a logarithmic scale; births take the way of clutter.
fn learnt(settings: &Settings, said: &[Said], fields: &'static [&'static str], share: f64) -> Vec<Change> {
    let mut changes = Vec::new();
    for said in said.iter().filter(|said| fields.contains(&said.field)) {
        let Some(to) = said.change.as_ref().and_then(|change| change.value.as_float()) else { continue };
        if !(said.now > 0.0 && to > 0.0) {
            continue;
        }
        let factor = (to / said.now).powf(share);
        if said.field == CLUTTER[0] {
            changes.extend(scaled(settings, CLUTTER, factor));
        } else {
            changes.push(Change::new(said.field, factor * said.now));
        }
    }
    changes
}

/// One run over the whole log, and what it foresees of the scans that are not in `learn`.
///
/// # Errors
/// The filter refuses the settings or a step, or the system has no thread for it.
pub fn trial(
    log: &Log,
    settings: &Settings,
    filter: Filter,
    seed: u64,
    learn: &Range<usize>,
) -> Result<Foreseen, SessionError> {
    let (looks, poses) = with_roomy_stack(|| run(log, settings, filter, seed)).map_err(SessionError::Thread)??;
    let scores = scores(&looks, view(log));
    let scans = scores.into_iter().zip(&looks).map(|(score, look)| (score, look.predicted.len()));
    let held_out = |index: &usize| !learn.contains(index);
    let rest: Vec<_> = scans.enumerate().filter(|(index, _)| held_out(index)).map(|(_, scan)| scan).collect();
    let squares: Vec<f64> = (0..poses.len())
        .filter(held_out)
        .filter_map(|index| {
            let truth = truth::at(&log.truth, log.scans[index].t_s)?.position;
            Some((poses[index][0] - truth[0]).powi(2) + (poses[index][1] - truth[1]).powi(2))
        })
        .collect();
    let rmse = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    Ok(Foreseen::of(&rest, (!squares.is_empty()).then_some(rmse)))
}

/// What a run made of every scan, and where it was.
type Looks = (Vec<Look>, Vec<[f64; 3]>);

fn run(log: &Log, settings: &Settings, filter: Filter, seed: u64) -> Result<Looks, SessionError> {
    let mut slam = filter.start(log, settings, seed).map_err(SessionError::Start)?;
    // The same for all settings, so that none is flattered.
    let sensor = range_bearing::<f64>(&Settings::for_log(log).sensor).map_err(SessionError::Start)?;
    let (mut looks, mut poses) = (Vec::new(), Vec::new());
    for event in events(log) {
        let scan = looks.len();
        let refused = |step| move |refusal| SessionError::Step { scan, t_s: log.scans[scan].t_s, step, refusal };
        match event {
            Event::Predict { control, dt_s, .. } => {
                slam.predict(control, dt_s).map_err(refused("the prediction"))?;
            }
            Event::Scan { index } => {
                let detections = &log.scans[index].detections;
                let (before, _) = slam.pose().map_err(refused("the pose"))?;
                slam.scan(detections).map_err(refused("the scan"))?;
                let (after, _) = slam.pose().map_err(refused("the pose"))?;
                let seen_from = |[x, y, heading]: [f64; 3]| sensor.frame(&PlanarPose::new(x, y, heading));
                let (before, settled) = (seen_from(before), seen_from(after));
                let inverses = |frame| detections.iter().filter_map(move |&z| sensor.invert(&frame, &Vector2::from(z)));
                let predicted = inverses(before).map(|inverse| Sighting {
                    place: inverse.feature,
                    covariance: sensor.noise().congruence(&inverse.jacobian),
                });
                looks.push(Look {
                    t_s: log.scans[index].t_s,
                    predicted: predicted.collect(),
                    settled: inverses(settled).map(|inverse| inverse.feature).collect(),
                });
                poses.push(after);
            }
        }
    }
    Ok((looks, poses))
}

/// Area of the view, m².
fn view(log: &Log) -> f64 {
    let sensor = &log.sensor;
    0.5 * (sensor.bearing_max_rad - sensor.bearing_min_rad) * (sensor.range_max_m.powi(2) - sensor.range_min_m.powi(2))
}
