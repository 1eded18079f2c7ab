//! Errors of a trajectory over the scans with truth.

use crate::alignment::Motion;
use crate::record::ScanRecord;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Coordinates, Dimensions};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectoryScore {
    /// Number of scans with a true position; all figures are over these.
    pub scans: usize,
    pub position_rmse_m: f64,
    /// Root mean square heading error, degrees; `None` if no scan has a true heading.
    pub heading_rmse_deg: Option<f64>,
    /// Distance from the true position at the last of these scans, m.
    pub final_position_error_m: f64,
}

/// Score of poses (a position, m, then the heading, rad, if there is one), each with its true position (m) and, if known, true
/// heading (rad).
///
/// `None` without poses.
pub fn score<C: Coordinates, P: Coordinates>(
    poses: impl IntoIterator<Item = (C, P, Option<f64>)>,
) -> Option<TrajectoryScore> {
    let (mut scans, mut squares, mut last) = (0_usize, 0.0, 0.0);
    let (mut headings, mut heading_squares) = (0_usize, 0.0);
    for (pose, position, true_heading) in poses {
        let pose = pose.as_ref();
        last = pose.iter().zip(position.as_ref()).map(|(own, truth)| (own - truth) * (own - truth)).sum();
        squares += last;
        scans += 1;
        if let Some((heading, true_heading)) = pose.get(P::COUNT).zip(true_heading) {
            let error = wrap(heading - true_heading);
            heading_squares += error * error;
            headings += 1;
        }
    }
    if scans == 0 {
        return None;
    }
    Some(TrajectoryScore {
        scans,
        position_rmse_m: (squares / scans as f64).sqrt(),
        heading_rmse_deg: (headings > 0).then(|| (heading_squares / headings as f64).sqrt().to_degrees()),
        final_position_error_m: last.sqrt(),
    })
}

pub fn of_estimate<D: Dimensions>(scans: &[ScanRecord<D>]) -> Option<TrajectoryScore> {
    score(covered(scans, |scan| scan.pose))
}

/// Root mean square distance, m, of the estimated positions from the true ones after the best rotation about the vertical and
/// shift: the absolute trajectory error of Sturm et al. 2012, which does not depend on the initial pose in the log. `None` if
/// fewer than three scans have a true position: two points fit any two.
pub fn aligned_rmse_m<D: Dimensions>(scans: &[ScanRecord<D>]) -> Option<f64> {
    let position = |pose: D::Pose| D::Position::with(|k| pose.as_ref()[k]);
    let pairs: Vec<_> = covered(scans, |scan| scan.pose).map(|(pose, truth, _)| (position(pose), truth)).collect();
    let motion = Motion::fit(&pairs).filter(|_| pairs.len() > 2)?;
    let squared = |(own, truth): &(D::Position, D::Position)| -> f64 {
        let moved = motion.apply(*own);
        moved.as_ref().iter().zip(truth.as_ref()).map(|(own, truth)| (own - truth) * (own - truth)).sum()
    };
    Some((pairs.iter().map(squared).sum::<f64>() / pairs.len() as f64).sqrt())
}

/// Score of dead reckoning over the same scans.
pub fn of_dead_reckoning<D: Dimensions>(scans: &[ScanRecord<D>]) -> Option<TrajectoryScore> {
    score(covered(scans, |scan| scan.dead_reckoning))
}

fn covered<D: Dimensions, C>(
    scans: &[ScanRecord<D>],
    pose: impl Fn(&ScanRecord<D>) -> C,
) -> impl Iterator<Item = (C, D::Position, Option<f64>)> {
    scans.iter().filter_map(move |scan| Some((pose(scan), scan.true_position?, scan.true_heading_rad)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(pose: [f64; 3], true_position: Option<[f64; 2]>, true_heading_rad: Option<f64>) -> ScanRecord {
        let dead_reckoning = [1.0, 1.0, 0.0];
        ScanRecord { dead_reckoning, true_position, true_heading_rad, ..ScanRecord::at(0.0, pose) }
    }

    #[test]
    fn closed_form() {
        let scans = [
            record([3.0, 4.0, 3.1], Some([0.0, 0.0]), Some(-3.1)),
            record([1.0, 0.0, 0.0], Some([1.0, 1.0]), None),
            record([9.0, 9.0, 9.0], None, None),
        ];
        let s = of_estimate(&scans).unwrap();
        assert_eq!(s.scans, 2);
        assert!((s.position_rmse_m - 13.0_f64.sqrt()).abs() < 1e-15);
        // The heading error is computed across π, not across 0.
        let expected = (2.0 * std::f64::consts::PI - 6.2).to_degrees();
        assert!((s.heading_rmse_deg.unwrap() - expected).abs() < 1e-12);
        assert_eq!(s.final_position_error_m, 1.0);
        let d = of_dead_reckoning(&scans).unwrap();
        assert_eq!((d.position_rmse_m, d.final_position_error_m), (1.0, 0.0));
    }

    #[test]
    fn the_aligned_error_of_a_rotated_trajectory_is_that_of_the_original() {
        let (s, c) = libm::sincos(0.4);
        let truth = [[0.0, 0.0], [4.0, 1.0], [7.0, 5.0], [2.0, 9.0]];
        let turned = |[x, y]: [f64; 2]| [c * x - s * y + 3.0, s * x + c * y - 2.0, 0.4];
        let scans: Vec<_> = truth.iter().map(|&place| record(turned(place), Some(place), None)).collect();
        assert!(aligned_rmse_m(&scans).unwrap() < 1e-12 && of_estimate(&scans).unwrap().position_rmse_m > 2.0);
        assert_eq!(aligned_rmse_m(&scans[..2]), None);
        // On a line the shift removes the mean of the errors: −1, −1, 2 remain of 0, 0, 3.
        let line =
            [(0.0, 0.0), (10.0, 0.0), (20.0, 3.0)].map(|(x, off)| record([x + off, 0.0, 0.0], Some([x, 0.0]), None));
        assert!((aligned_rmse_m(&line).unwrap() - 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn without_truth_there_is_no_score() {
        assert_eq!(of_estimate(&[record([0.0; 3], None, None)]), None);
        let no_heading = of_estimate(&[record([0.0; 3], Some([0.0, 0.0]), None)]).unwrap();
        assert_eq!(no_heading.heading_rmse_deg, None);
    }
}
