//! Single rows of odometry that no vehicle can drive: an overflow of a counter, or a lost byte.

use super::finding::{Findings, Motion, quantile, short};
use super::way::{SPEED_MPS, most};
use scphd::settings::Plausible;

/// A row is a spike if it exceeds both neighbours by more than this multiple of the 99 % quantile of the steps between rows, and
/// by more than the 99 % quantile of the rows. For normal noise that is fifteen standard deviations of a step; real vehicles
/// brake and start over several rows, and slipping wheels at most double the distance.
const TIMES: f64 = 6.0;
const MOST_STEPS: f64 = 0.99;
/// Least number of steps for such a quantile.
const STEPS: usize = 20;
/// Spikes are rare: with more than one in this number of rows, it is the kind of odometry.
const RARE: usize = 200;
/// Spikes that displace dead reckoning by this share of the sensor's range, or by this angle, rad, prevent other checks of it.
const CARRIED_REACH: f64 = 0.1;
const CARRIED_RAD: f64 = 0.3;

/// Reports spikes, unless there are so many that the unit is doubtful. Returns whether any displaces dead reckoning.
pub(super) fn look_over(motion: &[Motion], reach_m: f64, findings: &mut Findings) -> bool {
    let speed_mps = |row: &Motion| row.speed_mps.unwrap_or(0.0);
    // White noise of single rows may exceed the sustained turn rates of vehicles; a filter drops only rates that no gyroscope
    // measures.
    let turn_max_radps = Plausible::<f64>::default().turn_rate_max_radps;
    let mut spikes = beyond(motion, speed_mps, SPEED_MPS);
    spikes.extend(beyond(motion, |row| row.turn_radps.abs(), turn_max_radps));
    spikes.extend(standing_out(motion, speed_mps));
    spikes.extend(standing_out(motion, |row| row.turn_radps));
    spikes.sort_unstable();
    spikes.dedup();
    let Some(&index) = spikes.first() else { return false };
    let row = &motion[index];
    let told = |row: &Motion| format!("{} m/s and {} rad/s", short(speed_mps(row)), short(row.turn_radps));
    let beside = motion.get(index + 1).or_else(|| motion.get(index.checked_sub(1)?)).map_or(String::new(), told);
    findings.warn(
        "odometry-spike",
        // The header is row 1.
        &format!("odometry.csv, row {}", index + 2),
        format!(
            "{} at {} s, and {beside} in the row beside it; {} of {} rows stand out so from both neighbours, or beyond {SPEED_MPS} m/s or {} \
             rad/s",
            told(row),
            short(row.t_s),
            spikes.len(),
            motion.len(),
            short(turn_max_radps)
        ),
        "leave such rows out: the row before holds until the next one",
    );
    let lasts_s = |index: usize| motion.get(index + 1).map_or(0.0, |next| next.t_s - motion[index].t_s);
    let carried =
        |of: &dyn Fn(&Motion) -> f64| -> f64 { spikes.iter().map(|&index| of(&motion[index]) * lasts_s(index)).sum() };
    carried(&speed_mps) > CARRIED_REACH * reach_m || carried(&|row| row.turn_radps.abs()) > CARRIED_RAD
}

/// Rows beyond a physical limit; none if most rows are.
fn beyond(motion: &[Motion], of: impl Fn(&Motion) -> f64, limit: f64) -> Vec<usize> {
    if most(motion, &of) > limit {
        return Vec::new();
    }
    (0..motion.len()).filter(|&index| of(&motion[index]) > limit).collect()
}

/// Rows that differ from both neighbours, in the same direction, by far more than other rows do.
fn standing_out(motion: &[Motion], of: impl Fn(&Motion) -> f64) -> Vec<usize> {
    let at = |index: usize| of(&motion[index]);
    let height = |index: usize| {
        let (from, to) = (at(index) - at(index - 1), at(index) - at(index + 1));
        (from * to > 0.0).then_some((index, from.abs().min(to.abs())))
    };
    let mut peaks: Vec<(usize, f64)> = (1..motion.len().saturating_sub(1)).filter_map(height).collect();
    peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
    peaks.truncate(motion.len() / RARE + 2);
    // Steps at the highest peaks are left out, and zeros: rows of a vehicle at rest, or of a coarse encoder, are equal.
    let is_elsewhere = |index: usize| !peaks.iter().any(|(peak, _)| *peak == index || *peak == index + 1);
    let steps = (0..motion.len().saturating_sub(1)).filter(|&index| is_elsewhere(index));
    let steps: Vec<f64> = steps.map(|index| (at(index + 1) - at(index)).abs()).filter(|step| *step > 0.0).collect();
    if steps.len() < STEPS {
        return Vec::new();
    }
    let usual = quantile((0..motion.len()).map(|index| at(index).abs()).collect(), MOST_STEPS);
    let step = quantile(steps, MOST_STEPS);
    let least = step.zip(usual).map_or(f64::INFINITY, |(step, usual)| usual.max(TIMES * step));
    let found: Vec<usize> = peaks.iter().filter(|peak| peak.1 > least).map(|peak| peak.0).collect();
    if found.len() * RARE > motion.len() + RARE { Vec::new() } else { found }
}
