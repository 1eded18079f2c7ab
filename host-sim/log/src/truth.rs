//! The truth at a time: trajectory, map, and tracks of moving landmarks.

pub mod tracks;

use crate::angle::wrap;
use crate::dimensions::{Coordinates, Dimensions};
use crate::log::TruePose;

/// Greatest interval between two rows of truth for interpolation, s.
///
/// Simulated logs have a row at least each second, the tracks of the indoor robots one each 0.4 s. The GPS of Victoria Park has
/// five rows a second. It omits a few fixes now and then: over two seconds of the sharpest turn at a few m/s, a straight line has
/// an error below half a metre. And it fails for up to 58 s under trees, where a straight line would not be the driven path. Two
/// seconds permit the former and exclude the latter.
pub const MAX_GAP_S: f64 = 2.0;

/// The true pose at `t_s`, interpolated linearly in time between two rows, the heading along the shorter arc.
///
/// `None` outside the time of `truth` and inside gaps longer than [`MAX_GAP_S`]. The heading is unknown unless both rows have it.
/// `truth` is in order of time; at the time of a row the result is that row.
pub fn at<D: Dimensions>(truth: &[TruePose<D>], t_s: f64) -> Option<TruePose<D>> {
    let after = truth.partition_point(|row| row.t_s <= t_s);
    let before = truth.get(after.checked_sub(1)?)?;
    if before.t_s == t_s {
        return Some(*before);
    }
    let next = truth.get(after)?;
    let gap_s = next.t_s - before.t_s;
    if gap_s > MAX_GAP_S {
        return None;
    }
    let f = (t_s - before.t_s) / gap_s;
    let (from, to) = (before.position.as_ref(), next.position.as_ref());
    Some(TruePose {
        t_s,
        position: D::Position::with(|k| from[k] + f * (to[k] - from[k])),
        heading_rad: before.heading_rad.zip(next.heading_rad).map(|(a, b)| wrap(a + f * wrap(b - a))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dimensions::Planar;

    fn row(t_s: f64, x: f64, heading_rad: Option<f64>) -> TruePose {
        TruePose { t_s, position: [x, -x], heading_rad }
    }

    #[test]
    fn rows_are_exact_and_interpolation_is_linear() {
        let truth = [row(1.0, 0.0, Some(3.0)), row(2.0, 4.0, Some(-3.0)), row(3.0, 5.0, None)];
        assert_eq!(at(&truth, 1.0), Some(truth[0]));
        assert_eq!(at(&truth, 3.0), Some(truth[2]));
        let quarter = at(&truth, 1.25).unwrap();
        assert_eq!(quarter.position, [1.0, -1.0]);
        // The shorter arc from 3 to −3 is across π: a quarter of 2π − 6 from 3.
        let expected = 3.0 + 0.25 * (2.0 * std::f64::consts::PI - 6.0);
        assert!((quarter.heading_rad.unwrap() - expected).abs() < 1e-14);
        assert_eq!(at(&truth, 2.5).unwrap().heading_rad, None);
    }

    #[test]
    fn no_truth_outside_its_time_and_inside_long_gaps() {
        let truth = [row(1.0, 0.0, None), row(3.0, 1.0, None), row(5.5, 2.0, None)];
        assert_eq!(at(&truth, 0.999), None);
        assert_eq!(at(&truth, 5.501), None);
        assert_eq!(at(&truth, 2.0).unwrap().position, [0.5, -0.5]);
        assert_eq!(at(&truth, 4.0), None);
        assert_eq!(at(&truth, 5.5), Some(truth[2]));
        assert_eq!(at::<Planar>(&[], 0.0), None);
    }

    #[test]
    fn two_rows_at_one_time_do_not_divide_by_zero() {
        let truth = [row(1.0, 0.0, None), row(1.0, 2.0, None), row(2.0, 4.0, None)];
        assert_eq!(at(&truth, 1.0), Some(truth[1]));
        assert_eq!(at(&truth, 1.5).unwrap().position, [3.0, -3.0]);
    }
}
