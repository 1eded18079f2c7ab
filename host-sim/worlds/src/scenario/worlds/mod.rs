//! Random worlds, a different one for every seed: the test set for default settings.
//!
//! A world of the kind *data sheet* states what a data sheet states, the noise of range and bearing and the field of view, and
//! has the errors of real ones: landmarks have a width and occlude each other, are not detected for seconds, odometry has a scale
//! error, an offset and slip, false detections persist for a while, some measurements are outliers ([`Misbehaviour`], each with
//! its own switch and its own random numbers). A world of the kind *exact* states all of its noise, and has no other errors. In a
//! *mounted* world the sensor of a data sheet world is at another place on the vehicle, and rotated; in a *moving* one there are
//! also moving objects.
//!
//! Three sizes (12, 36 and 96 m, with speed in proportion), a car with its sensor ahead or a robot that moves on arcs, 15 to 45
//! landmarks, a view from 2.4 rad to the full circle, 240 to 300 s.

mod detector;
mod misbehaviour;
mod plan;
mod spells;
mod stream;
#[cfg(test)]
mod tests;
mod wheels;

pub use misbehaviour::Misbehaviour;
pub(crate) use spells::Spells;
pub(crate) use stream::stream;

use crate::scenario::mover;
use detector::Detector;
use plan::Plan;
use scphd_log::log::{Log, Nominal, Scan, TruePose};

/// Statements of a world about itself, and therefore its possible errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Noise of range and bearing, and the view; all errors are present.
    DataSheet,
    /// All of its noise; there are no other errors.
    Exact,
    /// As a data sheet, and the mounting of the sensor, which is not at the vehicle's pose, and rotated.
    Mounted,
    /// As a data sheet; there are moving objects among the landmarks.
    Moving,
}

pub fn world(kind: Kind, seed: u64) -> Log {
    match kind {
        Kind::DataSheet => misbehaving(seed, Misbehaviour::ALL),
        Kind::Mounted => {
            let plan = Plan::data_sheet(seed).mounted(seed);
            of_plan(&plan, Misbehaviour::ALL, seed, "worlds-mounted", by_data_sheet)
        }
        Kind::Moving => {
            let plan = Plan::data_sheet(seed).with_movers(seed);
            of_plan(&plan, Misbehaviour::ALL, seed, "worlds-moving", by_data_sheet)
        }
        Kind::Exact => of_plan(&Plan::exact(seed), Misbehaviour::NONE, seed, "worlds-exact", exactly),
    }
}

/// The data sheet world with this seed, with only the errors in `misbehaviour`.
pub fn misbehaving(seed: u64, misbehaviour: Misbehaviour) -> Log {
    of_plan(&Plan::data_sheet(seed), misbehaviour, seed, "worlds", by_data_sheet)
}

fn of_plan(plan: &Plan, misbehaviour: Misbehaviour, seed: u64, name: &str, stated: fn(&Plan) -> Nominal) -> Log {
    let odometry = wheels::odometry(plan, misbehaviour, seed);
    let path = plan.path();
    let seen_from: Vec<(f64, [f64; 3])> =
        path.iter().enumerate().step_by(plan.rows_per_scan).map(|(row, &pose)| (plan.time(row), pose)).collect();
    let mut detector = Detector::new(plan, misbehaviour, seed);
    let scans = seen_from.iter().map(|&(t_s, pose)| {
        let (detections, labels) = detector.scan(t_s, pose).into_iter().unzip();
        Scan { t_s, detections, labels, ..Scan::default() }
    });
    let scans = scans.collect();
    let truth =
        seen_from.iter().map(|&(t_s, [x, y, heading])| TruePose { t_s, position: [x, y], heading_rad: Some(heading) });
    let truth = truth.collect();
    let times: Vec<f64> = seen_from.iter().map(|&(t_s, _)| t_s).collect();
    Log {
        name: format!("{name}-{seed}"),
        initial_pose: path[0],
        vehicle: plan.vehicle,
        sensor: plan.sensor,
        nominal: stated(plan),
        simulated: misbehaviour == Misbehaviour::NONE && name == "worlds-exact",
        odometry,
        scans,
        truth,
        landmarks: plan.landmarks.clone(),
        moving: mover::tracks(&plan.movers, plan.landmarks.len(), &times),
        ..Log::default()
    }
}

fn by_data_sheet(plan: &Plan) -> Nominal {
    Nominal {
        range_sigma_m: Some(plan.range_sigma_m),
        bearing_sigma_rad: Some(plan.bearing_sigma_rad),
        ..Nominal::default()
    }
}

fn exactly(plan: &Plan) -> Nominal {
    let turn = Some(plan.turn_sigma);
    let steers = matches!(plan.vehicle, scphd_log::log::Vehicle::Ackermann { .. });
    Nominal {
        speed_sigma_mps: Some(plan.speed_sigma_mps),
        rate_sigma_radps: turn.filter(|_| !steers),
        steering_sigma_rad: turn.filter(|_| steers),
        detection_probability: Some(plan.detection_probability),
        clutter_per_scan: Some(plan.clutter_per_scan),
        ..by_data_sheet(plan)
    }
}
