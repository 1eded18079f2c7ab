//! Single rows of odometry that no vehicle drives: a counter that ran over, a byte that was lost.

use super::finding::{Findings, Motion, short};
use super::way::{SPEED_MPS, most};
use scphd::Plausible;

/// Names them, unless there are so many that the unit is to be doubted; whether there are any.
pub(super) fn look_over(motion: &[Motion], findings: &mut Findings) -> bool {
    let speed_mps = |row: &Motion| row.speed_mps.unwrap_or(0.0);
    let turn_radps = |row: &Motion| row.turn_radps.abs();
    // A white noise of single rows exceeds what a vehicle turns for long; a filter leaves out what no gyroscope measures.
    let turn_max_radps = Plausible::<f64>::default().turn_rate_max_radps;
    let (fast, turning) = (most(motion, speed_mps) <= SPEED_MPS, most(motion, turn_radps) <= turn_max_radps);
    let is_spike = |row: &Motion| (fast && speed_mps(row) > SPEED_MPS) || (turning && turn_radps(row) > turn_max_radps);
    let spikes: Vec<(usize, &Motion)> = motion.iter().enumerate().filter(|(_, row)| is_spike(row)).collect();
    let Some((index, row)) = spikes.first() else { return false };
    findings.warn(
        "odometry-spike",
        // The header is row 1.
        &format!("odometry.csv, row {}", index + 2),
        format!(
            "{} m/s and {} rad/s at {} s; {} of {} rows are faster than {SPEED_MPS} m/s or turn faster than {} rad/s, the others are not",
            short(speed_mps(row)),
            short(row.turn_radps),
            short(row.t_s),
            spikes.len(),
            motion.len(),
            short(turn_max_radps)
        ),
        "leave such rows out: the row before holds until the next one",
    );
    true
}
