//! Simulation of the odometry for the true trajectory.

use super::misbehaviour::Misbehaviour;
use super::plan::Plan;
use super::stream::stream;
use scphd_log::log::Odometry;

/// Standard deviation of the scale error of each control.
const SCALE_SIGMA: f64 = 0.02;
/// Standard deviation of the offset of the second control, rad or rad/s.
const OFFSET_SIGMA: f64 = 0.004;
/// Share of the rows in which the wheels slip.
const SLIP_SHARE: f64 = 0.01;

/// The measured controls.
pub(super) fn odometry(plan: &Plan, misbehaviour: Misbehaviour, seed: u64) -> Vec<Odometry> {
    let (mut white, mut constant, mut slip) = (stream(seed, 3), stream(seed, 4), stream(seed, 5));
    let mut drawn = |on: bool, sigma: f64| {
        let number = sigma * constant.normal();
        if on { number } else { 0.0 }
    };
    let scale = [(); 2].map(|()| 1.0 + drawn(misbehaviour.odometry_scale, SCALE_SIGMA));
    let offset = drawn(misbehaviour.odometry_offset, OFFSET_SIGMA);
    let rows = plan.controls.iter().enumerate().map(|(row, &[speed, turn])| {
        let excess = if slip.happens(SLIP_SHARE) { slip.uniform() } else { 0.0 };
        let slipped = if misbehaviour.slip { 1.0 + excess } else { 1.0 };
        let control = [
            speed * scale[0] * slipped + plan.speed_sigma_mps * white.normal(),
            turn * scale[1] + offset + plan.turn_sigma * white.normal(),
            0.0,
        ];
        Odometry { t_s: plan.time(row), control }
    });
    rows.collect()
}
