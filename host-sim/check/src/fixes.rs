//! Comparison of position fixes with dead reckoning: frame, unit, axes, noise, repeated rows.

use super::finding::{Findings, quantile, short};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Mounting, PoseFix};
use scphd_log::vehicle::Way;

/// Greatest distance of the first position from the start: the sum of a share of the sensor's range, standard deviations, and a
/// share of the distance driven.
const START_REACH: f64 = 0.25;
const START_SIGMAS: f64 = 5.0;
const START_WAY: f64 = 0.3;
/// Greatest ratio of distances: worn tyres and slip change a distance by tenths, a wrong unit by more than this.
const WAY_RATIO: f64 = 2.0;
/// Least length of the compared segments in standard deviations, and least number of segments.
const PIECE_SIGMAS: f64 = 10.0;
const PIECES: usize = 8;
/// A correlation of turns with those of dead reckoning below this means the opposite sign.
const TURNED_AROUND: f64 = -0.5;
/// Least share and number of repeated positions that are reported; noise does not repeat exactly.
const REPEATED_SHARE: f64 = 0.01;
const REPEATED: usize = 5;
/// Number of consecutive positions that are aligned with dead reckoning at a time.
const WINDOW: usize = 5;
/// Greatest scatter: this multiple of the stated noise, and this share of the distance driven, for the error of the odometry.
const SCATTER_TIMES: f64 = 4.0;
const SCATTER_WAY: f64 = 0.02;
/// Least number of windows.
const WINDOWS: usize = 10;

/// A measured position, and that of the antenna by dead reckoning.
#[derive(Debug, Clone, Copy)]
struct Both {
    t_s: f64,
    measured: [f64; 2],
    reckoned: [f64; 2],
}

pub(super) fn planar(log: &Log, reach_m: f64, findings: &mut Findings) {
    let (noise, way) = (&log.fix_noise, Way::of(log));
    let antenna = Mounting { forward_m: noise.forward_m, left_m: noise.left_m, yaw_rad: 0.0 };
    let positions = log.fixes.iter().filter_map(|fix| match fix.measured {
        PoseFix::Position(measured) => {
            let [x, y, _] = antenna.seat(way.at(fix.t_s));
            Some(Both { t_s: fix.t_s, measured, reckoned: [x, y] })
        }
        PoseFix::Heading(_) => None,
    });
    let all: Vec<Both> = positions.collect();
    let (Some(first), Some(sigma_m)) = (all.first(), noise.position_sigma_m) else { return };
    repeated(&all, sigma_m, findings);
    let pieces = pieces(&all, (PIECE_SIGMAS * sigma_m).max(START_REACH * reach_m));
    if pieces.len() >= PIECES && !ways_agree(&pieces, findings) {
        return;
    }
    let driven = distance(first.reckoned, log.initial_pose);
    let off = distance(first.reckoned, first.measured);
    if off > START_REACH * reach_m + START_SIGMAS * sigma_m + START_WAY * driven {
        findings.warn(
            "fix-frame",
            "fixes.csv, columns x_m and y_m",
            format!(
                "the first position, at {} s, is {} m from where the vehicle is by then",
                short(first.t_s),
                short(off)
            ),
            format!(
                "positions are in metres in the frame of initial_pose{}: shift them, or begin where they do",
                if all.iter().all(is_on_the_globe) && pieces.is_empty() {
                    " (these look like latitude and longitude in degrees)"
                } else {
                    ""
                }
            ),
        );
    }
    scatter(&all, sigma_m, findings);
}

fn is_on_the_globe(one: &Both) -> bool {
    one.measured[0].abs() <= 90.0 && one.measured[1].abs() <= 180.0
}

fn repeated(all: &[Both], sigma_m: f64, findings: &mut Findings) {
    // A receiver at rest with few decimals may repeat a position.
    let is_repeated = |pair: &&[Both]| {
        let moved = distance(pair[0].reckoned, pair[1].reckoned) > 0.1 * sigma_m;
        pair[0].measured == pair[1].measured && (moved || pair[0].t_s == pair[1].t_s)
    };
    let repeated = all.windows(2).filter(is_repeated).count();
    if repeated >= REPEATED && repeated as f64 > REPEATED_SHARE * all.len() as f64 {
        findings.warn(
            "fixes-doubled",
            "fixes.csv",
            format!("{repeated} of {} positions repeat the one before to the last digit while the vehicle moves", all.len()),
            "write each position once, with the time at which it was measured: a repeated one is taken for new evidence",
        );
    }
}

/// Chords of dead reckoning and of the positions between the same times, m.
fn pieces(all: &[Both], least_m: f64) -> Vec<[[f64; 2]; 2]> {
    let mut pieces = Vec::new();
    let Some(mut from) = all.first() else { return pieces };
    for to in all {
        let chord = |a: [f64; 2], b: [f64; 2]| [b[0] - a[0], b[1] - a[1]];
        let piece = [chord(from.reckoned, to.reckoned), chord(from.measured, to.measured)];
        if distance(from.reckoned, to.reckoned) >= least_m {
            pieces.push(piece);
            from = to;
        }
    }
    pieces
}

