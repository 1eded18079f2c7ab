//! Simulation of the instruments for the true trajectory.

use super::misbehaviour::Misbehaviour;
use super::plan::Plan;
use super::way::Vehicle;
use crate::scenario::worlds::stream;
use libm::{atan2, exp, hypot, sin, sqrt};
use nalgebra::Vector3;
use scphd_log::angle::wrap;
use scphd_log::noise::Noise;
use scphd_log::underwater::Instruments;
use std::f64::consts::PI;

/// Initial bias of the gyroscope, rad/s, and its random walk, (rad/s)/√s: standard deviations.
const BIAS_RADPS: f64 = 0.001;
const BIAS_WALK: f64 = 0.0002;
/// Standard deviation of the scale error of a velocity.
const SCALE_SIGMA: f64 = 0.01;
/// Share of outliers among the velocities.
const OUTLIER_SHARE: f64 = 0.01;
/// Rate at which the Doppler log loses the bottom, 1/s, and the duration, s.
const OUTAGES_PER_SECOND: f64 = 1.0 / 60.0;
const OUTAGE_S: [f64; 2] = [2.0, 5.0];
/// Correlation time of errors of roll and pitch, s.
const TILT_S: f64 = 30.0;
/// White noise of the compass, and its constant error, rad.
const COMPASS_SIGMA_RAD: f64 = PI / 180.0;
const DEVIATION_RAD: f64 = 2.0 * PI / 180.0;
/// Distance over which the deflection by iron decays, relative to the size of the world.
const PULL_FADE_SHARE: f64 = 0.15;

/// State of the errors that continue from row to row.
struct Errors {
    bias_radps: f64,
    tilt_rad: [f64; 2],
    unlocked_until_s: f64,
}

/// The instruments of a world, row by row.
pub(super) fn instruments(plan: &Plan, misbehaviour: Misbehaviour, seed: u64) -> Vec<Instruments> {
    let [mut white, mut drift, mut constant, mut far_off, mut lost, mut lean] =
        [31, 32, 33, 34, 35, 36].map(|purpose| stream(seed, purpose));
    let mut scale = || if misbehaviour.velocity_scale { 1.0 + SCALE_SIGMA * constant.normal() } else { 1.0 };
    let scale = Vector3::new(scale(), scale(), scale());
    let deviation = DEVIATION_RAD * stream(seed, 37).normal();
    let mut errors = Errors {
        bias_radps: BIAS_RADPS * drift.normal(),
        tilt_rad: [(); 2].map(|()| lean.normal()),
        unlocked_until_s: f64::NEG_INFINITY,
    };
    let mut row_of = |(row, vehicle): (usize, &Vehicle)| {
        let t_s = plan.time(row);
        errors.step(plan, &mut drift, &mut lean);
        if lost.happens(OUTAGES_PER_SECOND * plan.row_s) {
            errors.unlocked_until_s = t_s + lost.between(OUTAGE_S[0], OUTAGE_S[1]);
        }
        let mut velocity = vehicle.velocity_mps.component_mul(&scale);
        velocity += Vector3::from_fn(|_, _| plan.velocity_sigma_mps * white.normal());
        let astray = Vector3::from_fn(|_, _| plan.speed_mps * far_off.normal());
        if far_off.happens(OUTLIER_SHARE) && misbehaviour.velocity_outliers {
            velocity += astray;
        }
        let unlocked = misbehaviour.velocity_outages && t_s < errors.unlocked_until_s;
        let tilt = if misbehaviour.tilt { errors.tilt_rad } else { [0.0; 2] };
        let bias = if misbehaviour.gyroscope_bias { errors.bias_radps } else { 0.0 };
        let off = if misbehaviour.compass { deviation + pull(plan, vehicle) } else { 0.0 };
        Instruments {
            t_s,
            roll_rad: vehicle.roll_rad + plan.tilt_sigma_rad * tilt[0],
            pitch_rad: vehicle.pitch_rad + plan.tilt_sigma_rad * tilt[1],
            yaw_rad: wrap(vehicle.yaw_rad + off + COMPASS_SIGMA_RAD * white.normal()),
            yaw_rate_radps: vehicle.yaw_rate_radps + bias + plan.yaw_rate_sigma_radps * white.normal(),
            yaw_rate_sigma_radps: None,
            velocity_mps: (row.is_multiple_of(plan.rows_per_velocity) && !unlocked).then(|| velocity.into()),
            z_m: Some(vehicle.position.z + plan.z_sigma_m * white.normal()),
        }
    };
    plan.way.iter().enumerate().map(&mut row_of).collect()
}

impl Errors {
    fn step(&mut self, plan: &Plan, drift: &mut Noise, lean: &mut Noise) {
        self.bias_radps += BIAS_WALK * sqrt(plan.row_s) * drift.normal();
        // The standard deviation is 1 at all times.
        let kept = exp(-plan.row_s / TILT_S);
        self.tilt_rad = self.tilt_rad.map(|tilt| kept * tilt + sqrt(1.0 - kept * kept) * lean.normal());
    }
}

/// Deflection of the compass by iron, rad: it attracts the needle.
fn pull(plan: &Plan, vehicle: &Vehicle) -> f64 {
    let pulls = plan.irons.iter().map(|iron| {
        let (dx, dy) = (iron.place[0] - vehicle.position.x, iron.place[1] - vehicle.position.y);
        let near = exp(-hypot(dx, dy) / (PULL_FADE_SHARE * plan.size_m));
        iron.pull_rad * near * sin(atan2(dy, dx) - vehicle.yaw_rad)
    });
    pulls.sum()
}
