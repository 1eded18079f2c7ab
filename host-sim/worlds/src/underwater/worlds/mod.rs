//! Random worlds under water, a different one for every seed: the test set for default settings in space.
//!
//! A world of the kind *data sheet* states what data sheets state: the camera's geometry and the noise of its pixels, of the
//! Doppler log, the gyroscope, the pressure sensor, and of roll and pitch, and the rate at which the vehicle changes its
//! velocity; for all else it states the defaults for any log ([`Nominal::of_instruments`]). It has the errors of real ones
//! ([`Misbehaviour`], each with its own switch and its own random numbers). A world of the kind *exact* states all of its noise,
//! and has no other errors.
//!
//! 4 to 40 m, in 150 to 240 s: two crossed lawnmowers over relief, circles around a structure, or loops over relief, up and down.
//! The camera looks down, down and ahead, or ahead; features, baseline and speed are in proportion to the size. Places are
//! revisited.

mod ground;
mod instruments;
mod keypoints;
mod misbehaviour;
mod optics;
mod plan;
#[cfg(test)]
mod tests;
mod way;

pub use misbehaviour::Misbehaviour;

use super::stereo;
use keypoints::Matcher;
use plan::Plan;
use scphd_log::log::{Scan, TruePose};
use scphd_log::underwater::{Camera, Landmark, Log, Nominal};

/// Statements of a world about itself, and therefore its possible errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The data sheets; all errors are present.
    DataSheet,
    /// All of its noise; there are no other errors.
    Exact,
}

pub fn world(kind: Kind, seed: u64) -> Log {
    match kind {
        Kind::DataSheet => misbehaving(seed, Misbehaviour::ALL),
        Kind::Exact => {
            let plan = Plan::exact(seed);
            Log { simulated: true, ..of_plan(&plan, Misbehaviour::NONE, seed, "worlds-space-exact", exactly(&plan)) }
        }
    }
}

/// The data sheet world with this seed, with only the errors in `misbehaviour`.
pub fn misbehaving(seed: u64, misbehaviour: Misbehaviour) -> Log {
    let plan = Plan::data_sheet(seed);
    of_plan(&plan, misbehaviour, seed, "worlds-space", by_data_sheet(&plan))
}

/// The size of this world, m.
pub fn size_m(seed: u64) -> f64 {
    Plan::data_sheet(seed).size_m
}

fn of_plan(plan: &Plan, misbehaviour: Misbehaviour, seed: u64, name: &str, nominal: Nominal) -> Log {
    let instruments = instruments::instruments(plan, misbehaviour, seed);
    let mut matcher = Matcher::new(plan, misbehaviour, seed);
    let rows = || plan.way.iter().enumerate();
    let scan = |(row, vehicle)| {
        let t_s = plan.time(row);
        Scan { t_s, detections: matcher.frame(t_s, vehicle), ..Scan::default() }
    };
    let scans = rows().step_by(plan.rows_per_scan).map(scan).collect();
    let truth = rows().map(|(row, vehicle)| TruePose {
        t_s: plan.time(row),
        position: vehicle.position.into(),
        heading_rad: Some(vehicle.yaw_rad),
    });
    let detectability = |own: f64| if misbehaviour.uneven_detection { own } else { plan.detection_probability };
    let landmarks = plan.features.iter().map(|feature| Landmark {
        position: feature.position.into(),
        detectability: detectability(feature.detectability),
    });
    let (optics, start) = (&plan.optics, &plan.way[0]);
    Log {
        name: format!("{name}-{seed}"),
        camera: Camera {
            projections: stereo::rows(&optics.projections()),
            size_px: optics.size_px,
            pixel_sigmas: [plan.pixel_sigma; 4],
            // Errors of roll and pitch move all pixels together.
            common_sigmas: [optics.focal_px * plan.tilt_sigma_rad; 2],
            depth_m: optics.depth_m,
            focal_baseline: optics.focal_px * optics.baseline_m,
            row_tolerance_px: optics.row_tolerance_px,
        },
        nominal,
        start: (start.position.into(), start.yaw_rad),
        simulated: false,
        instruments,
        scans,
        truth: truth.collect(),
        landmarks: landmarks.collect(),
    }
}

/// The noise of the instruments, and the greatest change of velocity. The yaw rate is that of the gyroscope.
fn by_data_sheet(plan: &Plan) -> Nominal {
    Nominal {
        velocity_walk_mps_rts: plan.velocity_walk(),
        ..Nominal::of_instruments(plan.velocity_sigma_mps, plan.z_sigma_m, plan.yaw_rate_sigma_radps)
    }
}

fn exactly(plan: &Plan) -> Nominal {
    Nominal {
        detection_probability: plan.detection_probability,
        clutter_per_scan: plan.clutter_per_scan,
        ..by_data_sheet(plan)
    }
}