/// Whether unit and axes agree with those of dead reckoning.
fn ways_agree(pieces: &[[[f64; 2]; 2]], findings: &mut Findings) -> bool {
    let length = |chord: &[f64; 2]| libm::hypot(chord[0], chord[1]);
    let ratios = pieces.iter().map(|[reckoned, measured]| length(measured) / length(reckoned));
    let ratio = quantile(ratios.collect(), 0.5).unwrap_or(1.0);
    if !(1.0 / WAY_RATIO..=WAY_RATIO).contains(&ratio) {
        findings.warn(
            "fix-unit",
            "fixes.csv, columns x_m and y_m",
            format!("the way by positions is {} times that by odometry", short(ratio)),
            "positions are in metres: divide mm by 1000, cm by 100; latitude and longitude have to be turned into metres",
        );
        return false;
    }
    let turns = |of: usize| -> Vec<f64> {
        let direction = |piece: &[[f64; 2]; 2]| libm::atan2(piece[of][1], piece[of][0]);
        pieces.windows(2).map(|pair| wrap(direction(&pair[1]) - direction(&pair[0]))).collect()
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (own, of_fixes) = (turns(0), turns(1));
    let correlation = product(&own, &of_fixes) / (product(&own, &own) * product(&of_fixes, &of_fixes)).sqrt();
    if correlation < TURNED_AROUND {
        findings.warn(
            "fix-axes",
            "fixes.csv, columns x_m and y_m",
            format!(
                "positions turn left where the odometry turns right: correlation of the turns {}",
                short(correlation)
            ),
            "x and y of the positions are exchanged, as east and north may be, or the odometry turns the other way",
        );
        return false;
    }
    true
}

/// Reports positions that scatter around the trajectory far more than their stated noise.
fn scatter(all: &[Both], sigma_m: f64, findings: &mut Findings) {
    let windows: Vec<(f64, f64)> = all.windows(WINDOW).filter_map(scattered).collect();
    if windows.len() < WINDOWS {
        return;
    }
    let middle = |of: fn(&(f64, f64)) -> f64| quantile(windows.iter().map(of).collect(), 0.5).unwrap_or(0.0);
    let (scatter_m, way_m) = (middle(|one| one.0), middle(|one| one.1));
    if scatter_m > SCATTER_TIMES * sigma_m && scatter_m > SCATTER_WAY * way_m {
        findings.warn(
            "fix-noise",
            "log.toml, key fixes.position_sigma_m",
            format!("positions scatter by {} m around the way, {} m is stated", short(scatter_m), short(sigma_m)),
            "state the standard deviation of a position along either axis: what is beyond five of it is left out",
        );
    }
}

/// Standard deviation of the positions about the aligned (rotated, shifted, scaled) trajectory, and the length of the trajectory,
/// m; `None` at rest.
fn scattered(window: &[Both]) -> Option<(f64, f64)> {
    let n = window.len() as f64;
    let mean = |of: fn(&Both) -> [f64; 2]| {
        window.iter().map(of).fold([0.0; 2], |sum, one| [sum[0] + one[0] / n, sum[1] + one[1] / n])
    };
    let (p, q) = (mean(|one| one.reckoned), mean(|one| one.measured));
    let (mut of_p, mut of_q, mut along, mut across) = (0.0, 0.0, 0.0, 0.0);
    for one in window {
        let [a, b] =
            [[one.reckoned[0] - p[0], one.reckoned[1] - p[1]], [one.measured[0] - q[0], one.measured[1] - q[1]]];
        of_p += a[0] * a[0] + a[1] * a[1];
        of_q += b[0] * b[0] + b[1] * b[1];
        along += a[0] * b[0] + a[1] * b[1];
        across += a[0] * b[1] - a[1] * b[0];
    }
    let unexplained = of_q - (along * along + across * across) / of_p;
    let way_m: f64 = window.windows(2).map(|pair| distance(pair[0].reckoned, pair[1].reckoned)).sum();
    (of_p > 0.0).then(|| ((unexplained.max(0.0) / (2.0 * n - 4.0)).sqrt(), way_m))
}

fn distance(a: [f64; 2], b: impl AsRef<[f64]>) -> f64 {
    libm::hypot(b.as_ref()[0] - a[0], b.as_ref()[1] - a[1])
}

#[cfg(test)]
mod tests {
    use super::{Both, scattered};

    #[test]
    fn rotated_shifted_and_scaled_positions_do_not_scatter() {
        let at = |k: u32, off: f64| {
            let (x, y) = (f64::from(k), f64::from(k * k) / 10.0);
            Both { t_s: f64::from(k), reckoned: [x, y], measured: [100.0 - 1.1 * y, 1.1 * x + off] }
        };
        let scatter = |off: [f64; 5]| scattered(&[0, 1, 2, 3, 4].map(|k| at(k, off[k as usize]))).unwrap();
        let (none, way_m) = scatter([0.0; 5]);
        assert!(none < 1e-6 && way_m > 4.0, "{none} {way_m}");
        let (one, _) = scatter([0.0, 0.0, 1.0, 0.0, 0.0]);
        // A shift explains a part of a square of 0.8 over the six remaining degrees of freedom.
        assert!((0.2..=(0.8_f64 / 6.0).sqrt()).contains(&one), "{one}");
    }
}
